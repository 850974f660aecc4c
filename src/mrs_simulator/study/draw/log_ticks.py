"""Ticks of logarithmic axes that can be read, whatever part of a scale is in view."""

import numpy as np
from matplotlib.ticker import Formatter, Locator, LogFormatterMathtext, MaxNLocator, NullFormatter

FEWEST = 3  # [-] labels in view, where there is room
CLOSE = 1e-9  # [-] to an end of what is in view: a tick there is in view


class LogTicks(Locator):
    """Powers of ten; where few are in view 1, 2 and 5 times these; within less than that round numbers."""

    def __call__(self):
        """Return the places of the ticks."""
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin, vmax):
        """Return the places of the ticks between ``vmin`` and ``vmax``, both positive."""
        low, high = sorted((vmin, vmax))
        room = max(FEWEST - 1, self.axis.get_tick_space())
        first, last = np.log10([low, high])
        powers = 10.0 ** np.arange(np.ceil(first - CLOSE), np.floor(last + CLOSE) + 1.0)
        parts = 10.0 ** np.arange(np.floor(first), np.ceil(last) + 1.0)
        parts = np.outer(parts, (1.0, 2.0, 5.0)).ravel()
        parts = parts[(parts >= low * (1.0 - CLOSE)) & (parts <= high * (1.0 + CLOSE))]
        if len(powers) >= FEWEST or len(powers) > 1 and len(parts) > room:
            return powers[:: -int(np.ceil(len(powers) / room))][::-1]
        if len(parts) >= FEWEST:
            return parts
        places = MaxNLocator(min(5, room), steps=[1, 2, 5, 10]).tick_values(low, high)
        return places[places > 0.0]


class LogNumbers(Formatter):
    """Powers of ten as such where all labels are, else plain numbers."""

    def __call__(self, value, pos=None):
        """Return the text of one tick."""
        return "{:.6g}".format(value)

    def format_ticks(self, values):
        """Return the texts of all ticks."""
        values = np.asarray(values, dtype=float)
        if not (len(values) > 1 and _are_powers_of_ten(values)):
            return [self(value) for value in values]
        powers = LogFormatterMathtext()
        powers.set_axis(self.axis)
        return powers.format_ticks(values)


def _are_powers_of_ten(values):
    exponents = np.log10(values)
    return np.allclose(exponents, exponents.round(), atol=CLOSE)


def label_log(axis):
    """Give a logarithmic ``axis`` ticks that can be read."""
    axis.set_major_locator(LogTicks())
    axis.set_major_formatter(LogNumbers())
    axis.set_minor_formatter(NullFormatter())
