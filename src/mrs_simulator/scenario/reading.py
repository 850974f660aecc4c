"""Strict reading of YAML files: unknown keys refused, every value checked, errors with their place."""

import json
import math
import os
import re
import stat

import yaml

from mrs_simulator.core.fields import shown, unknown_name

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

    def __init__(self, content, where):
        """``content`` must be a mapping; ``where`` is the file and key path for errors."""
        if content is None:
            content = {}
        if not isinstance(content, dict):
            raise ScenarioError("{}: {}, wanted a mapping".format(where, shown(content)))
        self._content = content
        self._where = where
        self._read = []

    def at(self, key):
        """Return where ``key`` is, for an error message."""
        return (
            "{}: {}".format(self._where, key)
            if ": " not in self._where
            else ("{}.{}".format(self._where, key))
        )

    def take(self, key, default=None):
        """Return the raw value of ``key``."""
        self._read.append(key)
        value = self._content.get(key)
        return default if value is None else value

    def has(self, key):
        """Return whether ``key`` is given."""
        return self._content.get(key) is not None

    def number(self, key, default=None, low=None, high=None, above=None):
        """Return a finite number in [low, high], or above ``above``."""
        value = self.take(key, default)
        return number(value, self.at(key), low=low, high=high, above=above)

    def whole(self, key, default=None, low=None, high=None):
        """Return a whole number in [low, high]."""
        value = self.take(key, default)
        fits = isinstance(value, int) and not isinstance(value, bool)
        fits = fits and (low is None or value >= low) and (high is None or value <= high)
        if not fits:
            raise ScenarioError(
                "{}: {}, wanted a whole number{}".format(
                    self.at(key), shown(value), _range(low, high)
                )
            )
        return value

    def text(self, key, default=None, choices=None):
        """Return a text, one of ``choices`` if given."""
        value = self.take(key, default)
        if not isinstance(value, str) or (choices and value not in choices):
            wanted = "one of " + ", ".join(choices) if choices else "a text"
            raise ScenarioError("{}: {}, wanted {}".format(self.at(key), shown(value), wanted))
        return value

    def flag(self, key, default):
        """Return true or false."""
        value = self.take(key, default)
        if not isinstance(value, bool):
            raise ScenarioError("{}: {}, wanted true or false".format(self.at(key), shown(value)))
        return value

    def numbers(self, key, count):
        """Return a list of ``count`` finite numbers."""
        return number_list(self.take(key), count, self.at(key))

    def done(self):
        """Refuse keys that were not read; the error names the nearest known one."""
        for key in self._content:
            if key not in self._read:
                raise ScenarioError(unknown_name(self._where, key, self._read))


def number(value, where, low=None, high=None, above=None):
    """Return ``value`` as float if it is a finite number in range; else ``ScenarioError``."""
    fits = isinstance(value, (int, float)) and not isinstance(value, bool)
    try:
        fits = fits and math.isfinite(float(value))
    except OverflowError:
        fits = False
    fits = fits and (low is None or value >= low) and (high is None or value <= high)
    if not fits or (above is not None and value <= above):
        limits = _range(low, high) if above is None else " above {:g}".format(above)
        limits += " and up to {:g}".format(high) if None not in (above, high) else ""
        raise ScenarioError("{}: {}, wanted a number{}".format(where, shown(value), limits))
    return float(value)


def number_list(value, count, where):
    """Return ``value`` as a list of ``count`` finite floats; else ``ScenarioError``."""
    if not isinstance(value, list) or len(value) != count:
        raise ScenarioError(
            "{}: {}, wanted a list of {} numbers".format(where, shown(value), count)
        )
    return [number(item, "{}[{}]".format(where, index)) for index, item in enumerate(value)]


def _range(low, high):
    if low is not None and high is not None:
        return " from {:g} to {:g}".format(low, high)
    if low is not None:
        return " of at least {:g}".format(low)
    return " of at most {:g}".format(high) if high is not None else ""


def reason(error):
    """Return why a file cannot be read, without its name and the error's number."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
