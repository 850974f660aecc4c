"""Certificates of a run: the balance of its energy and the connectivity of its graph, claimed and drawn."""

import numpy as np

from mrs_simulator.control.laws.exactness import at_limit
from mrs_simulator.core.claims import Claim
from mrs_simulator.core.curves import Curve, energy_curve, energy_residual
from mrs_simulator.core.spectra import ZERO, algebraic_connectivity

BALANCE = "energy off its predicted change [-]"
CONNECTED = "least connectivity lambda_2 of the graph of places"
ROBOTS = {"point_mass": 0.0, "kinematic": 0.02, "dynamic": 0.05}  # [-] that arcs and slip may cost
TELLING = 0.15  # [-] a balance that may be off by more tells nothing
MOST_GRAPHS = 500  # samples whose graphs are looked at, spread evenly over longer runs


def certificate_claims(control, run):
    """Return the claims on the energy's balance and on connectivity, those that ``control`` has."""
    claims, energy = [], _energy(control, run)
    if energy is not None:
        residual, allowed = energy_residual(energy, run, control.period)
        tolerance = allowed + ROBOTS[control.fidelity]

        def off(of):
            return residual if of is run else energy_residual(energy, of, control.period)[0]

        if tolerance <= TELLING:
            claims.append(Claim(BALANCE, 0.0, tolerance, off, "at most", free=True, own=True))
    if control.KEEPS_CONNECTED:
        claims.append(
            Claim(
                CONNECTED,
                ZERO,
                0.0,
                lambda of: float(connectivity(control, of)[1].min()),
                "at least",
            )
        )
    return claims


def certificate_curves(control, run):
    """Return the curves of ``run`` beside theory: those of the protocol, its energy, its connectivity."""
    curves, energy = list(control.curves(run)), _energy(control, run)
    if energy is not None:
        curves.append(_energy_drawn(control, energy, run))
    if control.graph_at(run.hand[0], run.hand[0]) is not None:
        time, values = connectivity(control, run)
        name = r"connectivity $\lambda_2$ [-]"
        bound = 0.0 if control.KEEPS_CONNECTED else None
        curves.append(Curve(name, time, values, bound=bound))
    return curves


def _energy(control, run):
    """Return the energy of ``run``, None where no theorem says how it falls."""
    # One factor for the whole team changes how fast.
    retimed = control.saturation == "team" and at_limit(control, run.command).any()
    if control.links.faults or retimed or len(run.time) < 3:
        return None
    return control.energy(run.hand[0])


def _energy_drawn(control, energy, run):
    """Return the curve of ``energy``, predicted from the last time on that a robot was at a limit.

    Where samples are too far apart for a prediction only what was measured is drawn.
    """
    curve, first = energy_curve(energy, run), 0
    if control.saturation != "none":
        limited = np.flatnonzero(at_limit(control, run.command).any(axis=1))
        first = int(limited[-1]) + 1 if len(limited) else 0
    if (
        len(run.time) - first < 3
        or energy_residual(energy, _from(run, first), control.period)[1] > TELLING
    ):
        return curve._replace(predicted=None)
    predicted = curve.predicted + curve.measured[first] - curve.predicted[first]
    return curve._replace(predicted=predicted[first:], predicted_at=curve.at[first:])


def _from(run, first):
    names = ("time", "pose", "hand", "command")
    return run._replace(**{name: getattr(run, name)[first:] for name in names})


def connectivity(control, run):
    """Return times (k,) [s] and ``lambda_2`` (k,) of the graphs that the places of ``run`` make."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, min(len(run.time), MOST_GRAPHS)).astype(int))
    values = [algebraic_connectivity(control.graph_at(run.hand[0], run.hand[row])) for row in rows]
    return run.time[rows] - run.time[0], np.array(values)
