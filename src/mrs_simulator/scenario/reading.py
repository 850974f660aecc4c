"""Strict reading of YAML files: unknown keys refused, every value checked, errors with their place."""

import json
import os
import re
import stat
from collections import namedtuple

import yaml

from mrs_simulator.core.fields import (
    EACH,
    FLAG,
    NUMBER,
    NUMBERS,
    REQUIRED,
    TEXT,
    WHOLE,
    Field,
    shown,
    unknown_name,
)

LARGEST_FILE = 4 * 1024 * 1024  # [bytes], far above any scenario; guards against a wrong file
LONGEST_MESSAGE = 1000  # [characters]
MOST_ALIASED = 100000  # [-] values that all aliases of a text may stand for


class ScenarioError(ValueError):
    """A scenario that cannot be used: says where, what came and what was wanted.

    Names in it may be as long as a file: the message ends after ``LONGEST_MESSAGE``.
    """

    page = "docs/scenarios.md"

    def __init__(self, message):
        cut = message[:LONGEST_MESSAGE] + "..."
        super().__init__(message if len(message) <= LONGEST_MESSAGE else cut)


class UnknownKey(ScenarioError):
    """A key that no scenario has there; the message names the nearest one that one may have."""


def unwanted(where, value, wanted):
    """Return the ``ScenarioError`` of ``value`` at ``where`` that is not what is ``wanted``."""
    return ScenarioError("{}: {}, wanted {}".format(where, shown(value), wanted))


class _Loader(yaml.SafeLoader):
    """Safe loader that refuses repeated keys, bounds aliases, and reads 1e-3 as a number."""

    def __init__(self, stream):
        super().__init__(stream)
        self._composed, self._sizes = 0, {}

    def compose_node(self, parent, index):
        """Return the next node; aliases of too many values, or of themselves, are refused.

        A few nested aliases can stand for billions of values, each visited when the content is read.
        """
        alias = self.check_event(yaml.events.AliasEvent)
        mark = self.peek_event().start_mark
        node = super().compose_node(parent, index)
        if not alias:
            self._composed += 1
            self._sizes[id(node)] = 1 + sum(self._sizes[id(child)] for child in _children(node))
        if id(node) not in self._sizes:
            raise yaml.composer.ComposerError(None, None, "an alias stands for itself", mark)
        if self._sizes[id(node)] - self._composed > MOST_ALIASED:
            text = "the aliases stand for more than {} values".format(MOST_ALIASED)
            raise yaml.composer.ComposerError(None, None, text, mark)
        return node

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            try:
                again = key in seen
                seen.add(key)
            except TypeError:
                raise yaml.constructor.ConstructorError(
                    None, None, "a key must be a text", key_node.start_mark
                ) from None
            if again:
                raise yaml.constructor.ConstructorError(
                    None, None, "key {} is given twice".format(shown(key)), key_node.start_mark
                )
        return super().construct_mapping(node, deep=deep)


def _children(node):
    """Return the nodes that ``node`` holds directly."""
    if isinstance(node, yaml.MappingNode):
        return [child for pair in node.value for child in pair]
    return node.value if isinstance(node, yaml.SequenceNode) else []


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def load_yaml(path):
    """Return the content of the YAML file at ``path``; ``ScenarioError`` says what is wrong."""
    try:
        refuse_special(path)
        with open(path, encoding="utf-8") as file:
            text = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise ScenarioError("{}: cannot be read: {}".format(path, reason(error))) from None
    return parse_yaml(text, path)


def refuse_special(path):
    """Raise ``OSError`` where ``path`` is no regular file: a pipe or a device may never end."""
    kind = os.stat(path).st_mode
    if stat.S_ISDIR(kind):
        raise IsADirectoryError("is a directory, wanted a file")
    if not stat.S_ISREG(kind):
        raise OSError("is a pipe or a device, wanted a regular file")


def read_json(path):
    """Return the content of the JSON file at ``path``; ``ValueError`` or ``OSError`` if it has none."""
    refuse_special(path)
    with open(path, encoding="utf-8") as file:
        try:
            return json.load(file, parse_constant=_refuse_constant)
        except RecursionError:
            raise ValueError("lists or mappings too deep in one another") from None


def _refuse_constant(name):
    raise ValueError("{}, wanted a finite number".format(name))


def parse_yaml(text, where):
    """Return the content of YAML ``text``; ``where`` names it in errors."""
    if len(text) > LARGEST_FILE:
        raise ScenarioError("{}: larger than {} bytes".format(where, LARGEST_FILE))
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = ", line {}".format(mark.line + 1) if mark else ""
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise ScenarioError("{}{}: not valid YAML: {}".format(where, line, problem)) from None
    except (ValueError, OverflowError, RecursionError) as error:
        raise ScenarioError("{}: not valid YAML: {}".format(where, reason(error))) from None


class Section:
    """A mapping read key by key; ``done`` refuses keys that were not read."""

    def __init__(self, content, where, n=None):
        """``content`` must be a mapping; ``where``: file and key path for errors; n: number of robots."""
        if content is None:
            content = {}
        if not isinstance(content, dict):
            raise unwanted(where, content, "a mapping")
        self._content = content
        self.where = where
        self._read = []
        self.n = n

    def at(self, key):
        """Return where ``key`` is, for an error message."""
        if ": " not in self.where:
            return "{}: {}".format(self.where, key)
        return "{}.{}".format(self.where, key)

    def take(self, key, default=None):
        """Return the raw value of ``key``."""
        self._read.append(key)
        value = self._content.get(key)
        return default if value is None else value

    def has(self, key):
        """Return whether ``key`` is given."""
        return self._content.get(key) is not None

    def field(self, field):
        """Return the value of the declared ``field``, its default where none is given."""
        value = self.take(field.name)
        if value is None and field.rule != REQUIRED:
            return field.default
        return fitting(field, value, self.at(field.name), self.n)

    def values(self, fields, others=None, **found):
        """Return the values of all of ``fields``, by name, and those ``found``; other keys are refused.

        ``others``: what fields are read by, too, and is not returned.
        """
        for field in fields:
            known = {**others, **found} if others else found
            found[field.name] = field.read(self, known) if field.read else self.field(field)
        self.done()
        return found

    def number(self, key, default=None, low=None, high=None, above=None):
        """Return a finite number in [low, high], or above ``above``."""
        return number(self.take(key, default), self.at(key), low=low, high=high, above=above)

    def whole(self, key, default=None, low=None, high=None):
        """Return a whole number in [low, high]."""
        return self._given(Field(key, default, low=low, high=high, type=WHOLE))

    def text(self, key, default=None, choices=None):
        """Return a text, one of ``choices`` if given."""
        return self._given(Field(key, default, choices=tuple(choices or ()), type=TEXT))

    def flag(self, key, default):
        """Return true or false."""
        return self._given(Field(key, default, type=FLAG))

    def _given(self, field):
        return fitting(field, self.take(field.name, field.default), self.at(field.name))

    def numbers(self, key, count):
        """Return a list of ``count`` finite numbers."""
        return number_list(self.take(key), count, self.at(key))

    def items(self, key, wanted):
        """Return where each item of the list ``key`` is, and the item; none where it is not given."""
        given, where = self.take(key, []), self.at(key)
        if not isinstance(given, list):
            raise unwanted(where, given, wanted)
        return [("{}[{}]".format(where, index), item) for index, item in enumerate(given)]

    def done(self):
        """Refuse keys that were not read; the error names the nearest known one."""
        for key in self._content:
            if key not in self._read:
                raise UnknownKey(unknown_name(self.where, key, self._read))


def fitting(field, value, where, n=None):
    """Return ``value`` as ``field`` declares it; else ``ScenarioError`` with the place ``where`` it is."""
    result = field.typed(value, n)
    if result is not None:
        return result
    if field.kind in (NUMBERS, EACH) and isinstance(value, list):
        one = field._replace(type=NUMBER)
        for index, item in enumerate(value if len(value) in (field.sizes or (n,)) else ()):
            fitting(one, item, "{}[{}]".format(where, index))
    raise unwanted(where, value, field.wanted(n))


def number(value, where, low=None, high=None, above=None):
    """Return ``value`` as float if it is a finite number in range; else ``ScenarioError``."""
    low, is_open = (low, False) if above is None else (above, True)
    return fitting(Field("", None, "", low, high, is_open, type=NUMBER), value, where)


def number_list(value, count, where):
    """Return ``value`` as a list of ``count`` finite floats; else ``ScenarioError``."""
    return list(fitting(Field("", type=NUMBERS, sizes=(count,)), value, where))


def record(name, fields, before=(), after=None):
    """Return a named tuple of the values of ``fields``, with their defaults.

    ``before``: names of further values, without defaults; ``after``: those of more, by name.
    """
    defaults = dict({field.name: field.default for field in fields}, **(after or {}))
    return namedtuple(name, (*before, *defaults), defaults=defaults.values())


def written(values, fields, n=None):
    """Return what a file holds of the ``record`` ``values``, with n robots, by name.

    Nothing, and a default that is stated as a rule, are left out.
    """
    plain = {}
    for field in fields:
        value = getattr(values, field.name)
        is_left_out = bool(field.rule) or field.default is None
        if not is_left_out or value != field.default:
            plain[field.name] = field.plain(value, n) if field.plain else as_plain(value)
    return plain


def as_plain(value):
    """Return ``value`` as a file holds it."""
    if hasattr(value, "to_plain"):
        return value.to_plain()
    return [as_plain(each) for each in value] if isinstance(value, tuple) else value


def reason(error):
    """Return why a file cannot be read, without its name and the error's number."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
