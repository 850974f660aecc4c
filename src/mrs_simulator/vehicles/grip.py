"""What the friction of wheels lets a robot speed up by."""

import numpy as np

ON_WHEELS = 0.5  # [-] of the weight, of two wheels that drive
GRAVITY = 9.81  # [m/s^2]


def grip(kind):
    """Return the greatest acceleration [m/s^2] and turn acceleration [rad/s^2] of a ``kind``, (2,).

    Of a differential drive whose body is a box of even mass; half of the weight is on two wheels that
    drive, all of it on four.  Infinite without friction, which a kind then does not know.
    """
    if kind.numbers.friction <= 0.0:
        return np.inf, np.inf
    share = 1.0 if kind.numbers.wheelbase else ON_WHEELS
    along = share * kind.numbers.friction * GRAVITY
    arm = (kind.body.length**2 + kind.body.width**2) / 12.0  # [m^2], inertia over mass
    return along, along * 0.5 * kind.numbers.track / arm
