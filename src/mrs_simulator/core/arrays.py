"""Arrays that others may read and not change."""

import numpy as np


def read_only(array):
    """Return a view of ``array`` through which it cannot be changed."""
    view = array.view()
    view.flags.writeable = False
    return view


def are_near(points, about, times, least):
    """Return which of ``points`` (..., d) are near to the box of ``about`` (m, d), a bool array (...).

    Near is within ``times`` the longest side of the box, taken as ``least`` at least; nan is not near.
    """
    low, high = np.nanmin(about, axis=0), np.nanmax(about, axis=0)
    reach = times * max(least, np.max(high - low))
    return ((points >= low - reach) & (points <= high + reach)).all(axis=-1)
