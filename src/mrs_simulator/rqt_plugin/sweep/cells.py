"""The cells of a sweep map: what theory foretells of each, and what its run has shown; without Qt."""

import math
import os
from typing import Any, NamedTuple

import numpy as np
from matplotlib import cm
from matplotlib.colors import Normalize

from mrs_simulator.study.draw.sweep_figures import about_zero, scale_of
from mrs_simulator.study.run.sweep_plan import plan_of, read_table
from mrs_simulator.study.run.workers import failed
from mrs_simulator.study.search.trials import NEUTRAL, share_of
from mrs_simulator.verdict.requirements.results import known_bound
from mrs_simulator.verdict.verdict import FAILED, PASSED, outcome_of
from mrs_simulator.verdict.verdict_file import read_verdict

MARGIN, SETTLING, GROWTH = "margin of the claims", "settling time", "growth rate"
UNITS = {MARGIN: "of the tolerance", SETTLING: "s", GROWTH: "1/s"}
ROBUSTNESS = "robustness of {}"
USUAL_SHARE = 80  # [%] of growth rates that the scale of colours covers
NO_MAP = "a sweep over {}: wanted two keys of numbers for a map, with two values of each at least"
SEQUENTIAL, BETTER_HIGH, BETTER_LOW = "viridis", "RdBu", "RdBu_r"  # seen by the colour-blind, too
# [-] from the middle of a colour map, where what just holds is distinguished from what just fails
PALEST = 0.15


class Cell(NamedTuple):
    """One run of a sweep."""

    run: str  # its directory's name
    holds: Any = None  # whether theory has its theorem hold, None where none applies
    why: str = ""  # it does not
    outcome: str = ""  # of its verdict, "" before it has ended
    ended: str = ""  # how the run ended
    measured: Any = None  # by the names of quantities
    worst: str = ""  # the claim with the least margin

    @property
    def agrees(self):
        """Return whether the run is as theory has it, None where that is not known."""
        if self.holds is None or self.outcome not in (PASSED, FAILED):
            return None
        return self.holds == (self.outcome == PASSED)


class SweepCells:
    """The cells over two keys, (rows of y, columns of x), as far as they are known."""

    def __init__(self, keys, values, units=None):
        """``keys`` (x, y); ``values``: of each, by key; ``units``: by key."""
        self.keys, self.values = tuple(keys), [list(values[key]) for key in keys]
        self.units = units or {}
        shape = len(self.values[1]), len(self.values[0])
        self.cells = np.full(shape, None, dtype=object)
        self.boundary, self.lines = "", []  # the theorem's name, and its lines in cells, (m, 2)

    @classmethod
    def of_plan(cls, plan):
        """Return the cells of what ``sweep_plan.plan_of`` has returned, taken in.

        Raises ``ValueError`` where no map can be made of it.
        """
        keys = plan["keys"]
        values = {key: sorted_numbers(plan["values"][key]) for key in keys}
        if len(keys) != 2 or not all(values.values()):
            raise ValueError(NO_MAP.format(", ".join(keys)))
        result = cls(keys, values)
        result.take_plan(plan)
        return result

    def take_plan(self, plan):
        """Take in what ``sweep_plan.plan_of`` has returned."""
        self.units = plan["units"]
        for each in plan["runs"]:
            column, row = (
                known.index(each["values"][key]) for key, known in zip(self.keys, self.values)
            )
            self.cells[row, column] = Cell(each["run"], each["holds"], each["why"])
        boundary = plan.get("boundary") or {"name": "", "lines": []}
        self.boundary = boundary["name"]
        self.lines = [self.places(np.asarray(line)) for line in boundary["lines"]]
        if not self.lines:
            self.lines = _between([[cell and cell.holds for cell in row] for row in self.cells])

    def take_verdicts(self, verdicts):
        """Take in ``verdicts`` by the names of runs."""
        for place, cell in np.ndenumerate(self.cells):
            if cell is not None and cell.run in verdicts:
                self.cells[place] = _judged(cell, verdicts[cell.run])

    def places(self, points):
        """Return where ``points`` (m, 2), in the keys' units, are in cells: 0 the centre of the first."""
        return np.column_stack([_place(v, points[:, i]) for i, v in enumerate(self.values)])

    def at(self, x, y):
        """Return ``(row, column)`` of the cell at a place in cells, None beside them."""
        row, column = int(math.floor(y + 0.5)), int(math.floor(x + 0.5))
        inside = 0 <= row < self.cells.shape[0] and 0 <= column < self.cells.shape[1]
        return (row, column) if inside else None

    def known(self):
        """Return the ``Cell``s whose runs have ended, in a list."""
        return [cell for cell in self.cells.flat if cell is not None and cell.outcome]

    def are_known(self):
        """Return whether all runs have ended."""
        return len(self.known()) == sum(cell is not None for cell in self.cells.flat)

    def quantities(self):
        """Return the names of what cells can be coloured by."""
        names = [MARGIN]
        for cell in self.known():
            names += [name for name in cell.measured if name not in names]
        return names

    def measured(self, name):
        """Return the quantity called ``name`` of each cell, NaN where it has none."""
        values = [
            (cell.measured or {}).get(name) if cell is not None else None
            for cell in self.cells.flat
        ]
        values = [math.nan if value is None else value for value in values]
        return np.array(values, dtype=float).reshape(self.cells.shape)

    def summary(self):
        """Return in words how far the sweep is, and whether its runs are as theory has them."""
        known, total = self.known(), self.cells.size
        passed = sum(cell.outcome == PASSED for cell in known)
        text = "{} of {} cells, {} passed".format(len(known), total, passed)
        compared = [cell.agrees for cell in known if cell.agrees is not None]
        if compared:
            text += "; as theory has it: {} of {}".format(sum(compared), len(compared))
        return text


class Scale(NamedTuple):
    """How numbers become colours: ``norm(value)`` is in [0, 1] of the colour map."""

    norm: Any
    colours: str  # a colour map of matplotlib
    beyond: tuple = (False, False)  # whether values lie below, and above, its ends

    def shades(self, values):
        """Return the colour of each of ``values`` (...), (..., 3), whole numbers; of NaN the lowest's."""
        low, high = self.norm.vmin, self.norm.vmax
        inside = np.clip(np.where(np.isfinite(values), values, low), low, high)
        shares = np.ma.filled(self.norm(inside), 0.0)
        if self.colours != SEQUENTIAL:
            away = shares - 0.5
            side = np.where(away < 0.0, -1.0, 1.0)
            shares = 0.5 + side * (PALEST + (1.0 - 2.0 * PALEST) * np.abs(away))
        return (255 * getattr(cm, self.colours)(shares)[..., :3]).astype(int)


def sorted_numbers(values):
    """Return ``values`` ascending; [] where one is no number, or there are fewer than two."""
    numbers = all(type(each) in (int, float) for each in values) and len(values) > 1
    return sorted(values) if numbers else []


def scale_for(name, values):
    """Return the ``Scale`` of ``values`` of the quantity called ``name``, None where there is none."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return None
    if name == SETTLING:
        norm, colours = scale_of(finite), SEQUENTIAL
    elif name == MARGIN:
        norm, colours = Normalize(-1.0, 1.0), BETTER_HIGH
    elif name == GROWTH:
        span = max(float(np.percentile(np.abs(finite), USUAL_SHARE)), 1e-12)
        norm, colours = Normalize(-span, span), BETTER_LOW
    else:
        norm, colours = about_zero(finite), BETTER_HIGH
    beyond = bool(finite.min() < norm.vmin), bool(finite.max() > norm.vmax)
    return Scale(norm, colours, beyond)


def read_news(out, known, planned):
    """Return ``(plan, verdicts)`` of a sweep's directory ``out``: what is not ``known`` yet.

    ``known``: names of runs; ``planned``: whether the plan is.  The plan is None where it is not
    written yet.  It may take long, and is for a thread of its own.
    """
    plan, verdicts = None, {}
    if not planned:
        plan = plan_of(out)
    rows = [row for row in read_table(out) if row["run"] not in known]
    for row in rows:
        try:
            verdicts[row["run"]] = read_verdict(os.path.join(out, row["run"], "verdict.json"))
        except (OSError, ValueError):  # its law raised, or its process died
            verdicts[row["run"]] = failed(row.get("ended") or "not ended")
    return plan, verdicts


def _judged(cell, verdict):
    """Return the ``cell`` with what the ``verdict`` on its run says."""
    measured, worst = {}, ""
    judged = [each for each in verdict["checks"] if each["passed"] is not None]
    if judged:
        least = min(judged, key=share_of)
        measured[MARGIN], worst = share_of(least), least["name"]
    if verdict["ended"] != "complete" and outcome_of(verdict) == FAILED:
        measured[MARGIN], worst = -NEUTRAL, verdict["ended"]  # what it leaves open is not kept
    for each in verdict.get("requirements", []):
        name = ROBUSTNESS.format(each["name"])
        name += " [{}]".format(each["unit"]) if each["unit"] else ""
        measured[name] = known_bound(each)
    for name, key in ((SETTLING, "settle_time"), (GROWTH, "growth_rate")):
        value = verdict.get(key)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            measured[name] = float(value)
    outcome = outcome_of(verdict)
    return cell._replace(outcome=outcome, ended=verdict["ended"], measured=measured, worst=worst)


def _place(values, numbers):
    """Return where ``numbers`` are among ascending ``values``, in steps, beyond their ends, too."""
    steps = np.arange(len(values), dtype=float)
    inside = np.interp(numbers, values, steps)
    first, last = values[1] - values[0], values[-1] - values[-2]
    below = np.minimum(0.0, (numbers - values[0]) / first)
    return inside + below + np.maximum(0.0, (numbers - values[-1]) / last)


def _between(holds):
    """Return the sides (2, 2) between cells of a table of which theory says other things."""
    lines = []
    for (row, column), own in np.ndenumerate(np.array(holds, dtype=object)):
        if column + 1 < len(holds[0]) and (own is True) != (holds[row][column + 1] is True):
            x = column + 0.5
            lines.append(np.array([[x, row - 0.5], [x, row + 0.5]]))
        if row + 1 < len(holds) and (own is True) != (holds[row + 1][column] is True):
            y = row + 0.5
            lines.append(np.array([[column - 0.5, y], [column + 0.5, y]]))
    return lines
