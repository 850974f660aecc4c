"""What the safety filter claims of a run, whatever the protocol."""

import numpy as np

from mrs_simulator.control.safety.distances import sums_of_pairs
from mrs_simulator.core.claims import Claim, Condition
from mrs_simulator.core.neighbours import least_distance, squared

TOLERANCE = 1e-9  # [m], of rounding: bodies do not touch
CLEARANCE = "least clearance of obstacles and border [m]"
SPEED = "largest share of a speed cap [-]"
ROUNDING = 1e-6  # [-] of a cap


def safety_claims(control, run):
    """Return what the safety filter claims of ``run``."""
    if not np.any(control.safety):
        return []
    return _apart(control, run) + _clear(control, run) + _capped(control)


def _places(control, run):
    """Return the places (m, n, d) [m] by which robots are judged: of points themselves, else of centres."""
    points = control.fidelity == "point_mass" or control.dimension == 3
    return run.hand if points else run.pose[:, :, :2]


def _reach(control):
    """Return how far (n,) [m] robots are to be from what stands, measured from those places."""
    lead = control.team.lead(control.l) if control.fidelity == "point_mass" else 0.0
    return control.safety_filter.body_radii + lead


def _apart(control, run):
    if len(run.hand[0]) < 2 or not control.safety_filter.sees_robots:
        return []
    wanted, squash = sums_of_pairs(_reach(control)), control.safety_filter.squash
    least, name = wanted, "least distance of two robots [m]"
    if np.ndim(wanted):
        least, name = 0.0, "least distance of two robots beyond what the pair needs [m]"

    if squash is not None:
        name = name.replace("[m]", "(above each other {:g} times) [m]".format(1.0 / squash[2]))

    def measured(points):
        points = points if squash is None else points * squash
        return _least_slack(points, wanted) if np.ndim(wanted) else least_distance(points)

    def least_of(run):
        return min(map(measured, _places(control, run)))

    begun = measured(_places(control, run)[0])
    why = "{}: {:.2f} m at the start, wanted {:.2f} m".format(name[:-4], begun, least)
    return [
        Condition("robots start apart", begun >= least, why, necessary=True),
        Claim(name, least, TOLERANCE, least_of, "at least"),
    ]


def _clear(control, run):
    # What a robot senses does not say how fast things come.
    flees = not control.safety_filter.sensors and control.safety_filter.flees

    def gap(points, time):
        around = control.safety_filter.surroundings(standing=not flees)
        bounds = around.bounds(
            points, _reach(control), control.safety_filter.scene_time(time), control.period
        )
        return float(bounds.gap.min(initial=np.inf))

    begun = gap(_places(control, run)[0], 0.0)
    if begun == np.inf:
        return []

    def least(run):
        return min(map(gap, _places(control, run), run.time))

    why = "{}: {:.2f} m at the start, wanted 0 m".format(CLEARANCE[:-4], begun)
    claim = Claim(CLEARANCE, 0.0, TOLERANCE, least, "at least")
    return [
        Condition("robots start clear of obstacles and border", begun >= 0.0, why, necessary=True),
        claim._replace(unproved=_outrun(control, flees) if flees else ""),
    ]


def _outrun(control, flees):
    """Return why robots need not be able to flee from obstacles that come at ``flees`` [m/s], or ""."""
    slowest = float(control.team.speeds[:, 0].min())
    if control.safety_filter.speed is not None:
        slowest = min(slowest, float(control.safety_filter.speed.min()))
    if flees >= slowest:
        return "obstacles come at up to {:g} m/s, robots go {:g} m/s".format(flees, slowest)
    at_once = np.isinf(control.limits.acceleration).all() and control.fidelity != "dynamic"
    return "" if at_once else "obstacles come, and robots take time to speed up"


def _capped(control):
    cap = control.safety_filter.speed
    if cap is None:
        return []

    def share(run):
        return float((np.linalg.norm(control.velocities(run), axis=2) / cap).max())

    return [Claim(SPEED, 1.0, ROUNDING, share, "at most")]


def _least_slack(points, wanted):
    """Return by how much [m] the pair that has least is farther apart than ``wanted`` (n, n)."""
    first, second = np.triu_indices(len(points), 1)
    apart = np.sqrt(squared(points[first] - points[second]))
    return float((apart - wanted[first, second]).min())
