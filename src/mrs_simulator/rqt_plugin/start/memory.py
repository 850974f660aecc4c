"""What the window remembers of scenarios for all its starts; without Qt and ROS."""

import contextlib
import hashlib
import os
import time

from mrs_simulator.core.writing import write_text
from mrs_simulator.rqt_plugin.run.user_settings import read_settings, user_directory, write_settings

FILE, EDITS = "start.json", "edits"
MOST_RECENT, MOST_EDITS, MOST_SAVED = 12, 20, 200  # [-] kept of each
USUAL = {"recent": [], "saved": [], "picker": True, "tour": True}


class StartMemory:
    """Recent scenarios, edits that were left unsaved, and what is shown at the start.

    It is one file of the user's data directory, shared by all windows; where that cannot be written
    nothing is remembered.
    """

    def __init__(self, home=None):
        """``home``: default ``mrs_simulator`` in the user's data directory."""
        self.home = home or user_directory()

    def kept(self):
        """Return what is kept, by the names of ``USUAL``; wrong parts are left out."""
        return read_settings(os.path.join(self.home, FILE), USUAL)

    def change(self, **changes):
        """Keep other values of some names."""
        with contextlib.suppress(OSError):
            write_settings(os.path.join(self.home, FILE), {**self.kept(), **changes})

    def recent(self):
        """Return the paths of recent scenarios that are there, the newest first."""
        return [path for path in self.kept()["recent"] if os.path.isfile(path)]

    def opened(self, path, text):
        """Remember the scenario file at ``path``, whose scenario is ``text`` as YAML."""
        kept, path = self.kept(), os.path.abspath(path)
        recent = [path, *(each for each in kept["recent"] if each != path)][:MOST_RECENT]
        saved = [_mark(text), *(each for each in kept["saved"] if each != _mark(text))]
        self.change(recent=recent, saved=saved[:MOST_SAVED])

    def is_saved(self, text):
        """Return whether the scenario ``text`` was read from a file, or written to one."""
        return _mark(text) in self.kept()["saved"]

    def keep_edits(self, text, title):
        """Write the edited scenario ``text`` to a file among the recent ones; return its path.

        The oldest of such files are removed.  Raises ``OSError``.
        """
        folder = os.path.join(self.home, EDITS)
        os.makedirs(folder, exist_ok=True)
        word = "".join(c if c.isalnum() else "_" for c in title.lower())[:40] or "scenario"
        stamp = time.strftime("%Y-%m-%d_%H%M%S")
        path = os.path.join(folder, "{}_{}.yaml".format(word, stamp))
        write_text(path, text)
        self.opened(path, text)
        files = sorted((os.path.join(folder, name) for name in os.listdir(folder)), key=_time)
        for old in files[:-MOST_EDITS]:
            with contextlib.suppress(OSError):
                os.remove(old)
        return path

    def is_edits(self, path):
        """Return whether ``path`` is a file of edits that were left unsaved."""
        return os.path.dirname(path) == os.path.join(self.home, EDITS)


def _mark(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _time(path):
    with contextlib.suppress(OSError):
        return os.path.getmtime(path)
    return 0.0
