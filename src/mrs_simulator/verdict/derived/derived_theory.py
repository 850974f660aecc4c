"""The linear theory of a law that states none: derived by asking it, and stated in its place."""

import contextlib
import copy
from types import SimpleNamespace

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.control.user_code import call
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.core.writing import Limited
from mrs_simulator.protocols.common import resting
from mrs_simulator.protocols.published.laws import Published
from mrs_simulator.verdict.derived.asking import ideal_scenario, velocities_at
from mrs_simulator.verdict.derived.law_probe import LINEAR, Probe, linear_fit

# methods by which a law states theory
STATES = ("claims", "claims_over_links", "published", "energy", "prediction")
MOST_ROBOTS = 60  # [-] whose law is asked
MOST_COMPARED = 20  # [-] samples of a run, at which the law must be as at the probed states
NONE_DERIVED = "no linear theory is derived from the law, {}"
PLACE = {"point_mass": 0.02, "kinematic": 0.02, "dynamic": 0.05}  # [m] of limits and of what stays
SHARE = 0.02  # [-] of a decay rate
ELSEWHERE = "which in this run is not what it is at the probed states"
LASTING = "of which not all that moves decays"
RAISED = "which raised {} when it was asked"


class Affine(Published):
    """``u = c - M p``, as a law has answered, over all coordinates robot by robot."""

    def __init__(self, matrix, constant):
        self.matrix, self.constant = matrix, constant

    def velocity(self, points, time, memory):
        return self.velocities(points, time, memory), None

    def velocities(self, points, time, memory):
        """Return u (k, n, d) of several teams, or (n, d) of one."""
        rows = points.reshape(points.shape[:-2] + (-1,))
        return (self.constant - rows @ self.matrix.T).reshape(points.shape)


def states_nothing(control):
    """Return whether no method of the law of ``control`` states any theory of it."""
    return all(getattr(type(control), name) is getattr(PioneerControl, name) for name in STATES)


def derived_control(control, run):
    """Return ``(derived, why)``: ``control`` with the linear theory that follows from its answers.

    ``derived`` is None where the law states theory itself or none follows; ``why`` then says what is in
    the way, "" where nothing was asked.
    """
    if not (states_nothing(control) and _can_be_asked(control, run)):
        return None, ""
    try:
        with contextlib.redirect_stdout(Limited(SimpleNamespace(value=0))):
            fit, why = call(_asked, control, run)
    except Exception as error:  # users' code, at places where it never was
        return None, NONE_DERIVED.format(RAISED.format(type(error).__name__))
    if fit is None:
        return None, NONE_DERIVED.format(why)
    theorem = linear_theorem(fit.matrix, fit.constant, exact=False)
    if not theorem.is_stable:
        return None, NONE_DERIVED.format(LASTING)
    return (None, "") if theorem.rate is None else (_stating(control, fit, theorem), "")


def _can_be_asked(control, run):
    """Return whether places of few robots alone decide on commands, which are of unicycles or points."""
    if run.scenario is None or control.SENSORS or control.links.faults:
        return False
    plain = control.team.is_of_unicycles or not control.runner.gives_twists
    return plain and len(control.numbers) <= MOST_ROBOTS


def _asked(control, run):
    """Return the ``Fit`` of the law and "", or None and why there is none."""
    ideal = ideal_scenario(run.scenario)

    def ask(*what):
        return velocities_at(ideal, *what, protocol=type(control))

    probe = Probe(ask, run.hand[0])
    fit, why = linear_fit(probe)
    if fit is None:
        return None, why
    rows = np.linspace(0, len(run.time) - 1, min(MOST_COMPARED, len(run.time))).astype(int)
    found = probe.at(run.hand[rows], run.pose[rows, :, 2], fresh=False)
    wanted = Affine(fit.matrix, fit.constant).velocities(run.hand[rows], 0.0, None)
    most = LINEAR * max(fit.size, np.abs(wanted).max())
    return (fit, "") if np.abs(found - wanted).max() <= most else (None, ELSEWHERE)


def _stating(control, fit, theorem):
    """Return a copy of ``control`` whose law states the ``theorem`` and its equation."""
    law = Affine(fit.matrix, fit.constant)
    stated = {
        "MEMORYLESS": True,
        "published": lambda self: law,
        "claims": lambda self, start: _claims(self, theorem, start),
    }
    result = copy.copy(control)
    result.__class__ = type(type(control).__name__, (type(control),), stated)
    return result


def _claims(control, theorem, start):
    """Return what the ``theorem`` says of a run from ``start``, rates as far as friction lets them show."""
    floor, place = resting(control, len(start)), PLACE[control.fidelity]
    return theorem.claims(start, control.period, place=place, share=SHARE, floor=floor)
