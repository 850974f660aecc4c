"""Which keys of two scenarios differ; without Qt and ROS."""

from typing import NamedTuple

ABSENT = object()  # the value of a key that a scenario has not
NAMES = ("title", "speed")  # keys that change nothing of a run
LONGEST = 24  # [characters] of a value in a line
NOTHING = "\u2013"
LAW = "control.protocol"
PREFIXES = ("control.parameters.", "control.", "topology.")  # left out of a key's short name


class Difference(NamedTuple):
    """A key whose values differ between runs."""

    key: str  # with dots
    values: tuple  # of each run, ``ABSENT`` where it has none

    @property
    def short(self):
        """Return the key without what every reader knows."""
        for prefix in PREFIXES:
            if self.key.startswith(prefix):
                return self.key[len(prefix) :]
        return self.key

    @property
    def text(self):
        """Return a few words for a list: both values of a short one, else that it differs."""
        values = [value_text(each) for each in self.values]
        if max(map(len, values)) > LONGEST:
            return "other {}".format(self.short)
        return "{} {} \u2192 {}".format(self.short, *values)


def flat(content, above=""):
    """Return a scenario's mapping ``content`` as ``{key: value}``, keys with dots; lists stay whole."""
    result = {}
    for key, value in content.items():
        name = above + str(key)
        if isinstance(value, dict) and value:
            result.update(flat(value, name + "."))
        else:
            result[name] = value
    return result


def differing(runs):
    """Return the ``Difference``s of ``runs``, the flat keys of two or more, parameters first."""
    keys = dict.fromkeys(key for keys in runs for key in keys if key not in NAMES)
    found = []
    for key in keys:
        values = tuple(run.get(key, ABSENT) for run in runs)
        if any(value != values[0] for value in values[1:]):
            found.append(Difference(key, values))
    return sorted(found, key=lambda each: not each.key.startswith(PREFIXES[0]))


def telling(differences):
    """Return those of ``differences`` that tell runs apart in few words, the law first.

    Of runs of two laws a parameter that one of them has not says no more than that.
    """
    laws = [each for each in differences if each.key == LAW]
    rest = [each for each in differences if each.key != LAW]
    if laws:
        rest = [e for e in rest if not (e.key.startswith(PREFIXES[0]) and ABSENT in e.values)]
    return laws + rest


def value_text(value):
    """Return a scenario's ``value`` as a person reads it."""
    if value is ABSENT:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "{:.6g}".format(value) if isinstance(value, float) else str(value)
