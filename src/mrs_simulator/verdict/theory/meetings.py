"""Which bodies theory itself leads into each other: its points come nearer than bodies can be.

Consensus of robots at one point is the common case.  Theory is of points, and says nothing of a run after
bodies have touched; before a run it warns that they will.
"""

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.claims import proved
from mrs_simulator.core.neighbours import least_distances
from mrs_simulator.record.recording import Run
from mrs_simulator.verdict.theory.exact_runs import exact_run

MOST_DISTANCES = 1e7  # [-] pairs of robots over all samples, above which some samples are looked at
LONG = 1 << 21  # [-] robots over all samples of a run, of which nothing is predicted
SHOWN = 3  # [-] pairs that are named
AHEAD = (
    "theory leads the points of {} nearer to each other than their bodies can be: the theorem is not "
    "judged after the first touch; wanted fidelity: point_mass, or places that are farther apart"
)


@np.errstate(over="ignore", invalid="ignore")  # of theory that goes to infinity
def meetings(team, hand, time, z=None):
    """Return the pairs of rows whose points come too near, and when first [s]: ``{(i, j): time}``, i < j.

    Too near: nearer than the sum of the radii of circles inside both bodies.  ``hand`` (m, n, d) [m]:
    theory's points at ``time`` (m,) [s], and on straight lines in between; ``z`` (n,) [m]: heights of
    robots that pass above each other.
    """
    n = hand.shape[1]
    every = max(1, int(len(hand) * n * n / MOST_DISTANCES))
    rows = np.unique(np.append(np.arange(0, len(hand), every), len(hand) - 1))
    hand, found = hand[np.append(rows, rows[-1])], {}  # where the last sample has them, they stay
    inner = np.array([_inner(kind.body) for kind in team.kinds])
    high = np.array([kind.body.height for kind in team.kinds])
    # Boxes around whole tracks, a little too wide for rounding: most pairs of a large team are apart.
    low, top = np.fmin.reduce(hand).T - 1.001 * inner, np.fmax.reduce(hand).T + 1.001 * inner
    for row in range(n - 1):
        after = slice(row + 1, n)
        meet = (low[:, after] < top[:, [row]]) & (low[:, [row]] < top[:, after])
        others = row + 1 + np.flatnonzero(np.logical_and.reduce(meet))
        if z is not None:
            others = others[np.abs(z[others] - z[row]) < np.maximum(high[row], high[others])]
        if not len(others):
            continue
        near = least_distances(hand[:, others] - hand[:, [row]]) < inner[row] + inner[others]
        for at in np.flatnonzero(near.any(axis=0)).tolist():
            found[row, int(others[at])] = float(time[rows[np.argmax(near[:, at])]])
    return found


def theory_track(control, run, exact, claims):
    """Return ``(hand, time)``, where theory has the points of ``run``, (m, n, d) [m], or None.

    Those of the run ``exact``; where that is None, the protocol's prediction; else the place in which
    proved ``claims`` say that the robots end, at the end alone.
    """
    if exact is not None:
        return exact.hand, exact.time
    start, time = run.hand[0], run.time
    track = call(control.predicted_track, start, time - time[0])
    if track is not None:
        return np.asarray(track, dtype=float), time
    places = [claim.place for claim in proved(claims) if claim.place is not None]
    return (np.broadcast_to(places[0], (1,) + start.shape), time[-1:]) if places else None


def track_ahead(control, run):
    """Return the :func:`theory_track` of a ``run`` of which the start alone is known."""
    exact = call(exact_run, control, run)
    claims = [] if exact is not None else call(control.all_claims, run.hand[0])
    return theory_track(control, run, exact, claims)


def meetings_ahead(control, scenario):
    """Return a list with the warning that theory leads bodies of ``scenario`` together, or none.

    Of runs in which bodies touch, and nothing but the law moves the robots.
    """
    other = scenario.events or scenario.control.safety or control.links.faults
    starts = np.asarray(scenario.starts, dtype=float)
    run = start_run(control, scenario)
    if scenario.fidelity == "point_mass" or other or run.hand[..., 0].size > LONG:
        return []
    try:
        track = track_ahead(control, run)
        found = track and meetings(control.team, *track, z=starts[:, 3:].sum(axis=1))
    except Exception:  # of a law of one's own: what its claims raise, the verdict reports
        return []
    return [AHEAD.format(_named(found))] if found else []


def start_run(control, scenario):
    """Return the ``Run`` of ``scenario`` in which nothing has moved yet: its samples, and the start."""
    steps, every = int(round(scenario.duration / scenario.step)), scenario.steps_per_record
    time = np.arange(0, steps + 1, every) * scenario.step
    starts = np.asarray(scenario.starts, dtype=float)
    shape = (len(time), len(starts))
    pose = np.broadcast_to(starts[:, :3], shape + (3,))
    points = control.points(starts)
    hand = np.broadcast_to(points, shape + points.shape[1:])
    robots = 1 + np.arange(len(starts))
    return Run(time, robots, pose, hand, None, [], scenario, {"lockstep": True})


def _inner(body):
    return min(body.front, body.rear, 0.5 * body.width)


def _named(found):
    pairs = sorted(found, key=found.get)
    said = [
        "robot{} and robot{} (at {:.1f} s)".format(i + 1, j + 1, found[i, j])
        for i, j in pairs[:SHOWN]
    ]
    return ", ".join(said) + (", ..." if len(pairs) > SHOWN else "")
