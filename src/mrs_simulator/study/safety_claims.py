"""What the safety filter claims of a run, whatever the protocol."""

import functools

import numpy as np

from mrs_simulator.core.claims import Claim, Condition, stays_above
from mrs_simulator.core.neighbours import least_distance, squared

# [m] by which a held arc, or wheels that slip, may take a hand point nearer than a point mass would be.
TOLERANCE = {"point_mass": 1e-9, "kinematic": 0.02, "dynamic": 0.05}
CLEARANCE = "least clearance of obstacles and border [m]"
SPEED = "largest share of a speed cap [-]"
ROUNDING = 1e-6  # [-] of a cap


def safety_claims(control, start):
    """Return what the safety filter claims of a run from hand points ``start`` (n, d)."""
    if not np.any(control.safety):
        return []
    return _apart(control, start) + _clear(control, start) + _capped(control)


def _apart(control, start):
    if len(start) < 2 or not control.filter_sees_robots:
        return []
    wanted, squash = control.kept_distance, control.safe_squash
    least, name = wanted, "least distance of two hand points [m]"
    if np.ndim(wanted):
        least, name = 0.0, "least distance of two hand points beyond what the pair needs [m]"

    if squash is not None:
        name = name.replace("[m]", "(above each other {:g} times) [m]".format(1.0 / squash[2]))

    def measured(points):
        points = points if squash is None else points * squash
        return _least_slack(points, wanted) if np.ndim(wanted) else least_distance(points)

    begun = measured(start)
    why = "{}: {:.2f} m at the start, wanted {:.2f} m".format(name[:-4], begun, least)
    return [
        Condition("robots start apart", begun >= least, why, necessary=True),
        stays_above(_of_each(measured), least, name, TOLERANCE[control.fidelity]),
    ]


def _clear(control, start):
    # What a robot senses tells it not how fast things come.
    flees = not control.filter_sensors and control.filter_flees

    def gap(points, time):
        bounds = control.safe_bounds(points, time, standing=not flees)
        return float(bounds.gap.min(initial=np.inf))

    begun = gap(start, 0.0)
    if begun == np.inf:
        return []
    least = functools.partial(_least_gap, gap)
    why = "{}: {:.2f} m at the start, wanted 0 m".format(CLEARANCE[:-4], begun)
    claim = Claim(CLEARANCE, 0.0, TOLERANCE[control.fidelity], least, "at least")
    return [
        Condition("robots start clear of obstacles and border", begun >= 0.0, why, necessary=True),
        claim._replace(unproved=_outrun(control, flees) if flees else ""),
    ]


def _least_gap(gap, run):
    return min(map(gap, run.hand, run.time))


def _outrun(control, flees):
    """Return why robots need not be able to flee from obstacles that come at ``flees`` [m/s], or ""."""
    slowest = float(control.team.speeds[:, 0].min())
    if control.safe_speed is not None:
        slowest = min(slowest, float(control.safe_speed.min()))
    if flees >= slowest:
        return "obstacles come at up to {:g} m/s, robots go {:g} m/s".format(flees, slowest)
    at_once = np.isinf(control.limits.acceleration).all() and control.fidelity != "dynamic"
    return "" if at_once else "obstacles come, and robots take time to speed up"


def _capped(control):
    cap = control.safe_speed
    if cap is None:
        return []

    def share(run):
        return float((np.linalg.norm(control.velocities(run), axis=2) / cap).max())

    return [Claim(SPEED, 1.0, ROUNDING, share, "at most")]


def _of_each(measured):
    """Return the quantity that ``measured(points)`` makes of each sample's points."""
    return lambda hand: np.array([measured(points) for points in hand])


def _least_slack(points, wanted):
    """Return by how much [m] the pair that has least is farther apart than ``wanted`` (n, n)."""
    first, second = np.triu_indices(len(points), 1)
    apart = np.sqrt(squared(points[first] - points[second]))
    return float((apart - wanted[first, second]).min())
