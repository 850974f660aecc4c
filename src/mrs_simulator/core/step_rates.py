"""Rates in whole steps of the world: the one rule for samples, commands, odometry and sensors.

What is to happen at a rate f happens every ``m`` steps of h, ``m = max(1, round(1/(f h)))``, and so at the
rate ``1/(m h)``, which :func:`rate_note` reports where it differs.
"""

STAMPED = 2e-9  # [s] by which a difference of two stamps of whole nanoseconds may be off
TOLERANCE = 0.01  # [-] by which a rate may differ without a note


def steps_between(rate, step):
    """Return the whole number of steps of ``step`` [s] from one time to the next at ``rate`` [Hz]."""
    return max(1, int(round(1.0 / (rate * step))))


def on_steps(time, step):
    """Return ``time`` [s] as a world counts it, ``k * step`` [s], where a stamp's rounding alone differs.

    Elsewhere ``time`` itself.
    """
    counted = round(time / step) * step
    return counted if abs(counted - time) <= STAMPED else time


def rate_note(what, rate, step):
    """Return a text with the actual rate of ``what``, "" where it is ``rate`` [Hz]."""
    steps = steps_between(rate, step)
    kept = 1.0 / (steps * step)
    if abs(kept - rate) <= TOLERANCE * rate:
        return ""
    text = "{} at {:g} Hz, every {} steps of {:g} s; wanted {:g} Hz"
    return text.format(what, round(kept, 3), steps, step, rate)
