"""Extrema over windows of samples, along the last axis."""

import numpy as np

EVEN = 1e-4  # [-] of the period, by which samples that count as evenly apart are off


class Windows:
    """For each of m samples those between ``first`` and ``end`` [s] later.

    A window that reaches past the last sample is *cut*: what comes there is not known.
    """

    def __init__(self, time, window):
        """``time`` (m,) [s], increasing; ``window``: first and last [s], infinite to the last sample.

        Raises ``ValueError`` where a window within the run holds no sample.
        """
        first, last = window
        slack = 1e-6 * _period(time)
        self.begin = _first_at(time, first - slack)  # (m,), m where there is none
        self.unbounded = np.isinf(last)
        if self.unbounded:
            self.end = np.full(len(time), len(time))
            self.cut = np.zeros(len(time), dtype=bool)
            return
        self.end = _first_at(time, last + slack, "right")
        self.cut = time + (last - slack) > time[-1]
        if (self.end[~self.cut] <= self.begin[~self.cut]).any():
            apart = float(np.max(np.diff(time)))
            text = "no sample lies within [{:g}, {:g}] s from another: they are up to {:g} s apart"
            raise ValueError(text.format(first, last, apart))
        # At which sample each window is known to its end, m where none is.
        self.known = _first_at(time, last - slack)

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


def _period(time):
    """Return the median time [s] between two samples, 0 of one alone; of even ones their mean."""
    if len(time) < 2:
        return 0.0
    apart = np.diff(time)
    mean = float(time[-1] - time[0]) / len(apart)
    even = max(apart.max() - mean, mean - apart.min()) <= EVEN * mean
    return mean if even else float(np.median(apart))


def _first_at(time, later, side="left"):
    """Return ``np.searchsorted(time, time + later, side)``: the first sample so much later, m for none.

    That takes ten times as long as to look whether all are as many samples later, which they mostly are.
    """
    m, wanted = len(time), time + later
    if m > 1:
        comes = np.greater_equal if side == "left" else np.greater
        shift = int(np.searchsorted(time, wanted[0], side))
        head = m - shift
        before = time[max(0, shift - 1) : m - 1], wanted[max(0, 1 - shift) : head]
        late = comes(time[shift:], wanted[:head]).all() and not comes(*before).any()
        if late and not comes(time[-1], wanted[head:]).any():
            return np.minimum(np.arange(shift, shift + m), m)
    return np.searchsorted(time, wanted, side)


def range_maximum(values, begin, end):
    """Return the maxima of ``values`` (..., m) over [begin, end), -inf of an empty range.

    Each range is covered by two of a power of two samples; the maxima over all of such ranges come
    from those of half the length.
    """
    m = len(begin)
    if m and values.shape[-1] == m:
        first, width = int(begin[0]), int(end[0] - begin[0])
        rows = np.arange(m)
        if np.array_equal(begin, np.minimum(rows + first, m)) and np.array_equal(
            end, np.minimum(rows + first + width, m)
        ):
            return sliding_maximum(values, first, width)
    return _range_maximum(values, begin, end)


def sliding_maximum(values, first, width):
    """Return the maxima of ``values`` (..., m) over the ``width`` samples from ``first`` later on.

    By doubling: a pass over all samples is so much faster than a running maximum, which no vector
    instruction computes, that ten of them take a fifth of the time of the two of van Herk.
    """
    m = values.shape[-1]
    width = min(width, m)
    if width <= 0 or first >= m:
        return np.full(values.shape, -np.inf)
    maxima = np.full((*values.shape[:-1], m + width - 1), -np.inf)
    maxima[..., : m - first] = values[..., first:]
    length = 1
    while 2 * length <= width:
        maxima = np.maximum(maxima[..., :-length], maxima[..., length:])
        length *= 2
    return np.maximum(maxima[..., :m], maxima[..., width - length : width - length + m])


def _range_maximum(values, begin, end):
    """Return the same of ranges that do not slide from sample to sample."""
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


def least_from(values):
    """Return the least of ``values`` (..., m) from each sample to the last."""
    return np.minimum.accumulate(values[..., ::-1], axis=-1)[..., ::-1]


def until_end(left, right):
    """Return ``u[t] = max(right[t], min(left[t], u[t + 1]))`` along the last axis; ``u[m] = -inf``.

    The map from ``u[t + s]`` to ``u[t]`` is ``x -> max(g, min(f, x))``, and two such maps in a row make
    one: all are joined by doubling s, until g changes no more.
    """
    g, f, room = right.copy(), left.copy(), np.empty(right.shape)
    shift, m = 1, g.shape[-1]
    while shift < m:
        head, tail = np.s_[..., : m - shift], np.s_[..., shift:]
        joined = np.minimum(f[head], g[tail], out=room[head])
        if (joined <= g[head]).all():
            break
        g[head] = np.maximum(g[head], joined, out=joined)
        f[head] = np.minimum(f[head], f[tail], out=joined)
        shift *= 2
    return g


def until_within(left, right, windows):
    """Return ``max over t' in W of min(right[t'], min of left over [t, t'))``, (..., m), W of ``windows``.

    ``f until[0,c] g = min(eventually[0,c] g, f until g)``, and a later window is one that is moved.
    """
    left, right = np.broadcast_arrays(left, right)
    found, m = until_end(left, right), len(windows.begin)
    if windows.begin[0] > 0:
        found = np.where(windows.begin < m, found[..., np.minimum(windows.begin, m - 1)], -np.inf)
        found = np.minimum(found, -range_maximum(-left, np.arange(m), windows.begin))
    if not windows.unbounded:
        found = np.minimum(found, windows.maximum(right))
    return found
