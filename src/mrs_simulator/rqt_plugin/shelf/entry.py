"""What the files of a run say of it, for a list of runs; without Qt and ROS."""

import contextlib
import os
import time
from typing import Any, NamedTuple

from mrs_simulator.rqt_plugin.shelf.differences import flat
from mrs_simulator.scenario.reading import load_yaml
from mrs_simulator.study.results.report import RUN_FILE, SCENARIO_FILE, VERDICT_FILE
from mrs_simulator.study.run.sweep import TABLE
from mrs_simulator.study.run.sweep_plan import PLAN, is_sweep, read_table, swept, values_of
from mrs_simulator.verdict.verdict import PASSED, outcome_of
from mrs_simulator.verdict.verdict_file import read_verdict

BAG = ".bag"
PAUSE = 0.003  # [s] after each run that was read, in which the window's thread goes on
READ = RUN_FILE, SCENARIO_FILE, VERDICT_FILE  # files that an entry depends on
READ_OF_SWEEP = TABLE, PLAN
NO_RUN = "{}: no run: wanted a folder with a {}, or a bag, or the folder of a sweep"


class Marks(NamedTuple):
    """What the user has noted of a run."""

    name: str = ""
    note: str = ""
    pinned: bool = False


class Swept(NamedTuple):
    """What a list says of a sweep."""

    keys: tuple  # that vary, by their last names
    runs: int  # [-] that have ended
    passed: int


class Entry(NamedTuple):
    """One run of the list, or a sweep."""

    path: str  # of its folder, or of a bag
    title: str  # of its scenario, "" where it has none; of a run of a sweep what varies
    time: float  # [s] since 1970, when its data was written last
    protocol: str  # its name, or that of its file
    keys: dict  # of its scenario, flat
    outcome: str  # of its verdict, "" without one
    size: int  # [bytes]
    marks: Marks = Marks()
    sweep: Any = None  # ``Swept``, of a sweep
    within: str = ""  # the path of the sweep whose run it is
    origin: tuple = ()  # name and time [s] of the run as which it begins, of one kept by What if

    @property
    def name(self):
        """Return by which name the list shows the run."""
        return self.marks.name or self.title or os.path.basename(self.path)

    @property
    def data(self):
        """Return the path of the file with its samples."""
        return data_of(self.path)


def data_of(path):
    """Return the path of the file with the samples of the run at ``path``."""
    return path if path.endswith(BAG) else os.path.join(path, RUN_FILE)


def is_run(path):
    """Return whether at ``path`` there is a run: a folder with a ``run.csv``, or a bag."""
    return os.path.isfile(data_of(path))


def is_listed(path):
    """Return whether at ``path`` there is what the list shows: a run, or a sweep."""
    return is_run(path) or is_sweep(path)


def runs_of(sweep):
    """Return ``{path: name}`` of the runs of the sweep at a path, in its order; {} where it cannot be read.

    Names say what varies.
    """
    with contextlib.suppress(OSError, ValueError, KeyError):
        rows = read_table(sweep)
        found = {os.path.join(sweep, row["run"]): row for row in rows}
        return {path: _varied(row, swept(rows)) for path, row in found.items() if is_run(path)}
    return {}


def _varied(row, keys):
    values = values_of(row, keys).items()
    texts = ("{:.4g}".format(v) if isinstance(v, float) else str(v) for _, v in values)
    return ", ".join("{} {}".format(last_name(key), text) for key, text in zip(keys, texts))


def last_name(key):
    """Return the last part of the path of a ``key``."""
    return key.rpartition(".")[2]


def run_at(path):
    """Return the absolute path of the run at ``path``, a folder, its ``run.csv`` or a bag, or of a sweep.

    Raises ``ValueError`` where there is none.
    """
    path = os.path.abspath(path)
    if os.path.basename(path) == RUN_FILE:
        path = os.path.dirname(path)
    if not is_listed(path):
        raise ValueError(NO_RUN.format(path, RUN_FILE))
    return path


class Entries:
    """Reads entries, each anew only once its files have changed."""

    def __init__(self):
        self._known = {}

    def of(self, paths):
        """Return the ``Entry`` of each of ``paths`` that is a run, without marks."""
        known, self._known = self._known, {}
        for path in paths:
            signature = _signature(path)
            if signature is None:
                continue
            before, entry = known.get(path, (None, None))
            if before != signature:
                entry = _read(path)
                time.sleep(PAUSE)
            self._known[path] = signature, entry
        return [entry for _, entry in self._known.values()]


def _signature(path):
    """Return what changes with the files of the run at ``path``; None where there is none."""
    names = READ_OF_SWEEP if is_sweep(path) and not is_run(path) else READ
    files = [path] if path.endswith(BAG) else [os.path.join(path, name) for name in names]
    found = []
    for file in files:
        try:
            stat = os.stat(file)
            found.append((stat.st_mtime, stat.st_size))
        except OSError:
            found.append(None)
    return None if found[0] is None and names is READ else tuple(found)


def _read(path):
    """Return the entry of the run at ``path``; of files that cannot be read nothing is known."""
    if path.endswith(BAG):
        return Entry(path, "", os.path.getmtime(path), "", {}, "", os.path.getsize(path))
    if not is_run(path):
        return _read_sweep(path)
    keys, outcome = _keys_in(path), ""
    with contextlib.suppress(OSError, ValueError):
        outcome = outcome_of(read_verdict(os.path.join(path, VERDICT_FILE)))
    when = os.path.getmtime(os.path.join(path, RUN_FILE))
    return Entry(path, *_about(keys, when), keys, outcome, size_of(path))


def _read_sweep(path):
    """Return the entry of the sweep at ``path``."""
    rows, when = [], os.path.getmtime(path)
    with contextlib.suppress(OSError, ValueError):
        rows = [row for row in read_table(path) if {"run", "outcome"} <= set(row)]
    for name in filter(os.path.exists, (os.path.join(path, each) for each in READ_OF_SWEEP)):
        when = os.path.getmtime(name)
        break
    keys = _keys_in(path) or (_keys_in(os.path.join(path, rows[0]["run"])) if rows else {})
    names = tuple(last_name(key) for key in (swept(rows) if rows else ()))
    passed = sum(row["outcome"] == PASSED for row in rows)
    found = Entry(path, *_about(keys, when), {}, "", size_of(path))
    return found._replace(sweep=Swept(names, len(rows), passed))


def _keys_in(path):
    """Return the keys of the scenario in the folder ``path``, flat; {} of one that cannot be read."""
    with contextlib.suppress(OSError, ValueError):
        content = load_yaml(os.path.join(path, SCENARIO_FILE))
        return flat(content) if isinstance(content, dict) else {}
    return {}


def _about(keys, when):
    """Return title, time and protocol of an ``Entry``, of a scenario's ``keys``."""
    protocol = os.path.basename(str(keys.get("control.protocol", "")))
    return str(keys.get("title", "")), when, protocol


def size_of(path):
    """Return the size [bytes] of a folder's files, or of one file."""
    if os.path.isfile(path):
        return os.path.getsize(path)
    total = 0
    for above, _, names in os.walk(path):
        for name in names:
            try:
                total += os.lstat(os.path.join(above, name)).st_size
            except OSError:  # it went meanwhile
                continue
    return total
