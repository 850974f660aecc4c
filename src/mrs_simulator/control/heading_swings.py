"""Hand lengths with which a robot's heading may swing for ever, as warnings before the run.

The hand point, l [m] ahead of the axle, is to move at v [m/s] in a direction that is off by phi [rad]:
the commanded rate of turn is ``-v/l sin(phi)``, held for a period Tc [s]; the robot ramps its own at
a [rad/s^2], and from one ramp to the other where it meets the command.  That command is one of d ago,
``0 <= d <= Tc``.  A swing that goes through ``phi = 0`` at its greatest rate W had the rate ``W - a d`` at
that time, and phi was ``-(W d - a d^2/2)``.  It goes on for ever if

    W (1 - d v/l) = a d (1 - d v/(2 l)).

With ``Tc v/l < 1`` larger swings than this W, which is of order ``a Tc``, shrink, whatever d is.  Beyond
it some grow until the rate of turn is at its limit w, and the heading then swings by ``w^2/(2 a)``.  A
ramp to w that takes no longer than a period is done before the next command: swings are small then.
On full dynamics wheels ramp no faster than their grip lets them.
"""

import math

import numpy as np

from mrs_simulator.vehicles.drives import differential
from mrs_simulator.vehicles.grip import grip

TEXT = (
    "the heading of robot{} may swing for ever: l = {:g} m is short for commands at {:g} Hz, {:g} m/s and"
    " its ramp of turning; wanted {:g} m or more, or {:g} Hz or more: docs/protocols.md"
)
EXACT = 1e-9  # [-] of numbers that are rounded


def swings(control):
    """Return a warning about a robot of ``control`` whose hand point is too near its axle, a list.

    The fastest of those whose rate of turn ramps to its limit for longer than a period Tc and whose
    ``l < Tc v``, with their top speed v [m/s] or the safety filter's.  Laws that give Twists have no
    hand points.
    """
    if control.fidelity == "point_mass" or control.runner.gives_twists:
        return []
    team, period, l = control.team, control.period, control.l
    speed, cap = team.speeds[:, 0], control.safety_filter.speed
    wanted = period * (speed if cap is None else np.minimum(speed, cap))
    short = np.zeros(team.n, dtype=bool)
    for group in team.groups:
        if group.drive.POINT == "hand point" and group.drive.RAMPS:
            top, acceleration = (each[..., 1] for each in group.limits)
            if control.fidelity == "dynamic" and group.drive is differential:
                rows = np.arange(team.n)[group.rows]
                gripped = [grip(team.kinds[row])[1] for row in rows]
                acceleration = np.minimum(acceleration, gripped)
            short[group.rows] = top > (1.0 + EXACT) * acceleration * period
    short &= (l < (1.0 - EXACT) * wanted) & np.isfinite(wanted)
    if not short.any():
        return []
    row = int(np.argmax(short * wanted))
    need = math.ceil(1e3 * (1.0 - EXACT) * wanted[row]) / 1e3
    rate = math.ceil((1.0 - EXACT) * wanted[row] / (period * l))
    return [TEXT.format(row + 1, l, 1.0 / period, wanted[row] / period, need, rate)]
