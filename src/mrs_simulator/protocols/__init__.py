"""The shipped protocols: a name for each, and the class behind it."""

import importlib
import os
import re

# A protocol's class, in a family's folder, states its theorem in a paragraph of its docstring.
CLASS = re.compile(r'\nclass ([A-Z]\w*)\([^)]*\):\n    """(.*?)"""', re.S)
THEOREM = "\n    Theorem: "
WORD = re.compile(r"(?<!^)(?=[A-Z])")


def _found():
    """Yield the name of each shipped protocol, and its module and class."""
    folder = os.path.dirname(__file__)
    for family in sorted(os.listdir(folder)):
        path = os.path.join(folder, family)
        for file in sorted(os.listdir(path)) if os.path.isdir(path) else ():
            if file.endswith(".py"):
                with open(os.path.join(path, file), encoding="utf-8") as source:
                    text = source.read()
                for title, doc in CLASS.findall(text) if THEOREM in text else ():
                    if THEOREM in doc:
                        yield WORD.sub("_", title).lower(), (family + "." + file[:-3], title)


# Scenarios, launch files and the GUI name them so: the class's name in small letters.
HOMES = dict(sorted(_found()))


def shipped(name):
    """Return the class of the shipped protocol called ``name``; ``KeyError`` if there is none."""
    module, class_name = HOMES[name]
    return getattr(importlib.import_module("mrs_simulator.protocols." + module), class_name)
