"""A run that goes on, as a display knows it, and what is said of it meanwhile and at its end."""

import os
from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.record.run_changes import read_changes
from mrs_simulator.study.results.report import VERDICT_FILE, control_of, read_run, write_report
from mrs_simulator.verdict.standing import standings
from mrs_simulator.verdict.verdict_file import read_verdict


class SoFar(NamedTuple):
    """Samples of a run that goes on, arrays and plain values: it passes between processes."""

    key: Tuple  # the same for one run alone
    time: Any  # (m,) [s] since it began
    numbers: Tuple  # of the robots
    pose: Any  # (m, n, 3) [m, m, rad]
    heights: Any  # (m, n) [m]
    command: Any  # (m, n, a)
    axes: Tuple  # the columns of ``command``
    columns: dict  # others by their names, such as joints (m, n)
    collisions: Tuple
    meta: dict  # what ``run.json`` would have, such as changes


_OF_RUN = {}  # the newest key, with the ``Course`` of that run


def standings_of(scenario, so_far):
    """Return how the claims of a run of ``scenario`` stand by now, as :func:`standing.standings` does."""
    control = make_control(scenario)
    known = _OF_RUN.get(so_far.key)
    rows, known = standings(control, _run_of(scenario, control, so_far), known)
    _OF_RUN.clear()
    if known is not None:
        _OF_RUN[so_far.key] = known
    return rows


def _run_of(scenario, control, so_far):
    """Return the ``Run`` so far."""
    if len(so_far.numbers) != control.team.n:
        text = "{} robots, wanted the {} of the controller"
        raise ValueError(text.format(len(so_far.numbers), control.team.n))
    known = so_far.pose
    if control.team.is_spatial:
        known = np.concatenate([known, so_far.heights[..., np.newaxis]], axis=2)
    hand = control.team.point(known, so_far.columns.get("joints"), control.l)
    meta = {**so_far.meta, "changes": read_changes(so_far.meta.get("changes", []))}
    return Run(
        so_far.time,
        so_far.numbers,
        so_far.pose,
        hand,
        so_far.command,
        so_far.collisions,
        scenario,
        meta,
        so_far.axes,
        **so_far.columns,
    )


def verdict_on(scenario, directory):
    """Return the verdict on the run in ``directory``, as its file has it, without figures.

    ``scenario`` is not asked: the run has its own.
    """
    run = read_run(directory)
    write_report(run, directory, (), control_of(run))
    return read_verdict(os.path.join(directory, VERDICT_FILE))
