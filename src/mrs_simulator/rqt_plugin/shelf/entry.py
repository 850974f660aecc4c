"""What the files of a run say of it, for a list of runs; without Qt and ROS."""

import contextlib
import os
import time
from typing import NamedTuple

from mrs_simulator.rqt_plugin.shelf.differences import flat
from mrs_simulator.scenario.reading import load_yaml
from mrs_simulator.study.results.report import RUN_FILE, SCENARIO_FILE, VERDICT_FILE
from mrs_simulator.verdict.verdict import outcome_of
from mrs_simulator.verdict.verdict_file import read_verdict

BAG = ".bag"
PAUSE = 0.003  # [s] after each run that was read, in which the window's thread goes on
READ = RUN_FILE, SCENARIO_FILE, VERDICT_FILE  # files that an entry depends on


class Marks(NamedTuple):
    """What the user has noted of a run."""

    name: str = ""
    note: str = ""
    pinned: bool = False


class Entry(NamedTuple):
    """One run of the list."""

    path: str  # of its folder, or of a bag
    title: str  # of its scenario, "" where it has none
    time: float  # [s] since 1970, when its data was written last
    protocol: str  # its name, or that of its file
    keys: dict  # of its scenario, flat
    outcome: str  # of its verdict, "" without one
    size: int  # [bytes]
    marks: Marks = Marks()

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


def run_at(path):
    """Return the absolute path of the run at ``path``, a folder, its ``run.csv`` or a bag.

    Raises ``ValueError`` where there is none.
    """
    path = os.path.abspath(path)
    if os.path.basename(path) == RUN_FILE:
        path = os.path.dirname(path)
    if not is_run(path):
        text = "{}: no run: wanted a folder with a {}, or a bag"
        raise ValueError(text.format(path, RUN_FILE))
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
    files = [path] if path.endswith(BAG) else [os.path.join(path, name) for name in READ]
    found = []
    for file in files:
        try:
            stat = os.stat(file)
            found.append((stat.st_mtime, stat.st_size))
        except OSError:
            found.append(None)
    return None if found[0] is None else tuple(found)


def _read(path):
    """Return the entry of the run at ``path``; of files that cannot be read nothing is known."""
    if path.endswith(BAG):
        return Entry(path, "", os.path.getmtime(path), "", {}, "", os.path.getsize(path))
    keys, outcome = {}, ""
    with contextlib.suppress(OSError, ValueError):
        content = load_yaml(os.path.join(path, SCENARIO_FILE))
        keys = flat(content) if isinstance(content, dict) else {}
    with contextlib.suppress(OSError, ValueError):
        outcome = outcome_of(read_verdict(os.path.join(path, VERDICT_FILE)))
    protocol = os.path.basename(str(keys.get("control.protocol", "")))
    title, when = str(keys.get("title", "")), os.path.getmtime(os.path.join(path, RUN_FILE))
    return Entry(path, title, when, protocol, keys, outcome, size_of(path))


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
