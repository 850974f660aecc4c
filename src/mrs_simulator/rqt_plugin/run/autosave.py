"""Autosaves the edited scenario in a file until the GUI ends normally.  No Qt."""

import contextlib
import fcntl
import os
import tempfile
import time
from typing import NamedTuple

MOST_BYTES = 10000000  # [B] of what is offered again


class Orphan(NamedTuple):
    """Edits of a GUI that ended without keeping them."""

    path: str
    time: float  # [s] since 1970, of the last edit
    text: str  # of the scenario


class Autosave:
    """One file, locked while this GUI runs; unlocked files were left by a crash."""

    def __init__(self, directory=None):
        """``directory``: default ``mrs_simulator/edits`` in the user's cache."""
        cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
        self._directory = directory or os.path.join(cache, "mrs_simulator", "edits")
        self._file, self._text = None, ""  # what is in it

    def keep(self, text):
        """Write the scenario's ``text``; raises ``OSError`` where that cannot be."""
        if self._file is None:
            os.makedirs(self._directory, exist_ok=True)
            handle, path = tempfile.mkstemp(".yaml", "edits_", self._directory)
            fcntl.flock(handle, fcntl.LOCK_EX)
            self._file = os.fdopen(handle, "wb", buffering=0)
            self._path = path
        try:
            self._put(text)
        except OSError:
            with contextlib.suppress(OSError):
                self._put(self._text)  # for which there was room
            raise
        self._text = text

    def _put(self, text):
        content = memoryview(text.encode("utf-8"))
        os.ftruncate(self._file.fileno(), 0)
        self._file.seek(0)
        while content:
            content = content[self._file.write(content) :]

    def forget(self):
        """Remove the file: nothing is unsaved."""
        if self._file is not None:
            with contextlib.suppress(OSError):
                os.remove(self._path)
            self._file.close()
            self._file = None

    def orphans(self):
        """Return the ``Orphan`` of each GUI that has crashed, the newest first."""
        found = []
        with contextlib.suppress(OSError):
            for name in os.listdir(self._directory):
                with contextlib.suppress(OSError, UnicodeDecodeError):
                    found += self._orphan(os.path.join(self._directory, name))
        return sorted(found, key=lambda orphan: -orphan.time)

    @staticmethod
    def _orphan(path):
        with open(path, encoding="utf-8") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except OSError:
                return []  # its GUI lives
            text = file.read(MOST_BYTES)
        return [Orphan(path, os.path.getmtime(path), text)] if text else []

    @staticmethod
    def discard(orphan):
        """Remove what an ``orphan`` has left."""
        with contextlib.suppress(OSError):
            os.remove(orphan.path)


def time_of(orphan):
    """Return when the edits of ``orphan`` were made, for a message."""
    day = "%H:%M" if time.time() - orphan.time < 43200.0 else "%Y-%m-%d %H:%M"
    return time.strftime(day, time.localtime(orphan.time))
