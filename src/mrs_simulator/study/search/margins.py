"""By how much robots may differ from a scenario before each requirement, or claim, breaks."""

import itertools
import math
from typing import NamedTuple

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.study.run.sweep import value_under
from mrs_simulator.study.search.space import content_with
from mrs_simulator.study.search.stated_noise import NOISE, states_noise
from mrs_simulator.study.search.trials import LAW
from mrs_simulator.study.search.whole_steps import grain_of, rounded
from mrs_simulator.verdict.requirements.results import line_of

POINTS = 8  # of an axis that are tried before what breaks is bisected
SHARES = [(k + 1.0) / POINTS for k in range(POINTS)]  # [-] of the way, of these
MOST_BISECTIONS = 8  # each halves what is left between two points
GEOMETRIC = 4.0  # [-] ratio of an axis' ends from which on its points are spaced by ratios
MOST_CORNERS = 64
RATE, SPEED, TRACK = "control.rate", "mismatch.speed", "mismatch.track"


class Axis(NamedTuple):
    """The values of a scenario's ``key`` from the ``nominal`` one to ``end`` [``unit``].

    ``step`` [s]: of a rate, whose period is a whole number of such steps, or 0; ``grain`` [s]: of a delay,
    which is such a number of these itself, or 0.
    """

    key: str
    nominal: float
    end: float
    unit: str = ""
    step: float = 0.0
    grain: float = 0.0

    def at(self, share, end=None):
        """Return the value at ``share`` of the way, 0 the nominal one, 1 the ``end``, or another one's."""
        end = self.end if end is None else end
        if self._is_geometric:
            value = self.nominal * (end / self.nominal) ** share
        else:
            value = self.nominal + share * (end - self.nominal)
        if self.step:
            value = 1.0 / (self.step * max(1, round(1.0 / (value * self.step))))
        return round(rounded(value, self.grain), 9)

    def share(self, value):
        """Return at which share of the way ``value`` lies, negative on the other side of the nominal."""
        if self._is_geometric:
            return math.log(max(value, 1e-9) / self.nominal) / math.log(self.end / self.nominal)
        return (value - self.nominal) / (self.end - self.nominal)

    def is_between(self, pair):
        """Return whether between the shares in ``pair``, if it is one, half way, is another value."""
        if not pair:
            return False
        return self.at(0.5 * sum(pair)) not in map(self.at, pair)

    @property
    def _is_geometric(self):
        if self.nominal <= 0.0 or self.end <= 0.0:
            return False
        ratio = self.end / self.nominal
        return max(ratio, 1.0 / ratio) >= GEOMETRIC


# Of the nominal value where a scenario has none: how late commands are obeyed, messages that are lost,
# commands per second, wheels, track, standard deviations over those of the scenario.
USUAL = (
    Axis("mismatch.delay", 0.0, 1.0, "s"),
    Axis("links.loss", 0.0, 0.9),
    Axis(RATE, 50.0, 1.0, "Hz"),
    Axis(SPEED, 1.0, 2.0),
    Axis(SPEED, 1.0, 0.25),
    Axis(TRACK, 1.0, 2.0),
    Axis(TRACK, 1.0, 0.5),
    Axis(NOISE, 1.0, 10.0),
)


def axes_of(scenario, content, wanted=None):
    """Return the ``Axis`` of each in ``wanted``, by default ``USUAL``, from the scenario's own values.

    ``content``: what its file says; ``wanted``: ``(key, end)`` pairs.  Raises ``ScenarioError`` for a key
    of ``wanted`` whose value is no number; of the usual ones such a key is left out.
    """
    if wanted is None:
        absent = set() if states_noise(content) else {NOISE}
        if content.get("fidelity") == "point_mass":  # which have no wheels
            absent.add(TRACK)
        usual = [axis for axis in USUAL if axis.key not in absent]
        own = [(axis, _nominal(content, axis.key, axis.nominal)) for axis in usual]
        axes = [axis._replace(nominal=value) for axis, value in own if value is not None]
    else:
        axes = [_axis(content, key, end) for key, end in wanted]
    step = _nominal(content, "step", 0.0) or 0.0
    axes = [axis._replace(step=step) if axis.key == RATE else axis for axis in axes]
    axes = [axis._replace(grain=grain_of(axis.key, scenario)) for axis in axes]
    return [axis for axis in axes if axis.nominal != axis.end]


def refuse_impossible(axes, content, path):
    """Raise ``ScenarioError`` for one of ``axes``, asked for, of which the scenario takes no value tried.

    ``content``: what the scenario's file at ``path`` says.
    """
    for axis in axes:
        where = "--along {}={:g}".format(axis.key, axis.end)
        for share in SHARES:
            try:
                scenario_of_file(
                    content_with(content, {axis.key: axis.at(share)}, path), path, where
                )
                break
            except ScenarioError as error:
                refusal = error
        else:
            raise refusal


def _axis(content, key, end):
    usual = next((axis for axis in USUAL if axis.key == key), Axis(key, math.nan, end))
    nominal = _nominal(content, key, usual.nominal)
    if nominal is None or math.isnan(nominal):
        text = "{}: wanted a number in the scenario, from which the axis begins"
        raise ScenarioError(text.format(key))
    if nominal == end:
        text = "--along {}={:g}: the scenario's own value, wanted another one"
        raise ScenarioError(text.format(key, end))
    return usual._replace(nominal=nominal, end=end)


def _nominal(content, key, missing):
    """Return the number under the path ``key``, ``missing`` where there is none, None if no number."""
    found = value_under(content, key, missing)
    number = isinstance(found, (int, float)) and not isinstance(found, bool)
    return float(found) if number else None


def acts(row):
    """Return whether what is asked for differs along an axis, the ``row`` of a report; True of old ones."""
    return row.get("acts", True)


class Margins:
    """What is found by runs of a ``breaking.Search`` along ``axes``."""

    def __init__(self, search, axes, robots):
        """``robots``: their number."""
        self._search, self._axes, self._robots, self._failed = search, axes, robots, ""

    def found(self, together=True):
        """Return a plain mapping: ``nominal``, ``axes``, ``dead`` and, if wanted, ``together``.

        ``nominal``: what each requirement has to spare, by name; ``open``: those that the scenario as it
        stands leaves open, of which nothing else is said; ``axes``: for each its ``key``,
        ``unit``, ``nominal``, ``end``, by name in ``breaks`` the pair of the last value that holds and
        the first that breaks, or None, how many values were ``tried``, why others were ``refused``, and
        whether it ``acts``: not where all have the same to spare, to the bit, at each value that was tried;
        ``failed``: how the law ended a run, "" if it did not; ``dead``: by robot the names
        that break without it; ``together``: see :meth:`_together`.  Raises ``ScenarioError`` where the
        scenario itself breaks.
        """
        trial = self._search.nominal()
        if trial.is_broken:
            text = "{}: broken as it stands, {} has no margin"
            raise ScenarioError(text.format(self._search.path, trial.worst["name"]))
        if not trial.spares:
            text = "{}: nothing is judged; wanted requirements, or a run that is long enough"
            why = ": " + line_of(trial.worst) if trial.has_no_margin else ""
            raise ScenarioError(text.format(self._search.path) + why)
        axes = [
            self._row(axis, *pair) for axis, pair in zip(self._axes, self._scanned(trial.spares))
        ]
        return {
            "nominal": trial.spares,
            "open": self._search.left_open(trial),
            "failed": self._failed,
            "axes": axes,
            "dead": self._dead(),
            "together": self._together(axes) if together else None,
        }

    # Along one axis ------------------------------------------------------------------------------

    def _row(self, axis, breaks, tried, refused, acts):
        plain = {"key": axis.key, "unit": axis.unit, "nominal": axis.nominal, "end": axis.end}
        return {**plain, "breaks": breaks, "tried": tried, "refused": refused, "acts": acts}

    def _scanned(self, nominal):
        """Return the last four arguments of :meth:`_row` for each axis."""
        points = [(axis, share) for axis in self._axes for share in SHARES]
        trials = self._search.tried([{axis.key: axis.at(share)} for axis, share in points])
        found = []
        for row in range(len(self._axes)):
            mine = list(zip(SHARES, trials[row * POINTS : (row + 1) * POINTS]))
            refused = next((trial.error for _, trial in mine if trial.error), "")
            known = [(share, trial.spares) for share, trial in mine if not trial.error]
            ended = (t.worst["note"] for _, t in mine if t.worst and t.worst["name"] == LAW)
            self._failed = self._failed or next(ended, "")
            acts = not known or any(spares != nominal for _, spares in known)
            found.append(
                ({name: _first(known, name) for name in nominal}, len(known), refused, acts)
            )
        self._bisect([breaks for breaks, *_ in found])
        for axis, (breaks, *_) in zip(self._axes, found):
            for name, pair in breaks.items():
                breaks[name] = [axis.at(share) for share in pair] if pair else None
        return found

    def _bisect(self, brackets):
        """Narrow the pairs of shares in ``brackets``, a mapping by name for each axis, in place."""
        for _ in range(MOST_BISECTIONS):
            asked = []
            for axis, breaks in zip(self._axes, brackets):
                middles = {0.5 * sum(pair) for pair in breaks.values() if axis.is_between(pair)}
                asked += [(axis, breaks, middle) for middle in sorted(middles)]
            trials = self._search.tried([{axis.key: axis.at(at)} for axis, _, at in asked])
            for (_, breaks, middle), trial in zip(asked, trials):
                for name, pair in breaks.items():
                    if pair and 0.5 * sum(pair) == middle and not trial.error:
                        broken = _breaks(trial.spares, name)
                        breaks[name] = (pair[0], middle) if broken else (middle, pair[1])

    # Dead robots ---------------------------------------------------------------------------------

    def _dead(self):
        """Return by number of each robot what breaks where it never moves; None where that is refused."""
        speeds = self._search.content.get("mismatch", {}).get("speed", 1.0)
        speeds = list(speeds) if isinstance(speeds, list) else [speeds] * self._robots
        variations = [
            {SPEED: speeds[:row] + [0.0] + speeds[row + 1 :]} for row in range(self._robots)
        ]
        return {
            str(row + 1): None
            if trial.error
            else sorted(name for name in trial.spares if _breaks(trial.spares, name))
            for row, trial in enumerate(self._search.tried(variations))
        }

    # All at once ---------------------------------------------------------------------------------

    def _together(self, rows):
        """Return how much of all margins may be used up at once, None for fewer than two.

        The box of all keys, each from its nominal value to ``share`` of the way to where the first
        requirement breaks: ``share``, the largest found at whose corners all hold; ``corner``, the values
        at which one breaks first beyond it, and ``breaks``, which, None if nothing does; ``corners``,
        how many were tried each time.
        """
        ends = {}
        for axis, row in zip(self._axes, rows):
            held = [pair[0] for pair in row["breaks"].values() if pair]
            if held:
                last = min(held, key=lambda value, axis=axis: abs(value - axis.nominal))
                ends.setdefault(axis.key, []).append((axis, last))
        if len(ends) < 2:
            return None
        corners = _corners(ends)
        result = {"share": 1.0, "corner": None, "breaks": None, "corners": len(corners)}
        low, high, share = 0.0, 1.0, 1.0
        for _ in range(MOST_BISECTIONS):
            variations = [
                {axis.key: axis.at(share, end) for axis, end in corner} for corner in corners
            ]
            trials = self._search.tried(variations)
            broken = [pair for pair in zip(variations, trials) if pair[1].is_broken]
            if broken:
                corner, trial = min(broken, key=lambda pair: pair[1].value)
                result.update(corner=corner, breaks=trial.worst["name"])
                high = share
            elif share == 1.0:
                return result
            else:
                low = share
            share = 0.5 * (low + high)
        return {**result, "share": low}


def _corners(ends):
    """Return the corners of the box, each a list of ``(axis, end)``; ``ends``: such pairs by key."""
    if 2 ** len(ends) <= MOST_CORNERS:  # the nominal value is an end where a key has only one other
        ends = {
            key: pairs if len(pairs) > 1 else [*pairs, (pairs[0][0], pairs[0][0].nominal)]
            for key, pairs in ends.items()
        }
    return list(itertools.islice(itertools.product(*ends.values()), MOST_CORNERS))


def _breaks(spares, name):
    # A claim that another run does not judge is not broken by it.
    return spares.get(name, 1.0) < 0.0


def _first(known, name):
    """Return the shares between which ``name`` breaks first, None where it holds at all that are known."""
    before = 0.0
    for share, spares in known:
        if _breaks(spares, name):
            return before, share
        before = share
    return None
