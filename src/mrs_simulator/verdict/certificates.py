"""Certificates of a run: the balance of its energy and the connectivity of its graph, claimed and drawn."""

import numpy as np

from mrs_simulator.core.claims import LAW, Claim, NothingDecays
from mrs_simulator.core.spectra import ZERO, algebraic_connectivity
from mrs_simulator.protocols.curves import Curve
from mrs_simulator.verdict.energy_balance import MOST_ROBOTS, balance_of
from mrs_simulator.verdict.estimation import estimation_curves
from mrs_simulator.verdict.law.published_checks import at_limit

BALANCE = "energy off its predicted change [-]"
CONNECTED = "least connectivity lambda_2 of the graph of places"
TELLING = 0.15  # [-] a balance that may be off by more shows nothing
COARSE = "robots go elsewhere than their commands say by up to {:.0%} of the energy"
LIMITED = "some robot was at a limit all the time"
UNTIMED = "commands were not held for whole periods from the samples on: no lockstep"
MOST_GRAPHS = 500  # samples whose graphs are looked at, spread evenly over longer runs


def certificate_claims(control, run, balanced=True):
    """Return the claims on the energy's balance and on connectivity, those that ``control`` has.

    ``balanced``: whether the balance is wanted, which takes long to make.
    """
    claims, energy = [], _energy(control, run) if balanced else None
    if energy is not None:
        claims.append(_balance_claim(control, energy, run))
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


def _balance_claim(control, energy, run):
    balance = balance_of(control, energy, run)
    why = "" if run.meta.get("lockstep") else UNTIMED

    def off(of):
        found = balance if of is run else balance_of(control, energy, of)
        if found.residual is None:
            raise NothingDecays(LIMITED if found.scale == 0.0 < found.measured[0] else "")
        if found.allowed > TELLING:
            raise NothingDecays(COARSE.format(found.allowed))
        return found.residual

    return Claim(BALANCE, 0.0, balance.allowed, off, "at most", balance.free, why, question=LAW)


def certificate_curves(control, run):
    """Return the curves of ``run`` beside theory: those of the protocol, its energy, its connectivity."""
    curves, energy = list(control.curves(run)) + estimation_curves(run), _energy(control, run)
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
    if control.links.faults or len(run.time) < 3 or len(run.robots) > MOST_ROBOTS:
        return None
    return control.energy(run.hand[0])


def _energy_drawn(control, energy, run):
    """Return the curve of ``energy``, predicted from the last time on that a robot was at a limit.

    Where samples are too far apart for a prediction only what was measured is drawn.
    """
    balance, first = balance_of(control, energy, run), 0
    time = run.time - run.time[0]
    curve = Curve(energy.name, time[balance.rows], balance.measured)
    if control.saturation != "none":
        limited = np.flatnonzero(at_limit(control, run).any(axis=1))
        first = int(limited[-1]) + 1 if len(limited) else 0
    late = balance.since(first)
    if len(late.rows) < 3 or balance.allowed > TELLING:
        return curve
    return curve._replace(predicted=late.predicted, predicted_at=time[late.rows])


def connectivity(control, run):
    """Return times (k,) [s] and ``lambda_2`` (k,) of the graphs that the places of ``run`` make."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, min(len(run.time), MOST_GRAPHS)).astype(int))
    values = [algebraic_connectivity(control.graph_at(run.hand[0], run.hand[row])) for row in rows]
    return run.time[rows] - run.time[0], np.array(values)
