"""What a sweep is going to run, and what theory says of each run before it, as one file."""

import contextlib
import csv
import json
import os

import numpy as np

from mrs_simulator.core.claims import Condition
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.writing import write_text
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.study.run.sweep import MEASURES, TABLE, units_of

PLAN = "sweep.json"
REFUSED = "refused: {}"
NEAR_ZERO = 0.1  # [-] of the least value, down to which the boundary is drawn


def write_plan(runs, boundary, out):
    """Write ``sweep.json`` of ``runs`` of ``sweep.make_runs`` to the directory ``out``.

    ``keys`` that vary, their ``units`` and ``values``; ``runs``, each with its directory ``run``, its
    ``values``, and what theory foretells: whether its theorem ``holds`` (None: no theorem applies) and
    ``why`` not; ``lines``, the theorem's ``boundary`` over two keys of numbers, each a list of points
    (x, y) in the keys' units, and its ``name``.  ``boundary``: of ``sweep.theorem_boundary``.
    """
    keys = list(runs[0][1])
    name, lines = _lines(runs, keys, boundary)
    plan = {
        "keys": keys,
        "units": units_of(runs),
        "values": {key: list(dict.fromkeys(values[key] for _, values, _ in runs)) for key in keys},
        "runs": [{"run": run, "values": v, **foretold(scenario)} for run, v, scenario in runs],
        "boundary": {"name": name, "lines": lines},
    }
    os.makedirs(out, exist_ok=True)
    write_text(os.path.join(out, PLAN), json.dumps(plan, indent=1) + "\n")


def read_plan(out):
    """Return what ``write_plan`` has written to ``out``; raises ``OSError`` and ``ValueError``."""
    plan = read_json(os.path.join(out, PLAN))
    if not isinstance(plan, dict) or not {"keys", "units", "values", "runs"} <= set(plan):
        raise ValueError("{}: no plan of a sweep".format(os.path.join(out, PLAN)))
    return plan


def is_sweep(path):
    """Return whether the directory ``path`` is that of a sweep: with its plan, or its table."""
    return any(os.path.isfile(os.path.join(path, name)) for name in (PLAN, TABLE))


def plan_of(out):
    """Return the plan of the sweep in ``out``; of one without ``sweep.json`` what its table has.

    Of that theory says nothing, and only the runs that have ended are known.  None where there is neither
    file.  Raises ``OSError`` and ``ValueError``.
    """
    if os.path.exists(os.path.join(out, PLAN)):
        return read_plan(out)
    rows = read_table(out)
    if not rows:
        return None
    keys = swept(rows)
    runs = [
        {"run": row["run"], "values": values_of(row, keys), "holds": None, "why": ""}
        for row in rows
    ]
    values = {key: list(dict.fromkeys(each["values"][key] for each in runs)) for key in keys}
    return {"keys": keys, "units": {}, "values": values, "runs": runs}


def read_table(out):
    """Return the rows of the table of the sweep in ``out``, texts by column; [] where it has none."""
    try:
        with open(os.path.join(out, TABLE), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))
    except FileNotFoundError:
        return []


def swept(rows):
    """Return the keys that vary in the ``rows`` of a sweep's table."""
    columns = list(rows[0])
    return columns[1 : columns.index(MEASURES[0])]


def values_of(row, keys):
    """Return the values of ``keys`` in a ``row`` of a sweep's table; texts where they are no numbers."""
    return {key: _number(row[key]) for key in keys}


def _number(text):
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def foretold(scenario):
    """Return ``holds`` and ``why`` of a run by its theorem alone, without running it.

    A stated threshold decides; without one the theorem's conditions: one that is necessary and does not
    hold makes the protocol fail, another one leaves the run without a theorem.
    """
    try:
        control = make_control(scenario)
        points = control.points(scenario.starts)
        known, claims = control.stability(points), control.all_claims(points)
    except Exception as error:  # a law of one's own may raise anything
        return {"holds": None, "why": REFUSED.format(named(error))}
    broken = [each for each in claims if isinstance(each, Condition) and not each.holds]
    why = "; ".join("{}: {}".format(each.name, each.why).rstrip(": ") for each in broken)
    if known is not None:
        return {"holds": bool(known.margin > 0.0), "why": why}
    if any(each.necessary for each in broken):
        return {"holds": False, "why": why}
    return {"holds": None if broken or not claims else True, "why": why}


def _lines(runs, keys, boundary):
    """Return the name of the theorem's threshold and where it lies, "" and [] where there is none."""
    values = np.array([[each[1][key] for key in keys] for each in runs], dtype=object)
    if len(keys) != 2 or not all(type(each) in (int, float) for each in values.flat):
        return "", []
    from matplotlib.figure import Figure  # slow to import

    from mrs_simulator.study.draw.sweep_figures import boundary_within

    name, known = boundary_within(boundary, (*keys, {}), *_around(values.astype(float)))
    if known is None:
        return name, []
    drawn = Figure().add_subplot(1, 1, 1).contour(*known, levels=[0.0])
    return name, [line.tolist() for line in drawn.allsegs[0] if len(line) > 1]


def _around(values):
    """Return the ends of the columns of ``values`` (m, 2), half a step beyond; what is above 0 stays so."""
    low, high = values.min(axis=0), values.max(axis=0)
    room = 0.5 * (high - low) / [max(1, len(set(column)) - 1) for column in values.T]
    return np.where(low > 0.0, np.maximum(low - room, NEAR_ZERO * low), low - room), high + room
