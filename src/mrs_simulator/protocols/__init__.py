"""The shipped protocols: a name for each, and the class behind it."""

import importlib
import os
import re

# A class of a family's folder whose docstring states its theorem, in a paragraph of its own.
PROTOCOL = re.compile(
    r'^class ([A-Z]\w*)\([^)]*\):\n    """(?:(?!""").)*?\n    Theorem: ', re.M | re.S
)
WORD = re.compile(r"(?<!^)(?=[A-Z])")


def _found():
    """Yield the name of each shipped protocol, and its module and class."""
    folder = os.path.dirname(__file__)
    for family in sorted(os.listdir(folder)):
        path = os.path.join(folder, family)
        for file in sorted(os.listdir(path)) if os.path.isdir(path) else ():
            if file.endswith(".py"):
                with open(os.path.join(path, file), encoding="utf-8") as source:
                    for title in PROTOCOL.findall(source.read()):
                        yield WORD.sub("_", title).lower(), (family + "." + file[:-3], title)


# Scenarios, launch files and the GUI name them so: the class's name in small letters.
HOMES = dict(sorted(_found()))


def shipped(name):
    """Return the class of the shipped protocol called ``name``; ``KeyError`` if there is none."""
    module, class_name = HOMES[name]
    return getattr(importlib.import_module("mrs_simulator.protocols." + module), class_name)
