"""Quantiles of any number of positive values in bounded memory."""

import math

import numpy as np

LEAST, MOST = 1e-6, 1e3  # values beyond count as these
RATIO = 1.01  # [-] of a bin's upper to its lower edge
COUNT = int(math.ceil(math.log(MOST / LEAST) / math.log(RATIO)))


class LogHistogram:
    """Counts values in bins of equal ratio; a quantile is known within half a bin, 0.5 %."""

    def __init__(self):
        self._counts = np.zeros(COUNT, dtype=np.int64)

    def add(self, values):
        """Count the positive ``values`` (m,)."""
        place = np.log(np.clip(values, LEAST, MOST) / LEAST) / math.log(RATIO)
        np.add.at(self._counts, np.minimum(place.astype(int), COUNT - 1), 1)

    def __len__(self):
        return int(self._counts.sum())

    def quantile(self, share):
        """Return the least value at or below which at least ``share`` of all are; nan of none.

        The geometric mean of the edges of the bin where it lies.
        """
        total = np.cumsum(self._counts)
        if not total[-1]:
            return math.nan
        place = int(np.searchsorted(total, max(1.0, share * total[-1] - 1e-9)))
        return LEAST * RATIO ** (place + 0.5)
