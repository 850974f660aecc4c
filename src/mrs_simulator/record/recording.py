"""Recording a run to ``run.csv`` as it happens, with ``run.json`` at its end, and reading both back."""

import contextlib
import functools
import json
import math
import mmap
import os
import sys
import tempfile
from array import array
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.cores import cores
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH, UNICYCLE_AXES, hand_points
from mrs_simulator.core.neighbours import least_distance_over
from mrs_simulator.core.sample_blocks import blocks, note_seen, release_of
from mrs_simulator.core.writing import Blocks, write_text
from mrs_simulator.record import MOST_KEPT
from mrs_simulator.record.beside import Beside
from mrs_simulator.record.kind_column import kind_fields, without_kinds
from mrs_simulator.record.number_rows import AT_ONCE, Lines
from mrs_simulator.record.run_changes import read_changes
from mrs_simulator.scenario.incidents import DESCRIPTIONS, Incident
from mrs_simulator.scenario.reading import read_json, reason, refuse_special, shown
from mrs_simulator.scenario.scenario import MOST_ROBOTS
from mrs_simulator.state.columns import COLUMNS, GROUPS, HAND, REAL
from mrs_simulator.state.layout import STAMPS, basic_layout, layout_in
from mrs_simulator.state.state_table import StateTable

BLOCK = 1 << 19  # [characters] of a file read at once: its numbers as text take ten times as much
FREE = 4  # [-] times as much room as that file takes is wanted on its disk
TOGETHER = 16000  # [-] rows that are written at once: of fewer, handing them over takes its time
BESIDE = 10000  # [-] rows from which on a thread writes: fewer take some ms
LONGEST_CAUSE = 200  # [characters] of an error that is quoted
FACTS = {  # what ``run.json`` may hold besides collisions
    "ended": str,
    "warnings": list,
    "closest_approach": float,  # [m]
    "real_time_factor": float,
    "collisions_unknown": bool,
    "real": list,  # numbers of the robots that are; absent where none is, or where it is not known
    "uncommanded": bool,
    "degraded": str,
    "deadlock": list,  # [number, since [s]] of robots that the safety filter held still at the end
    "incidents": list,  # ``Incident``s
    "requirements": list,  # what became of them, evaluated at every step of the world
    "truth_unknown": bool,  # poses are the control's estimates
    "scene_time": float,  # [s] at which the run began, of obstacles that had moved by then
    "changes": list,  # ``run_changes.Change``s of the controller's settings
    "unknown_law": str,  # the name of a law known from a topic alone
    "lockstep": bool,  # commands follow from the poses of the same sample
}


class Collision(NamedTuple):
    """The start of a contact: time [s], both bodies, place [m] in the common frame."""

    time: float
    first: str
    second: str
    x: float
    y: float
    z: float = 0.0

    @property
    def place(self):
        """Return ``(x, y)``, and z where it is not 0."""
        return (self.x, self.y, self.z) if self.z else (self.x, self.y)


class Run(StateTable):
    """A recorded run: m samples of n robots.

    Columns that were not recorded are None.

    time : (m,) [s].
    robots : (n,), their numbers.
    pose : (m, n, 3) [m, m, rad], common frame.
    hand : (m, n, d) [m], controlled points: hand points of unicycles; d = 2, or :meth:`in_space`.
    command : (m, n, a) [m/s, rad/s], control input held after the sample.
    collisions : a list of ``Collision``.
    scenario : the ``Scenario``, or None.
    meta : what else ``run.json`` has, by the names in ``FACTS``.
    axes : the columns of ``command``.
    kinds : names of the robots' kinds; () where unknown.
    twist : (m, n, 3) vx, vy [m/s], omega [rad/s], robots' frames.
    joints : (m, n) [rad] of the drives; (m, n, k) where robots have k.
    spatial : a ``Spatial`` (m, n, ...) of robots that leave the ground.
    point_z : (m, n) [m], height of the controlled points.
    load : a ``LoadState`` (m, ...), what the robots carry.
    estimate : (m, n, 3) [m, m, rad], poses that the control used.
    """

    def __init__(
        self,
        time,
        robots,
        pose,
        hand,
        command,
        collisions=(),
        scenario=None,
        meta=None,
        axes=UNICYCLE_AXES,
        kinds=(),
        **columns,
    ):
        """``columns``: others by their names, or those of groups."""
        columns = {"pose": pose, "hand": hand, "command": command, **columns}
        super().__init__(time, np.asarray(robots), kinds, axes, **columns)
        self.collisions, self.scenario = list(collisions), scenario
        self.meta = {} if meta is None else meta

    def __getattr__(self, name):
        if name in COLUMNS or name in GROUPS and not self.has(GROUPS[name]):
            return None
        return super().__getattr__(name)

    _replace = StateTable.replace

    @property
    def points(self):
        """Return the controlled points in space, (m, n, 3) [m]; on the ground without heights."""
        height = np.zeros(self.hand.shape[:2]) if self.point_z is None else self.point_z
        return np.concatenate([self.hand, height[:, :, np.newaxis]], axis=2)

    @property
    def are_real(self):
        """Return which robots are real, (m, n) bool; all where neither that nor collisions are known."""
        if self.has(REAL):
            return self.real
        found = self.meta.get("real")
        if found is None:
            found = self.robots if self.meta.get("collisions_unknown") else []
        return np.broadcast_to(np.isin(self.robots, found), self.pose.shape[:2])

    def in_space(self, dimension):
        """Return this run with ``hand`` of ``dimension`` coordinates, 3 with heights of the points."""
        if self.hand.shape[2] >= dimension:
            return self
        return self.replace(hand=self.points)


class RunError(ValueError):
    """A recording that cannot be read: the message names the file, the place and the cause."""

    page = "docs/scenarios.md#columns-of-runcsv"


class Kept:
    """The numbers of a recorder's first samples, in memory that forked processes share, or in a file."""

    def __init__(self, robots, layout, samples, memory=None, directory=None):
        """Keep ``samples`` of ``robots`` with ``layout``; beyond ``MOST_KEPT`` in a file, or not at all.

        ``memory``: an ``mmap`` of ``MOST_KEPT`` to keep them in, by default one of their own;
        ``directory``: where that file, which has no name, is made, by default nowhere.
        """
        self.given = list(robots), layout, samples
        shape = layout.width, samples, len(self.given[0])
        size = 8 * math.prod(shape)
        self._mapped = None
        if size > MOST_KEPT:
            self._mapped = memory = _mapped_file(size, directory)
            if memory is not None:
                release_of(memory)
        if size == 0 or size > MOST_KEPT and memory is None:
            self.table = np.empty((0, shape[2], shape[0]))
            return
        memory = mmap.mmap(-1, size) if memory is None else memory
        table = np.frombuffer(memory, count=size // 8).reshape(shape)
        self.table = np.moveaxis(table, 0, -1)  # (samples, n, numbers), column by column

    @property
    def is_shared(self):
        """Return whether the numbers are in the ``memory`` that was given."""
        return self._mapped is None

    def put(self, rows, numbers):
        """Keep ``numbers`` (m, n, width) of the samples ``rows``, a slice."""
        self.table[rows] = numbers
        note_seen(numbers[..., 0].size)

    def are_finite(self, samples):
        """Return whether all numbers of the first ``samples`` are."""
        rows = blocks(samples, self.table.shape[1])
        return all(np.isfinite(self.table[part]).all() for part in rows)

    def run(self, time, scenario, facts):
        """Return the ``Run`` of the first m samples, at ``time`` (m,) [s].

        ``facts``: its collisions and its ``meta``.
        """
        robots, layout, _ = self.given
        kinds = tuple(" ".join(kind.split()) for kind in layout.kinds)
        table = self.table[: len(time)]
        return _run_of(time, np.array(robots), table, layout, kinds, facts, scenario)


def _mapped_file(size, directory):
    """Return an ``mmap`` of ``size`` [bytes] of a new file in ``directory`` that goes with the process.

    None where the system has no such, or too little room: a full disk would end the process.
    """
    if directory is None or not hasattr(mmap, "MADV_DONTNEED"):
        return None
    disk = os.statvfs(directory)
    if disk.f_bavail * disk.f_frsize < FREE * size:
        return None
    with contextlib.suppress(OSError), tempfile.TemporaryFile(dir=directory) as file:
        os.posix_fallocate(file.fileno(), 0, size)
        return mmap.mmap(file.fileno(), size)
    return None


class Recorder:
    """Writes samples to ``run.csv`` at once, so that an interrupted run keeps what it has."""

    def __init__(
        self,
        path,
        robots,
        hand_length=DEFAULT_HAND_LENGTH,
        warn=None,
        layout=None,
        kept=0,
        memory=None,
    ):
        """Open ``path`` for the robots numbered ``robots``; directories are made.

        ``layout``: the ``Layout`` of the file, by default poses, points and commands of unicycles.
        ``kept``: of how many samples the numbers stay in memory, too, for :meth:`run`, or if these are more
        than ``MOST_KEPT`` in a file beside ``path``; ``memory``: where they are :class:`Kept`.
        ``run.json`` of an earlier run is removed.  ``warn`` is called with a text when the disk is full,
        and when it has room again: the run continues.
        """
        self.path = path
        layout = basic_layout() if layout is None else layout
        self._file = self._opened(path, layout)
        self._places = layout.places()
        self._hand = self._places.pop("hand")
        self._numbers, self._samples = list(robots), 0
        shape = len(self._numbers), layout.width
        self.kept = Kept(
            self._numbers, layout, kept, memory, os.path.dirname(os.path.abspath(path))
        )
        self._kept = self.kept.table
        self._times = np.empty(len(self._kept))
        # Waiting samples: text and hand points of several at once take half of the time.
        self._stamps, self._pointless = [], []  # the latter: whether to compute hand points
        self._waiting = np.empty((max(1, AT_ONCE // shape[0]), *shape))
        ends = ["," + field for field in kind_fields(layout.kinds)]
        self._lines = Lines(self._numbers, ends or [""] * len(self._numbers))
        self._arms = np.full(shape[0], float(hand_length))  # [m]
        self._warn = warn or (lambda text: None)
        self._stamp = 0.0  # [s] of the newest sample
        self._begun = self._written = 0  # [-] samples, of which the last may be interrupted
        self._trouble, self._warnings, self._told = "", [], 0
        self._is_together, self._beside = False, None  # the thread that writes

    @staticmethod
    def _opened(path, layout):
        """Return the new file for the columns of ``layout``."""
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        with contextlib.suppress(FileNotFoundError):
            os.remove(facts_path(path))
        return Blocks(path, ",".join(layout.names) + "\n")

    def sample(self, stamp, state):
        """Write one sample: the columns of the file at ``stamp`` [s] in ``state``, a ``StateTable``.

        Without ``hand`` in it the controlled points are hand points.  Numbers are written with the fewest
        digits that read back to the same.
        """
        rows = self._waiting[len(self._stamps)]
        for name, place in self._places.items():
            rows[:, place] = getattr(state, name)
        has_points = state.has(HAND)
        if has_points:
            rows[:, self._hand] = state.hand
        self._add([float(stamp)], not has_points)

    def block(self, stamps, poses, commands):
        """Write samples of unicycles at ``stamps`` (k,) [s], as :meth:`sample` does one after the other.

        ``poses`` (k, n, 3) and ``commands`` (k, n, 2).
        """
        at = 0
        while at < len(stamps):
            rows = self._waiting[len(self._stamps) :][: len(stamps) - at]
            part = slice(at, at + len(rows))
            rows[:, :, self._places["pose"]] = poses[part]
            rows[:, :, self._places["command"]] = commands[part]
            self._add(stamps[part], True)
            at = part.stop

    def write_together(self):
        """Write many samples at once from now on; where it pays, a thread writes while the run goes on.

        A sample may be in the file ``writing.FLUSH_PERIOD`` later than without.
        """
        most = max(1, TOGETHER // len(self._numbers))
        if len(self._waiting) < most:
            self._settle()
            self._waiting = np.empty((most, *self._waiting.shape[1:]))
        self._is_together = True

    def _pays_beside(self):
        """Return whether a thread is to write: what it does so, compiled loops do, beside Python."""
        rows = self._samples * len(self._numbers)
        return rows > BESIDE and self._lines.are_compiled and cores() > 1

    def _add(self, stamps, pointless):
        """Add those at ``stamps`` to the samples that wait, which are written when that is due or no more
        can wait; ``pointless`` ones get hand points."""
        self._stamp = stamps[-1]
        self._samples += len(stamps)
        self._stamps.extend(stamps)
        self._pointless.extend([pointless] * len(stamps))
        if self._file.is_due or len(self._stamps) == len(self._waiting):
            self._write_waiting()

    def _settle(self):
        """Write the samples that wait; wait until all are written."""
        if self._stamps:
            self._write_waiting()
        if self._beside is not None:
            self._beside.settle()
            self._tell()

    def _write_waiting(self):
        """Keep the waiting samples, and write them to the file as text."""
        stamps, begin = self._stamps, self._samples - len(self._stamps)
        given = begin, stamps, self._pointless, self._waiting[: len(stamps)]
        if self._beside is None and self._is_together and self._pays_beside():
            self._beside = Beside()
        if self._beside is None:
            self._write(*given)
        else:
            self._beside.ask(functools.partial(self._write, *given))
            self._waiting = np.empty_like(self._waiting)
        self._stamps, self._pointless = [], []  # where asking is interrupted, they wait on
        self._tell()

    def _write(self, begin, stamps, pointless, rows):
        """Keep and write the samples from ``begin`` on, ``rows`` (k, n, width), unless that has begun;
        ``pointless`` ones get hand points."""
        if begin < self._begun:
            return
        self._begun = begin + len(rows)
        filled = self._filled(stamps, pointless, rows)
        room = slice(begin, min(begin + len(rows), len(self._kept)))
        if begin < room.stop:
            kept = room.stop - begin
            self._times[room] = stamps[:kept]
            self.kept.put(room, rows[:kept])
        self._file_away(stamps, rows, filled)
        self._note(stamps[-1])
        self._written = self._begun

    def _filled(self, stamps, pointless, rows):
        """Put the hand points into the ``pointless`` of ``rows``; return what ``Lines.filled`` does."""
        places = self._places["pose"].start, self._hand.start
        filled = self._lines.filled(stamps, rows, (np.array(pointless), self._arms, *places))
        if filled is None:
            self._add_points(rows, pointless)
        return filled

    def _add_points(self, rows, pointless):
        """Put the hand points into the ``pointless`` of ``rows``."""
        if not any(pointless):
            return
        found = rows if all(pointless) else rows[pointless]
        found[:, :, self._hand] = hand_points(found[:, :, self._places["pose"]], self._arms)
        if found is not rows:
            rows[pointless] = found

    def _file_away(self, stamps, rows, filled):
        """Write ``rows`` to the file as text, which is ``filled`` already, or None."""
        if filled is None:
            self._file.add(*self._lines.texts(stamps, rows))
        else:
            self._file.extend(*filled)

    def _note(self, stamp):
        """Note at ``stamp`` [s] that the disk has become full, or has room again."""
        now = self._file.trouble
        if bool(now) == bool(self._trouble):
            return
        self._trouble = now
        text = "at {:.3f} s samples are in the file again" if not now else "from {:.3f} s {}"
        text = "{}: {}".format(self.path, text.format(stamp, now))
        self._warnings.append(text)

    def _tell(self):
        """Warn of what was noted, in the thread of whoever records."""
        while self._told < len(self._warnings):
            self._told += 1
            self._warn(self._warnings[self._told - 1])

    def flush(self):
        """Write all samples so far to the file, as far as its disk has room."""
        self._settle()
        self._file.flush()
        self._note(self._stamp)
        self._tell()

    def warnings(self):
        """Return warnings about the file, a list of texts."""
        lost = self._file.lost
        return self._warnings + (["{}: {} samples lost".format(self.path, lost)] if lost else [])

    def run(self, scenario=None):
        """Return the ``Run`` that :func:`read_run_csv` reads of the finished file, or raise what it does.

        Where all samples are in the file and were kept, the file is not read.
        """
        if not self.has_kept_all:
            return read_run_csv(self.path, scenario)
        return self.kept.run(self._times[: self._samples], scenario, _read_facts(self.path))

    @property
    def has_kept_all(self):
        """Return whether the numbers of all samples are in memory, and such as a reader takes."""
        self._settle()
        if self._file.lost or not 0 < self._samples <= min(self._written, len(self._kept)):
            return False
        return self.kept.are_finite(self._samples)

    def close(self):
        """Finish the file; closing twice does no harm."""
        try:
            self._settle()
        finally:
            if self._beside is not None:
                self._beside.close()
                self._beside = None
            self._file.close()
        self._note(self._stamp)
        self._tell()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class _NoFile:
    """Where an ``InMemory`` recorder writes."""

    is_due, trouble, lost = False, "", 0

    def flush(self):
        """There is nothing to write."""

    close = flush


class InMemory(Recorder):
    """Keeps the samples of a run as a ``Recorder`` does, and writes no file."""

    def __init__(self, robots, hand_length, layout, kept):
        """``kept``: how many samples there will be at most."""
        nowhere = os.path.join(tempfile.gettempdir(), "run.csv")
        super().__init__(nowhere, robots, hand_length, layout=layout, kept=kept)

    @staticmethod
    def _opened(path, layout):
        return _NoFile()

    def _filled(self, stamps, pointless, rows):
        self._add_points(rows, pointless)

    def _file_away(self, stamps, rows, filled):
        """Nothing is written."""

    def run_with(self, scenario, collisions, meta):
        """Return the ``Run`` with the facts that ``write_facts`` takes; ``RunError`` where that is none."""
        if not self.has_kept_all:
            raise RunError("the run: wanted finite numbers of at least one sample")
        _, facts = _facts_in(json.loads(facts_text((), meta)), "the run")
        return self.kept.run(self._times[: self._samples], scenario, (collisions, facts))


def facts_path(path):
    """Return the path of ``run.json`` beside the ``run.csv`` at ``path``."""
    return os.path.splitext(path)[0] + ".json"


def write_facts(path, collisions=(), meta=None):
    """Write ``run.json``, the facts of the run besides its samples, for the ``run.csv`` at ``path``.

    ``meta``: values by the names in ``FACTS``; a distance that is not finite is left out.
    """
    write_text(facts_path(path), facts_text(collisions, meta))


def begin_facts(path, real=(), **known):
    """Write to ``run.json`` what is known when a run begins, for a reader of one that is killed.

    ``real``: numbers of the robots that are; ``known``: other values by the names in ``FACTS``.
    """
    write_facts(path, meta={"real": list(real), "collisions_unknown": True, **known})


def facts_text(collisions=(), meta=None):
    """Return what :func:`write_facts` writes."""
    finite = {key: value for key, value in (meta or {}).items() if value != math.inf}
    rows = [c if c.z else c[:5] for c in collisions]  # as Collision.place, 100,000 times
    text = json.dumps({**finite, "collisions": []}, indent=2, allow_nan=False)
    return (text[: -len("[]\n}")] + _indented(rows) + "\n}" if rows else text) + "\n"


def _indented(rows):
    """Return ``rows`` (tuples of numbers and texts) as ``json.dumps`` indents them in ``facts_text``.

    With ``indent`` Python writes value by value, and there may be 100,000 rows.
    """
    between = ",\n      "
    text = json.dumps(rows, separators=(between, ": "), allow_nan=False)
    # no text holds a line's end: JSON escapes it
    text = text[2:-2].replace("]" + between + "[", "\n    ],\n    [\n      ")
    return "[\n    [\n      " + text + "\n    ]\n  ]"


def _read_facts(path):
    """Return ``(collisions, meta)`` as :func:`write_facts` wrote them; without a file unknown."""
    where = facts_path(path)
    if not os.path.exists(where):
        return [], {"collisions_unknown": True}
    try:
        meta = read_json(where)
    except (OSError, ValueError, RecursionError) as error:
        raise _no_facts(where, error) from None
    return _facts_in(meta, where)


def _facts_in(meta, where):
    """Return ``(collisions, meta)`` of the content ``meta`` of ``where``."""
    try:
        collisions = [
            Collision(float(time), str(first), str(second), float(x), float(y), *map(float, up))
            for time, first, second, x, y, *up in meta.pop("collisions")
        ]
        if "deadlock" in meta:
            meta["deadlock"] = [(int(number), float(since)) for number, since in meta["deadlock"]]
        if "incidents" in meta:
            meta["incidents"] = list(map(_incident, meta["incidents"]))
        if "changes" in meta:
            meta["changes"] = read_changes(meta["changes"])
        unknown = [key for key in meta if key not in FACTS]
        wrong = [key for key in meta if key in FACTS and not isinstance(meta[key], FACTS[key])]
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise _no_facts(where, error) from None
    if unknown:
        raise RunError(unknown_name(where, unknown[0], FACTS))
    if wrong:
        key = wrong[0]
        raise RunError(
            "{}: {} = {}, wanted a {}".format(where, key, shown(meta[key]), FACTS[key].__name__)
        )
    return collisions, meta


def _no_facts(where, error):
    text = "{}: not the facts of a run: {}: {}"
    return RunError(text.format(where, type(error).__name__, str(error)[:LONGEST_CAUSE]))


def _incident(row):
    time, robot, what, rotor, ordered = row
    if what not in DESCRIPTIONS:
        raise ValueError(
            "incident {}, wanted one of {}".format(shown(what), ", ".join(DESCRIPTIONS))
        )
    return Incident(float(time), str(robot), what, int(rotor), bool(ordered))


def read_run_csv(path, scenario=None):
    """Return the ``Run`` in the file at ``path``, with the facts in the ``run.json`` beside it.

    A last sample that was cut off is left out.  Raises ``RunError`` that names the file and line.
    """
    try:
        refuse_special(path)
        with open(path, encoding="utf-8") as file:
            layout, table, kinds = _read_table(file, path)
    except (OSError, UnicodeDecodeError) as error:
        raise RunError("{}: cannot be read: {}".format(path, reason(error))) from None
    robots, samples = _shape_of(table, path)
    n = len(robots)
    facts = _read_facts(path)
    table = table[: samples * n].reshape(samples, n, -1)
    if np.any(table[:, :, 1] != robots) or np.any(table[:, :, 0] != table[:, :1, 0]):
        raise RunError("{}: wanted each time once for each of the robots, in order".format(path))
    if kinds[: samples * n] != kinds[:n] * samples:
        raise RunError("{}: wanted one kind for each robot, the same at all times".format(path))
    time = table[:, 0, 0].copy()
    columnwise = np.moveaxis(table[:, :, len(STAMPS) :], -1, 0).copy()  # as a recorder keeps them
    table = np.moveaxis(columnwise, 0, -1)
    return _run_of(time, robots.astype(int), table, layout, tuple(kinds[:n]), facts, scenario)


def _run_of(time, robots, table, layout, kinds, facts, scenario):
    """Return the ``Run`` of ``table`` (m, n, numbers); ``facts``: its collisions and ``meta``."""
    collisions, meta = facts
    given = {"collisions": collisions, "scenario": scenario, "meta": meta, "kinds": kinds}
    return Run(time, robots, axes=layout.axes, **given, **layout.columns_of(table))


def _layout_in(header, path):
    """Return the ``Layout`` of a file whose first line is ``header``."""
    layout = layout_in(header[:1000].rstrip("\n").split(","))
    if layout is None:
        text = (
            "{}, line 1: {!r}, wanted the columns {}, or axes of a Twist instead of v and omega, and "
            "what else a team needs"
        )
        raise RunError(text.format(path, header[:100].rstrip("\n"), ",".join(basic_layout().names)))
    return layout


def _read_table(file, path):
    """Return the ``Layout`` of ``file``, the numbers of all rows (m, 2 + width), and the rows' kinds.

    The file is read in blocks, to save memory.
    """
    layout = _layout_in(file.readline(), path)
    width = len(STAMPS) + layout.width
    numbers, kinds, begin = array("d"), [], 2
    for lines in iter(lambda: file.readlines(BLOCK), []):
        if not lines[-1].endswith("\n"):
            del lines[-1]  # half written by a killed run
        try:
            found = _row_numbers(lines, width, layout.kinds)
        except ValueError:
            bad = next(
                index for index, line in enumerate(lines) if not _is_row(line, width, layout.kinds)
            )
            # The disk that holds the last line may have failed.
            if bad < len(lines) - 1 or begin + bad == 2 or file.readline():
                raise RunError(
                    "{}, line {}: {}, wanted {} finite numbers{}".format(
                        path,
                        begin + bad,
                        lines[bad].rstrip("\n")[:60],
                        width,
                        " and a kind" if layout.kinds else "",
                    )
                ) from None
            found = _row_numbers(lines[:bad], width, layout.kinds)
        numbers.frombytes(found[0].tobytes())
        kinds += map(sys.intern, found[1])
        begin += len(lines)
    return layout, np.frombuffer(numbers).reshape(-1, width), kinds


def _row_numbers(lines, width, has_kinds):
    """Return the numbers in ``lines``, (width m,), and the kinds, if there are any.

    ``ValueError`` if a line is another row.
    """
    kinds = []
    if has_kinds and lines:
        lines, kinds = without_kinds(lines)
    if not lines:
        return np.empty(0), kinds
    if any(line.count(",") != width - 1 for line in lines):
        raise ValueError
    numbers = np.fromiter(map(float, ",".join(lines).split(",")), float)
    if not np.isfinite(numbers).all():
        raise ValueError
    return numbers, kinds


def _is_row(line, width, has_kinds):
    try:
        _row_numbers([line], width, has_kinds)
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


def closest_approach(pose, z=None):
    """Return the least distance [m] between two robots' centres over all samples; inf for one.

    ``pose`` (m, n, 3); ``z`` (m, n) [m]: their heights, None on the ground.
    """
    places = pose[:, :, :2]
    if z is not None:
        places = np.dstack([places, z])
    return least_distance_over(places)


def part_of(run, rows):
    """Return the ``rows``, a slice, of ``run``."""
    return run.at(rows)
