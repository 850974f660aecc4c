"""Data of the curves panel as plain arrays, without Qt."""

import re
import threading
import time as clock
from typing import Callable, NamedTuple

import numpy as np

from mrs_simulator.rqt_plugin.widgets.guard import LOG
from mrs_simulator.state.columns import OUT_OF_PLANE
from mrs_simulator.study.draw.figure_parts import thin

PATIENCE = 0.03  # [s] for the formation error within one redraw
FIRST_CHUNK, LARGEST_CHUNK = 20, 500  # [-] samples given to the error's function at once
LEAST_SPAN = 0.02  # of a linear axis that fits itself, so that rest looks like rest
MOST_DECADES = 12.0  # of a logarithmic axis that fits itself
NO_ERROR = "The protocol defines no formation error for this team and graph"


class Quantity(NamedTuple):
    """What one tab shows."""

    tab: str
    label: str  # on the axis; formulas in $ $
    unit: str
    meaning: str
    values: Callable  # of a ``StateTable`` of m times: (m, n)


class Curve(NamedTuple):
    """One line of the plot."""

    name: str
    time: np.ndarray  # (m,) [s]
    values: np.ndarray  # (m,)
    style: dict  # of a matplotlib line
    run: str = ""  # the name of its run where several are compared
    robot: int = 0  # its number, 0 for none


def heading(state):
    """Return the headings (m, n) [rad] without the jumps between -pi and pi."""
    wrapped = state.pose[:, :, 2]
    turns = np.round(np.diff(wrapped, axis=0) / (2.0 * np.pi))
    if not np.any(turns):
        return wrapped
    whole = wrapped.copy()
    whole[1:] -= 2.0 * np.pi * np.cumsum(np.nan_to_num(turns), axis=0)
    return whole


def _climb(state):
    """Return velocities (m, n) [m/s] along the upward axis; zeros of what was on the ground."""
    there = state.has(OUT_OF_PLANE)
    return state.out_of_plane[:, :, 0] if there else np.zeros(state.pose.shape[:2])


QUANTITIES = (
    Quantity("x", "$x$", "m", "x in the common frame [m]", lambda h: h.pose[:, :, 0]),
    Quantity("y", "$y$", "m", "y in the common frame [m]", lambda h: h.pose[:, :, 1]),
    Quantity("\u03b8", r"heading $\theta$", "rad", "Heading, without jumps [rad]", heading),
    Quantity("v", "$v$", "m/s", "Linear velocity v [m/s]", lambda h: h.twist[:, :, 0]),
    Quantity(
        "\u03c9",
        r"$\omega$",
        "rad/s",
        "Angular velocity \u03c9 [rad/s]",
        lambda h: h.twist[:, :, 2],
    ),
    Quantity("error", "formation error", "m", "Formation error of the team and theory [m]", None),
    Quantity(
        "v\u1d67",
        r"lateral $v_y$",
        "m/s",
        "Velocity to the left of the heading [m/s]",
        lambda h: h.twist[:, :, 1],
    ),
    Quantity("z", "$z$", "m", "Height above the ground [m]", lambda h: h.heights),
    Quantity("climb", r"climb $v_z$", "m/s", "Velocity along the body's upward axis [m/s]", _climb),
)
ERROR, LATERAL, HEIGHT, CLIMB = 5, 6, 7, 8
ORDER = (0, 1, HEIGHT, 2, 3, LATERAL, CLIMB, 4, ERROR)  # of the tabs
OF_AXES = {LATERAL: "linear.y"}  # quantities only of robots commanded along an axis
OF_SPACE = (HEIGHT, CLIMB)  # what only a team that leaves the ground has


def shown_quantities(axes, in_space=False):
    """Return the indices in ``QUANTITIES`` of the quantities of a team commanded along ``axes``.

    ``in_space``: whether it leaves the ground.
    """
    shown = [index for index in ORDER if OF_AXES.get(index, axes[0]) in axes]
    return [index for index in shown if in_space or index not in OF_SPACE]


def parse_robots(text):
    """Return the ranges ``((low, high), ...)`` of "1-3, 7"; raise ``ValueError`` with the reason."""
    ranges = []
    for part in re.split(r"[,;\s]+", re.sub(r"\s*[-\u2013]\s*", "-", text.strip())):
        found = re.match(r"^(\d{1,9})(?:-(\d{1,9}))?$", part, re.ASCII)
        if part and not found:
            raise ValueError('"{}" is no robot number and no range such as 1-3'.format(part))
        if part:
            low, high = int(found.group(1)), int(found.group(2) or found.group(1))
            if low > high:
                raise ValueError('"{}": wanted the smaller number first'.format(part))
            ranges.append((low, high))
    return tuple(ranges)


class Job:
    """A function that is computed in a thread."""

    def __init__(self, function, given):
        self.given, self.done, self._function = given, False, function
        self._value, self._error = None, None
        threading.Thread(target=self._work, daemon=True).start()

    def _work(self):
        try:
            self._value = self._function(self.given)
        except Exception as error:  # raised where the result is used
            self._error = error
        self.done = True

    def result(self):
        """Return what the function returned, or raise what it raised."""
        if self._error is not None:
            raise self._error
        return self._value


class ErrorCurve:
    """The formation error of a history that grows: each of its samples is computed once."""

    def __init__(self, function=None, background=False):
        """``function``: of poses (m, n, 3), gives (m,) [m]; in a thread with ``background``."""
        self._function, self._chunk = function, LARGEST_CHUNK if background else FIRST_CHUNK
        self._background = background
        self._forget()

    def _forget(self):
        self.values, self._mark, self._job = np.empty(0), None, None
        self.problem = "" if self._function else NO_ERROR

    def update(self, numbers, time, pose):
        """Go on with what is new, for ``PATIENCE``; return whether that was all."""
        if self._mark is not None and self._mark != self._signature(numbers, time, pose):
            self._forget()
        end = clock.monotonic() + PATIENCE
        while not self.problem and len(self.values) < len(time):
            begun = clock.monotonic()
            if begun > end:
                return False
            chunk = pose[len(self.values) : len(self.values) + self._chunk]
            if self._background:
                self._job = self._job or Job(self._function, chunk.copy())
                self._mark = self._signature(numbers, time, pose)
                if not self._job.done:
                    return False
                job, self._job = self._job, None
                self._compute(job.result, len(job.given))
                self._mark = self._signature(numbers, time, pose)
                continue
            self._compute(lambda poses=chunk: self._function(poses.copy()), len(chunk))
            taken = max(clock.monotonic() - begun, 1e-9)
            fitting = int(0.5 * PATIENCE / taken * self._chunk)
            self._chunk = min(max(1, fitting), LARGEST_CHUNK)
            self._mark = self._signature(numbers, time, pose)
        return True

    def _compute(self, function, count):
        try:
            new = function()
            if new is None:
                self.problem = NO_ERROR
                return
            new = np.asarray(new, dtype=float).reshape(count)
            self.values = np.concatenate([self.values, new])
        except Exception:  # the function is a user's code
            LOG.exception("in the formation error")
            self.problem = "The formation error failed: see the log"

    def _signature(self, numbers, time, pose):
        """Return a mark that changes once the history no longer begins with the samples computed.

        A full history drops every other sample, so its length is not enough.
        """
        last = len(self.values) - 1
        if last >= len(time):
            return None
        if last < 0:
            return numbers, time[:1].tobytes()
        return numbers, time[0], time[last], pose[last].tobytes()


def positive(values):
    """Return ``values`` with NaN in place of what has no logarithm."""
    return np.where(values > 0.0, values, np.nan)


def thinned(curve, begin, end, most):
    """Return time and values of ``curve`` from ``begin`` to ``end`` [s], at most ``most`` samples."""
    first = max(0, int(np.searchsorted(curve.time, begin)) - 1)
    last = int(np.searchsorted(curve.time, end, side="right")) + 1
    time, values = thin(curve.time[first:last], curve.values[first:last], most)
    # What does not fill a stretch stays whole in the first pass.
    return thin(time, values, most)


def thinned_together(time, table, begin, end, most):
    """Return times (p,) and values (p, n) of the curves ``table`` (m, n) from ``begin`` to ``end`` [s].

    Of about ``most`` samples; of each stretch of more the least and the greatest value are kept.
    """
    first = max(0, int(np.searchsorted(time, begin)) - 1)
    last = int(np.searchsorted(time, end, side="right")) + 1
    time, table = time[first:last], table[first:last]
    stretch = -(-2 * len(time) // most)
    if stretch <= 2:
        return time, table
    whole = len(time) // stretch * stretch
    parts = table[:whole].reshape(-1, stretch, table.shape[1])
    low, high = np.fmin.reduce(parts, axis=1), np.fmax.reduce(parts, axis=1)
    falls = parts.argmax(axis=1) < parts.argmin(axis=1)
    pairs = np.stack([np.where(falls, high, low), np.where(falls, low, high)], axis=1)
    ends = time[:whole].reshape(-1, stretch)[:, [0, -1]]
    values = pairs.reshape(-1, table.shape[1])
    return np.append(ends.ravel(), time[-1]), np.concatenate([values, table[-1:]])


def fitted(drawn, log):
    """Return the limits of a vertical axis that shows the ``drawn`` values."""
    values = np.concatenate([np.empty(0)] + [values[np.isfinite(values)] for values in drawn])
    if not len(values):
        return (1e-3, 1.0) if log else (-1.1, 1.1)
    low, high = np.min(values), np.max(values)
    if not log:
        room = 0.05 * (high - low) + max(0.0, LEAST_SPAN - (high - low)) / 2.0
        return low - room, high + room
    low, high = max(np.log10(low), np.log10(high) - MOST_DECADES), np.log10(high)
    room = 0.05 * (high - low) + max(0.0, 1.2 - (high - low)) / 2.0
    return 10.0 ** (low - room), 10.0 ** (high + room)


def foot(points, place):
    """Return the point nearest to ``place`` (2,) on the polyline ``points`` (p, 2); NaN: none."""
    if len(points) == 1:
        return points[0]
    begins, along = points[:-1], np.diff(points, axis=0)
    square = np.maximum(np.sum(along**2, axis=1), 1e-12)
    share = np.clip(np.sum((place - begins) * along, axis=1) / square, 0.0, 1.0)
    feet = begins + share[:, np.newaxis] * along
    distance = np.nan_to_num(np.linalg.norm(feet - place, axis=1), nan=np.inf)
    return feet[np.argmin(distance)] if len(feet) else np.full(2, np.nan)
