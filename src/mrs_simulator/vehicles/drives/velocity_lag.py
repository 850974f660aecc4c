"""Velocities that follow those wanted: with a time constant, and no faster than a greatest acceleration."""

import numpy as np

NO_LIMIT = 1e12  # [m/s^2] stands for no limit of acceleration
NO_LAG = 1e-12  # [s] stands for no time


def remaining_error(size, response, most, duration):
    """Return errors after ``duration`` [s], and their means over it, of errors of ``size`` (>= 0) at first.

    The exact solution of ``e' = -min(e/T, A)``, T the ``response`` [s] and A ``most``: at a constant rate
    down to ``A T``, from there on exponentially.  All shapes that go together.
    """
    response, most = np.maximum(response, NO_LAG), np.minimum(most, NO_LIMIT)
    steady = np.minimum(np.maximum(size / most - response, 0.0), duration)
    reached = size - most * steady
    share = np.exp((steady - duration) / response)
    area = 0.5 * (size + reached) * steady + reached * response * (1.0 - share)
    return reached * share, area / duration
