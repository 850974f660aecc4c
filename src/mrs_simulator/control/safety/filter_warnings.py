"""What of its promise the safety filter cannot keep in a scenario, as warnings before the run."""

import numpy as np

from mrs_simulator.control.stopping import greatest, stopping_ways
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.vehicles.odometry_rates import odometry_steps

OUTSIDE = "safety filter: bodies may touch all the same, because of {}: docs/safety.md"
SLOW = "safety filter: {} of robot{} reads at {:g} Hz, wanted the commands' {:g} Hz or more"
SHORT = "safety filter: {} of robot{} reaches {:.2f} m, wanted {:.2f} m at the robots' top speeds{}"
UNBOUNDED = "safety filter: {} of robot{} reaches {:.2f} m, and top speeds are unlimited; wanted {}"
FASTEST = 100.0  # [m/s], from which on no speed counts as limited


def unkept(scenario, control):
    """Return warnings, a list of texts, about what ``control``'s filter cannot promise in ``scenario``."""
    if not np.any(control.safety):
        return []
    outside = _outside(scenario, control)
    found = [OUTSIDE.format("; ".join(outside))] if outside else []
    return found + (_sensed(scenario, control) if control.safety_filter.sensors else [])


def _outside(scenario, control):
    """Return what a scenario has that is outside of the promise, a list of texts."""
    weather, coming = scenario.environment, [each for each in control.obstacles if moves(each)]
    asks = control.safety_filter.sensors or control.safety_filter.surroundings().obstacles
    stands = bool(
        control.safety_filter.surroundings().obstacles or control.safety_filter.surroundings().arena
    )
    blown = scenario.fidelity == "dynamic" and (any(weather.wind) or weather.gusts > 0.0)
    afloat = bool(control.team.afloat.any())
    drifts = scenario.odometry == "wheel" or scenario.estimates is not None
    text = "obstacles that move, {}, at up to {:g} m/s"
    speed = max((each.track.speed for each in coming), default=0.0)
    found = {
        text.format(", ".join(each.name for each in coming), speed): coming and asks,
        "the current, which carries boats against what stands": afloat
        and any(weather.current)
        and stands,
        "the wind": blown,
        "the waves": afloat and scenario.fidelity == "dynamic" and weather.wave_height > 0.0,
        "the mismatch": scenario.mismatch != NO_MISMATCH,
        "places that are estimated, or reckoned from wheels": drifts
        and not control.safety_filter.sensors,
        "places that come less often than commands": _seldom(scenario, control)
        and not control.safety_filter.sensors,
        "robots that are pushed, or fall": bool(scenario.events),
        "arms, which reach beyond their bases": control.team.has_arms,
    }
    return [text for text, holds in found.items() if holds]


def _seldom(scenario, control):
    """Return whether a robot's odometry is older than a command period at some command."""
    if scenario.odometry_rate is None:
        return False
    steps = odometry_steps(control.team, scenario.odometry_rate, scenario.step)
    return bool(steps.max() > scenario.steps_per_command)


def _sensed(scenario, control):
    """Return warnings about sensors that are too slow, or do not reach far enough to brake in time.

    With the commands' period Tc, a rate of readings and the bodies' distance D of a pair, a robot and the
    one that it senses come nearer by ``(v_i + v_j)(Tc + 1/rate)`` and both braking ways before they stand.
    """
    mounts, found = fitted_mounts(control.team, scenario.sensors), []
    tops = _tops(control)
    for name in control.safety_filter.sensors:
        own = [next(each for each in robot if each.name == name) for robot in mounts]
        slow = [each.rate < (1.0 - 1e-9) / control.period for each in own]
        if any(slow):
            row = slow.index(True)
            found.append(SLOW.format(name, row + 1, own[row].rate, 1.0 / control.period))
        found += _short(name, own, control, tops)
    return found


def _tops(control):
    """Return the most that robots go, (n,) [m/s]."""
    tops, cap = control.team.speeds[:, 0], control.safety_filter.speed
    return tops if cap is None else np.minimum(tops, cap)


def _short(name, mounts, control, tops):
    """Return a warning about the first robot whose sensor ``name`` does not reach far enough, a list."""
    most = np.array([each.settings.most for each in mounts])
    hold = control.period + 1.0 / np.array([each.rate for each in mounts])
    if not (tops < FASTEST).all():
        row = int(np.argmin(most))
        return [UNBOUNDED.format(name, row + 1, most[row], "a speed: control.safety.speed")]

    def wanted(speed):
        return _reaching(control, mounts, np.minimum(tops, speed), hold)

    needed = wanted(np.inf)
    row = int(np.argmax(needed - most))
    if needed[row] <= most[row]:
        return []
    would = greatest(lambda speed: bool((wanted(speed) <= most).all()), float(tops.max()))
    more = ", or speeds of at most {:.2f} m/s".format(int(100.0 * would) / 100.0)
    more = more if would >= 0.01 else ""
    return [SHORT.format(name, row + 1, most[row], needed[row], more)]


def _reaching(control, mounts, speeds, hold):
    """Return how far (n,) [m] robots have to sense others at ``speeds`` (n,) [m/s]."""
    ways = stopping_ways(control.team, speeds, float(hold.max()))
    if control.fidelity == "dynamic":
        ways = ways + speeds * np.array([kind.run_on for kind in control.team.kinds])
    lead = np.broadcast_to(control.team.lead(control.l), len(speeds))
    body = control.safety_filter.body_radii + lead
    # A range-and-bearing sensor measures to centres, the others to what they meet of a body.
    centres = np.array([each.type == "range_bearing" for each in mounts])
    other = np.where(centres[:, np.newaxis], body, 0.0) + ways
    np.fill_diagonal(other, 0.0)
    return body + ways + other.max(axis=1)
