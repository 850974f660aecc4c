"""The runs of a search that have ended, in a file: the same command goes on after them."""

import contextlib
import fcntl
import json
import os

from mrs_simulator.core.writing import naming
from mrs_simulator.scenario.search import NO_SEARCH
from mrs_simulator.study.run.run_keys import forget, run_key
from mrs_simulator.study.run.workers import SweepError
from mrs_simulator.study.search.space import varied_scenario
from mrs_simulator.study.search.trials import Trial

FILE = "runs.jsonl"


class KeptRuns:
    """``runs.jsonl`` in a directory: a line that says of what search it is, then one for each run."""

    def __init__(self, out, search, report):
        """Take up the file in the directory ``out``, which is made, or begin it anew.

        ``search``: plain values by name, all that decides on runs; ``report(text)`` is called with what
        is taken up, or with what has changed.  Raises ``OSError`` where nothing can be written there, and
        ``SweepError`` where another search does that.
        """
        os.makedirs(out, exist_ok=True)
        self.path = os.path.join(out, FILE)
        self._lines = {}  # by what was run
        with naming(self.path):
            self._file = open(self.path, "ab", buffering=0)
            self._lock()
            with open(self.path, "rb") as file:
                whole = self._read(file, search, report)
            self._lock()  # again: closing the file that was read gives it back
            self._file.truncate(whole)  # a last line may be half written
            if not whole:
                self._write(search)

    def _lock(self):
        """Keep other searches from the file until this process ends; no process that it forks does."""
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            text = "{}: another search writes there; wanted a directory of its own"
            raise SweepError(text.format(self.path)) from None
        except OSError:  # a file system without locks
            return

    def _read(self, file, search, report):
        """Read the runs of the ``search`` from ``file``; return how many bytes of it are whole."""
        first = file.readline()
        was, whole = _mapping(first), len(first)
        if was != search:
            changed = [key for key, value in search.items() if was and was.get(key) != value]
            if changed:
                text = "{} is of another search ({} changed): it begins anew"
                report(text.format(self.path, ", ".join(changed)))
            return 0
        for line in file:
            run = _mapping(line)
            if run is None:
                break
            self._lines[_what(run["variation"], run["until"])] = line
            whole += len(line)
        if self._lines:
            report("goes on after {} runs that are in {}".format(len(self._lines), self.path))
        return whole

    def trial(self, variation, until):
        """Return the ``Trial`` of a ``variation`` that lasts ``until`` [s], None where none is kept."""
        line = self._lines.get(_what(variation, until))
        if line is None:
            return None
        run = json.loads(line)
        return Trial(*(run[name] for name in Trial._fields))

    def keep(self, variation, until, trial):
        """Write the ``trial`` of a ``variation`` to the file."""
        with naming(self.path):
            self._write({"variation": variation, "until": until, **trial._asdict()})

    def _write(self, content):
        rest = memoryview((json.dumps(content) + "\n").encode("utf-8"))
        while rest:  # at once: the process may be killed any time
            rest = rest[self._file.write(rest) :]


def search_of(content, path, search=NO_SEARCH, **more):
    """Return all that decides on runs of a ``search`` of a scenario's ``content``, plain values by name.

    ``path``: the scenario's file; ``more``: what else does.
    """
    varied = [{}] + [{each.key: choice} for each in search.ranges for choice in each.choices]
    keys = []
    forget()
    for variation in varied:  # choices may be files, of laws or maps
        with contextlib.suppress(ValueError):  # of a run that will be refused
            keys.append(run_key(varied_scenario(content, path, variation)))
    found = {"scenario, law or version": keys, "search": search.to_plain(), **more}
    return json.loads(json.dumps(found))  # as it is read back


def _mapping(line):
    """Return the mapping in a ``line`` of the file, None where that is not whole."""
    found = None
    if line.endswith(b"\n"):
        with contextlib.suppress(ValueError):
            found = json.loads(line)
    return found if isinstance(found, dict) else None


def _what(variation, until):
    return json.dumps([variation, until])
