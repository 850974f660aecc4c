"""Reading XML strictly: every value is checked, every error names the tag and what holds it."""

import math
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

from mrs_simulator.scenario.reading import LARGEST_FILE, ScenarioError, reason, shown, unwanted


def read_text(path):
    """Return the text of the file at ``path``; ``ScenarioError`` if it cannot be read."""
    try:
        if os.path.getsize(path) > LARGEST_FILE:
            raise ScenarioError("{}: larger than {} bytes".format(path, LARGEST_FILE))
        with open(path, encoding="utf-8") as file:
            return file.read()
    except ScenarioError:
        raise
    except (OSError, ValueError) as error:
        raise ScenarioError("{}: cannot be read: {}".format(path, reason(error))) from None


def parse_xml(text, where):
    """Return the root element of ``text``; ``where`` names it in errors."""
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise ScenarioError("{}: not valid XML: {}".format(where, error)) from None


class Tag:
    """An element and where it is, for error messages."""

    def __init__(self, element, where):
        """``where``: the file and, for instance, ``link 'base_link'``."""
        self.element, self.where = element, where

    def child(self, name):
        """Return the child ``name`` as a ``Tag``, None if there is none."""
        found = self.element.find(name)
        return None if found is None else Tag(found, "{}: {}".format(self.where, name))

    def needed(self, name):
        """Return the child ``name``; ``ScenarioError`` if there is none."""
        found = self.child(name)
        if found is None:
            raise ScenarioError("{}: wanted a tag <{}>".format(self.where, name))
        return found

    def children(self, name):
        """Return all children ``name``, named with their own names where they have one."""
        return [
            Tag(each, "{}: {}".format(self.where, _titled(each)))
            for each in self.element.findall(name)
        ]

    def attribute(self, name, default=None):
        """Return the attribute ``name``; ``ScenarioError`` if it is missing and has no default."""
        value = self.element.get(name, default)
        if value is None:
            raise ScenarioError("{}: wanted an attribute {}".format(self.where, name))
        return value

    def numbers(self, name, count, default=None, above=None, low=None):
        """Return the attribute ``name`` as ``count`` finite numbers, (count,)."""
        text = self.attribute(name, default)
        return numbers(text, count, "{}: {}".format(self.where, name), above=above, low=low)

    def number(self, name, default=None, above=None, low=None):
        """Return the attribute ``name`` as a finite number."""
        return float(self.numbers(name, 1, default, above=above, low=low)[0])

    def text(self, name):
        """Return the text of the child ``name``, None if there is none or it is empty."""
        found = self.element.find(name)
        text = (found.text or "").strip() if found is not None else ""
        return text or None


def numbers(text, count, where, above=None, low=None):
    """Return the ``count`` finite numbers in ``text``, (count,); ``ScenarioError`` says what is wrong."""
    try:
        values = [float(part) for part in text.split()]
    except ValueError:
        values = []
    fits = len(values) == count and all(map(math.isfinite, values))
    fits = fits and (above is None or min(values) > above) and (low is None or min(values) >= low)
    if not fits:
        wanted = "a number" if count == 1 else "{} numbers".format(count)
        wanted += "" if above is None else " above {:g}".format(above)
        wanted += "" if low is None else " of at least {:g}".format(low)
        raise unwanted(where, text, wanted)
    return np.array(values)


def _titled(element):
    name = element.get("name")
    return element.tag if name is None else "{} {}".format(element.tag, shown(name))


def numbers_text(numbers):
    """Return ``numbers`` as an attribute of URDF has them."""
    return " ".join(repr(float(number)) for number in numbers)
