"""Extrema over windows of samples, along the last axis."""

import numpy as np


class Windows:
    """For each of m samples those between ``first`` and ``end`` [s] later.

    A window that reaches past the last sample is *cut*: what comes there is not known.
    """

    def __init__(self, time, window):
        """``time`` (m,) [s], increasing; ``window``: first and last [s], infinite to the last sample.

        Raises ``ValueError`` where a window within the run holds no sample.
        """
        first, last = window
        slack = 1e-6 * float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        self.begin = np.searchsorted(time, time + (first - slack))  # (m,), m where there is none
        self.unbounded = np.isinf(last)
        if self.unbounded:
            self.end = np.full(len(time), len(time))
            self.cut = np.zeros(len(time), dtype=bool)
            return
        self.end = np.searchsorted(time, time + (last + slack), side="right")
        self.cut = time + (last - slack) > time[-1]
        if (self.end[~self.cut] <= self.begin[~self.cut]).any():
            apart = float(np.max(np.diff(time)))
            text = "no sample lies within [{:g}, {:g}] s from another: they are up to {:g} s apart"
            raise ValueError(text.format(first, last, apart))

    def maximum(self, values):
        """Return the largest of ``values`` (..., m) in each window, (..., m), -inf in an empty one."""
        if self.unbounded:
            suffix = np.maximum.accumulate(values[..., ::-1], axis=-1)[..., ::-1]
            return _shifted(suffix, self.begin, -np.inf)
        return range_maximum(values, self.begin, self.end)


def _shifted(values, rows, beyond):
    """Return ``values`` at ``rows``, ``beyond`` where there is no such row."""
    if len(rows) and rows[0] == 0 and rows[-1] == len(rows) - 1:
        return values
    result = values[..., np.minimum(rows, values.shape[-1] - 1)]
    return np.where(rows < values.shape[-1], result, beyond)


def range_maximum(values, begin, end):
    """Return the maxima of ``values`` (..., m) over [begin, end), -inf of an empty range.

    Each range is covered by two of a power of two samples; the maxima over all of such ranges come
    from those of half the length.
    """
    width = end - begin
    result = np.full(values.shape, -np.inf)
    level = np.frexp(np.maximum(width, 1))[1] - 1  # floor(log2(width))
    maxima, length = values, 1
    for exponent in range(int(level.max(initial=0)) + 1):
        at = np.flatnonzero((level == exponent) & (width > 0))
        if len(at):
            left, right = maxima[..., begin[at]], maxima[..., end[at] - length]
            result[..., at] = np.maximum(left, right)
        if 2 * length > values.shape[-1]:
            break
        maxima = np.maximum(maxima[..., :-length], maxima[..., length:])
        length *= 2
    return result


def until_end(left, right, beyond):
    """Return ``u[t] = max(right[t], min(left[t], u[t + 1]))`` along the last axis; ``u[m] = beyond``.

    The map from ``u[t + s]`` to ``u[t]`` is ``x -> max(g, min(f, x))``, and two such maps in a row make
    one: all are joined by doubling s.
    """
    g, f = right.copy(), left.copy()
    shift, m = 1, g.shape[-1]
    while shift < m:
        head, tail = np.s_[..., : m - shift], np.s_[..., shift:]
        joined = np.maximum(g[head], np.minimum(f[head], g[tail]))
        f[head] = np.minimum(f[head], f[tail])
        g[head] = joined
        shift *= 2
    return np.maximum(g, np.minimum(f, beyond))
