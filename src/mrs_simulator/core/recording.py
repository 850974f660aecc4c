"""Recording a run to ``run.csv`` as it happens, with ``run.json`` at its end, and reading both back."""

import contextlib
import json
import math
import os
from array import array
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.kinematics import (
    DEFAULT_HAND_LENGTH,
    TWIST_AXES,
    UNICYCLE_AXES,
    hand_points,
)
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.core.reading import read_json, reason, refuse_special, shown
from mrs_simulator.core.scenario import MOST_ROBOTS, Scenario
from mrs_simulator.core.writing import Blocks, write_text

PLACE = ("time", "robot", "x", "y", "theta", "alpha_x", "alpha_y")
COLUMNS = PLACE + ("v", "omega")  # of a team of unicycles
BLOCK = 1 << 22  # [characters] of a file read at once
FACTS = {  # what ``run.json`` may hold of a run beside its collisions
    "ended": str,
    "warnings": list,
    "closest_approach": float,  # [m]
    "real_time_factor": float,
    "collisions_unknown": bool,
    "uncommanded": bool,
    "degraded": str,
    "deadlock": list,  # [number, since [s]] of robots that the safety filter held still at the end
    "lockstep": bool,  # commands follow from the poses of the same sample
}


class Collision(NamedTuple):
    """The begin of a contact: when [s], between whom, where [m] in the common frame."""

    time: float
    first: str
    second: str
    x: float
    y: float


class Run(NamedTuple):
    """A recorded run: m samples of n robots."""

    time: np.ndarray  # (m,) [s]
    robots: np.ndarray  # (n,) robots' numbers
    pose: np.ndarray  # (m, n, 3) [m, m, rad], common frame
    hand: np.ndarray  # (m, n, 2) [m], controlled points: hand points of unicycles
    command: np.ndarray  # (m, n, a) [m/s, rad/s], control input held after the sample
    collisions: List[Collision] = []
    scenario: Optional[Scenario] = None
    meta: Dict[str, Any] = {}
    axes: Tuple[str, ...] = UNICYCLE_AXES  # the columns of ``command``


class RunError(ValueError):
    """A recording that cannot be read: says which file, where and why."""


class Recorder:
    """Writes samples to ``run.csv`` at once, so that an interrupted run keeps what it has."""

    def __init__(
        self, path, robots, hand_length=DEFAULT_HAND_LENGTH, tell=None, axes=UNICYCLE_AXES
    ):
        """Open ``path`` for the robots numbered ``robots``; directories are made.

        ``axes``: the columns of commands; of a team of unicycles the file is one of the first version.
        What is told there of an earlier run is taken away.  ``tell`` is called with a text when
        samples find no room on the disk, and when they do again: a run goes on all the same.
        """
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        with contextlib.suppress(FileNotFoundError):
            os.remove(facts_path(path))
        self.path = path
        self._robots = [str(robot) for robot in robots]
        self._hand_length = hand_length
        self._file = Blocks(path, ",".join(columns_of(axes)) + "\n")
        self._tell = tell or (lambda text: None)
        self._stamp = 0.0  # [s] of the newest sample
        self._trouble, self._warnings = "", []

    def sample(self, stamp, pose, command, points=None):
        """Write one sample: ``stamp`` [s], ``pose`` (n, 3), ``command`` (n, a).

        ``points`` (n, 2) [m]: the controlled ones, by default hand points.  Numbers are written with the
        fewest digits that read back to the same value.
        """
        hand = hand_points(pose, self._hand_length) if points is None else points
        table = np.concatenate([pose, hand, command], axis=1).tolist()
        self._stamp = float(stamp)
        stamp = repr(self._stamp)
        lines = [
            ",".join([stamp, robot, *map(repr, row)]) for robot, row in zip(self._robots, table)
        ]
        self._file.add("\n".join(lines) + "\n")
        self._note()

    def _note(self):
        """Tell of a disk that has become full, or has room again."""
        now = self._file.trouble
        if bool(now) == bool(self._trouble):
            return
        self._trouble = now
        text = "at {:.3f} s samples are in the file again" if not now else "from {:.3f} s {}"
        text = "{}: {}".format(self.path, text.format(self._stamp, now))
        self._warnings.append(text)
        self._tell(text)

    def warnings(self):
        """Return what a reader of the run is to know of its file, a list of texts."""
        lost = self._file.lost
        return self._warnings + (["{}: {} samples lost".format(self.path, lost)] if lost else [])

    def close(self):
        """Finish the file; closing twice does no harm."""
        self._file.close()
        self._note()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def columns_of(axes):
    """Return the names of the columns of a file whose commands have these ``axes``."""
    return COLUMNS if tuple(axes) == UNICYCLE_AXES else PLACE + tuple(axes)


def facts_path(path):
    """Return the path of ``run.json`` beside the ``run.csv`` at ``path``."""
    return os.path.splitext(path)[0] + ".json"


def write_facts(path, collisions=(), meta=None):
    """Write ``run.json``, what is known of the run beside its samples, for the ``run.csv`` at ``path``.

    ``meta``: values by the names in ``FACTS``; a distance that is not finite is left out.
    """
    finite = {key: value for key, value in (meta or {}).items() if value != math.inf}
    facts = {**finite, "collisions": [list(collision) for collision in collisions]}
    write_text(facts_path(path), json.dumps(facts, indent=2, allow_nan=False) + "\n")


def _read_facts(path):
    """Return ``(collisions, meta)`` as :func:`write_facts` had them; collisions unknown if it had not."""
    told = facts_path(path)
    if not os.path.exists(told):
        return [], {"collisions_unknown": True}
    try:
        meta = read_json(told)
        collisions = [
            Collision(float(time), str(first), str(second), float(x), float(y))
            for time, first, second, x, y in meta.pop("collisions")
        ]
        if "deadlock" in meta:
            meta["deadlock"] = [(int(number), float(since)) for number, since in meta["deadlock"]]
        wrong = [key for key, value in meta.items() if not isinstance(value, FACTS[key])]
    except (OSError, ValueError, TypeError, AttributeError, KeyError, RecursionError) as error:
        raise RunError(
            "{}: not the facts of a run: {}: {}".format(told, type(error).__name__, error)
        ) from None
    if wrong:
        key = wrong[0]
        raise RunError(
            "{}: {} = {}, wanted a {}".format(told, key, shown(meta[key]), FACTS[key].__name__)
        )
    return collisions, meta


def read_run_csv(path, scenario=None):
    """Return the ``Run`` in the file at ``path``, with what ``run.json`` beside it tells.

    A last sample that was cut off is left out.  Raises ``RunError`` that names the file and line.
    """
    try:
        refuse_special(path)
        with open(path, encoding="ascii") as file:
            axes, table = _number_table(file, path)
    except (OSError, UnicodeDecodeError) as error:
        raise RunError("{}: cannot be read: {}".format(path, reason(error))) from None
    robots, samples = _shape_of(table, path)
    collisions, meta = _read_facts(path)
    table = table[: samples * len(robots)].reshape(samples, len(robots), -1)
    if np.any(table[:, :, 1] != robots) or np.any(table[:, :, 0] != table[:, :1, 0]):
        raise RunError("{}: wanted each time once for each of the robots, in order".format(path))
    return Run(
        time=table[:, 0, 0],
        robots=robots.astype(int),
        pose=table[:, :, 2:5],
        hand=table[:, :, 5:7],
        command=table[:, :, 7:],
        collisions=collisions,
        scenario=scenario,
        meta=meta,
        axes=axes,
    )


def _axes_in(header, path):
    """Return the axes of the commands in a file whose first line is ``header``."""
    names = header[:1000].rstrip("\n").split(",")
    axes = UNICYCLE_AXES if names == list(COLUMNS) else tuple(names[len(PLACE) :])
    known = axes and axes == tuple(axis for axis in TWIST_AXES if axis in axes)
    if not known or names != list(columns_of(axes)):
        raise RunError(
            "{}, line 1: {!r}, wanted the columns {}, or axes of a Twist instead of v and omega".format(
                path, header[:100].rstrip("\n"), ",".join(COLUMNS)
            )
        )
    return axes


def _number_table(file, path):
    """Return the axes of the commands, and all rows of ``file``, (m, 7 + axes).

    It is read in blocks: never is all of its text held at once.
    """
    axes = _axes_in(file.readline(), path)
    width = len(PLACE) + len(axes)
    numbers, begin = array("d"), 2
    for lines in iter(lambda: file.readlines(BLOCK), []):
        try:
            numbers.frombytes(_numbers(lines, width).tobytes())
        except ValueError:
            bad = next(index for index, line in enumerate(lines) if not _is_row(line, width))
            # The last line of a run that was killed may be half written.
            if bad < len(lines) - 1 or begin + bad == 2 or file.readline():
                raise RunError(
                    "{}, line {}: {}, wanted {} finite numbers".format(
                        path, begin + bad, lines[bad].rstrip("\n")[:60], width
                    )
                ) from None
            numbers.frombytes(_numbers(lines[:bad], width).tobytes() if bad else b"")
        begin += len(lines)
    return axes, np.frombuffer(numbers).reshape(-1, width)


def _numbers(lines, width):
    """Return the numbers in ``lines``, (width m,); ``ValueError`` if a line is another row."""
    if any(line.count(",") != width - 1 for line in lines):
        raise ValueError
    numbers = np.fromiter(map(float, ",".join(lines).split(",")), float)
    if not np.isfinite(numbers).all():
        raise ValueError
    return numbers


def _is_row(line, width):
    try:
        _numbers([line], width)
    except ValueError:
        return False
    return True


def _shape_of(table, path):
    if not len(table):
        raise RunError("{}: holds no sample".format(path))
    first = table[table[:, 0] == table[0, 0]]
    robots = first[:, 1]
    whole = (robots == np.round(robots)) & (robots >= 1) & (robots <= MOST_ROBOTS)
    if len(set(robots)) != len(robots) or not whole.all():
        raise RunError("{}: robots {}, wanted each number once".format(path, robots[:10]))
    return robots, len(table) // len(robots)


def closest_approach(pose):
    """Return the least distance [m] between two robots' centres over all samples; inf for one."""
    return min((least_distance(sample) for sample in pose[:, :, :2]), default=math.inf)
