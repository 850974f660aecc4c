"""What a display asks of a scenario's law: its parameters, targets, warnings and prediction.

Each function makes the control anew, so that a protocol's file may be edited meanwhile, and may
raise whatever the law raises.
"""

import contextlib
from types import SimpleNamespace
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.writing import MOST_PRINTED, Limited
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import FARTHEST
from mrs_simulator.study.results.report import predicted_settling
from mrs_simulator.study.run.run_so_far import standings_of, verdict_on
from mrs_simulator.verdict.derived.asking import start_points, velocities_at
from mrs_simulator.verdict.theory.meetings import LONG, meetings_ahead, start_run, track_ahead
from mrs_simulator.verdict.user_values import texts_of

PREDICTED_SAMPLES = 400  # [-] of the prediction drawn
DRAWN_SAMPLES = 100  # [-] of the paths on the map
MOST_PREDICTED = 2e6  # [-] steps times robots; a longer prediction is drawn as far as that


class Facts(NamedTuple):
    """What a law says of its scenario at the start; plain values throughout."""

    protocol: str  # name of the class
    parameters: Tuple  # core.fields.Parameter of each
    values: dict  # of the parameters
    topology: Topology
    warnings: dict  # theory's, texts by the parameter that causes them
    targets: Optional[np.ndarray]  # of the controlled points at the start, (n, d) [m]


class Prediction(NamedTuple):
    """What theory says of the run that a scenario describes."""

    time: Any  # (m,) [s], None where theory gives no track
    error: Any  # (m,) [m], the largest distance of a controlled point from its target
    settling: str  # in words, "" where theory says nothing


def serve(function, *arguments):
    """Return what the ``function`` of this module, by its name, returns."""
    return ANSWERS[function](*arguments)


def facts(scenario):
    """Return the ``Facts`` of the scenario's law; its prediction is tried at the start."""
    control = make_control(scenario)
    start = control.points(scenario.starts)
    targets = control.targets(start)
    texts = texts_of(control.warnings(scenario.starts), "warnings()")
    texts += control.foreseen
    texts += meetings_ahead(control, scenario)
    _predicted_error(control, start, np.zeros(1))
    return Facts(
        type(control).__name__,
        tuple(control.PARAMETERS),
        dict(control.parameters),
        control.topology,
        {"T" if hasattr(control, "T") else "": "; ".join(texts)} if texts else {},
        None if targets is None else np.asarray(targets, dtype=float),
    )


def parameters_with(scenario, topology):
    """Return the parameters' values once the law has taken ``topology``, which may change them."""
    control = make_control(scenario)
    control.set_topology(topology)
    return dict(control.parameters)


def errors(scenario, pose):
    """Return the largest distance [m] from a target at each ``pose`` (m, n, 3), (m,), or None.

    NaN where the poses are of another number of robots.
    """
    control = make_control(scenario)
    if control.targets(control.points(scenario.starts)) is None:
        return None
    if pose.shape[1] != len(control.numbers):
        return np.full(len(pose), np.nan)
    hands = control.points(pose)
    return np.array([_largest_error(control, hand) for hand in hands])


def targets_at(scenario, pose):
    """Return where the controlled points have to go at each ``pose`` (m, n, 3), (m, n, d) [m], or None."""
    control = make_control(scenario)
    hands = control.points(pose)
    if not len(hands) or control.targets(hands[0]) is None:
        return None
    return np.array([control.targets(hand) for hand in hands], dtype=float)


def prediction(scenario):
    """Return the ``Prediction`` of the whole run, of its beginning where the run is very long."""
    control = make_control(scenario)
    start = control.points(scenario.starts)
    longest = MOST_PREDICTED / scenario.n * getattr(control, "T", np.inf)
    when = np.linspace(0.0, min(scenario.duration, longest), PREDICTED_SAMPLES)
    settling = predicted_settling(control, start) if when[-1] >= scenario.duration else ""
    return Prediction(*_predicted_error(control, start, when), settling)


def forecast(scenario):
    """Return where theory has the controlled points until the end of the run, (k, n, 2) [m].

    ``k`` is 1 where only the places are known at which they end; None where nothing is.
    """
    control = make_control(scenario)
    run = start_run(control, scenario)
    track = None if run.hand[..., 0].size > LONG else track_ahead(control, run)
    if track is None:
        return None
    rows = np.linspace(0, len(track[0]) - 1, min(len(track[0]), DRAWN_SAMPLES)).astype(int)
    return np.clip(track[0][rows][..., :2], -FARTHEST, FARTHEST)


def ahead(scenario, function, *arguments):
    """Return what the ``function`` of :mod:`ahead` by its name returns; it moves robots."""
    from mrs_simulator.study.run import ahead as looks  # a world, which few displays want

    return getattr(looks, function)(scenario, *arguments)


_PRINTED = Limited(SimpleNamespace(value=MOST_PRINTED))


def velocities(scenario, points, theta, time, fresh):
    """Return ``asking.velocities_at`` of the scenario.

    Of what the law prints over all calls the first ``MOST_PRINTED`` characters are shown.
    """
    with contextlib.redirect_stdout(_PRINTED):
        return velocities_at(scenario, points, theta, time, fresh)


def _predicted_error(control, start, when):
    if control.targets(start) is None:
        return None, None
    track = control.predicted_track(start, when)
    if track is None:
        return None, None
    return when, np.array([_largest_error(control, hand) for hand in track])


def _largest_error(control, hand):
    return np.linalg.norm(hand - control.targets(hand), axis=1).max()


ANSWERS = {
    function.__name__: function
    for function in (
        facts,
        parameters_with,
        errors,
        targets_at,
        prediction,
        forecast,
        ahead,
        velocities,
        start_points,
        standings_of,
        verdict_on,
    )
}
