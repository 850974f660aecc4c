"""The controller's settings during a run: keys of a scenario, and their changes over time."""

import math
from typing import Any, NamedTuple

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict

# Keys that the controller uses; the rest is the stage's.
CONTROLLER_KEYS = ("control", "topology", "links", "estimates", "seed")
# What a controller may keep below any limits: the highest speeds [m/s, rad/s], those given alone.
TOP_SPEEDS, SPEEDS = "top_speeds", ("v_max", "omega_max")
MOST_WORDS = 40  # [characters] of a value in a message
MOST_LISTED = 3  # [-] changes that a text names


class Change(NamedTuple):
    """A key of the scenario whose value changes at ``time``."""

    time: float  # [s] since the run began
    key: str  # one of ``CONTROLLER_KEYS``
    value: Any  # as in a scenario's file, None where it has no such key


def controller_settings(scenario):
    """Return ``{key: plain value}`` of the keys of ``scenario`` that a controller uses."""
    content = scenario.to_dict()
    return {key: content[key] for key in CONTROLLER_KEYS if key in content}


def with_keys(scenario, given):
    """Return ``scenario`` with top-level keys as in a file, None for none.

    Raises ``ScenarioError`` for bad values.
    """
    content = {**scenario.to_dict(), **given}
    content = {key: value for key, value in content.items() if value is not None}
    return scenario_from_dict(content, "what ran")._replace(path=scenario.path)


def differences(before, after):
    """Return ``{key: value}`` of ``after`` where it differs from ``before``, None for keys it lacks."""
    keys = dict.fromkeys((*before, *after))
    return {key: after.get(key) for key in keys if before.get(key) != after.get(key)}


def changed_by(scenario, changes):
    """Return ``scenario`` after all of ``changes``."""
    for change in changes:
        scenario = with_keys(scenario, {change.key: change.value})
    return scenario


class ControllerRecord:
    """The settings that controllers published, and from when on they hold."""

    def __init__(self):
        self._published = []  # [(stamp [s], {key: value})]

    def note(self, stamp, settings):
        """Note that ``settings`` hold from ``stamp`` [s] on; a time that went back starts over."""
        if self._published and stamp < self._published[-1][0]:
            self._published = []
        self._published.append((stamp, settings))

    def begin_run(self):
        """Keep the settings in force alone, for any time to come."""
        self._published = [(-math.inf, settings) for _, settings in self._published[-1:]]

    def since(self, otherwise):
        """Return when [s] the first controller of this run published its settings, else ``otherwise``."""
        return next((stamp for stamp, _ in self._published if math.isfinite(stamp)), otherwise)

    def hand_length(self, otherwise):
        """Return the distance l [m] of the controlled points, ``otherwise`` if unknown."""
        control = self._published[-1][1].get("control", {}) if self._published else {}
        return control.get("parameters", {}).get("l", otherwise)

    def during(self, begin, end):
        """Return the settings at ``begin`` [s], None if unknown, and the ``Change``s up to ``end``."""
        if not self._published:
            return None, []
        place = max(
            [row for row, (stamp, _) in enumerate(self._published) if stamp <= begin] or [0]
        )
        first, changes = self._published[place][1], []
        before = first
        for stamp, after in self._published[place + 1 :]:
            if stamp > end:
                break
            for key, value in differences(before, after).items():
                if key in CONTROLLER_KEYS:
                    changes.append(Change(round(stamp - begin, 9), key, value))
            before = after
        return first, changes


def changes_text(scenario, changes):
    """Return a text on what ``changes`` changed in ``scenario``, "" without any."""
    before, texts = controller_settings(scenario), []
    for change in changes:
        old = before.get(change.key)
        texts += [
            "{} at {:.2f} s".format(text, change.time)
            for text in _differences_in_words(change.key, old, change.value)
        ]
        before[change.key] = change.value
    if not texts:
        return ""
    more = " and {} more".format(len(texts) - MOST_LISTED) if len(texts) > MOST_LISTED else ""
    return "changed during the run: {}{}".format("; ".join(texts[:MOST_LISTED]), more)


def _differences_in_words(name, before, after):
    if isinstance(before, dict) and isinstance(after, dict):
        return [
            text
            for key, value in differences(before, after).items()
            for text in _differences_in_words(key, before.get(key), value)
        ]
    if isinstance(before, list) or isinstance(after, list):
        count = [0 if value is None else len(value) for value in (before, after)]
        return ["{} ({} before, {} after)".format(name, *count)]
    return ["{} {} -> {}".format(name, *(str(value)[:MOST_WORDS] for value in (before, after)))]


def to_plain(changes):
    """Return ``changes`` as ``run.json`` has them."""
    return [list(change) for change in changes]


def read_changes(content):
    """Return the ``Change``s in ``content`` of a ``run.json``; ``ValueError`` for bad ones."""
    changes = [Change(float(time), str(key), value) for time, key, value in content]
    for change in changes:
        if change.key not in CONTROLLER_KEYS:
            raise ScenarioError(
                "change of {!r}, wanted one of {}".format(change.key, ", ".join(CONTROLLER_KEYS))
            )
    return changes
