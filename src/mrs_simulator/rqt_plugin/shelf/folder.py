"""The user's folder of runs: bounded, marked, with undo of deletions; without Qt and ROS."""

import os
import re
import shutil
import time

from mrs_simulator.rqt_plugin.run.user_settings import read_settings, user_directory, write_settings
from mrs_simulator.rqt_plugin.shelf.entry import (
    BAG,
    Entries,
    Marks,
    is_listed,
    run_at,
    runs_of,
    size_of,
)

MOST_BYTES = 2 * 10**9  # [bytes] of all runs in the folder, unless the user wants others
OWN = "mrs_simulator_runs"  # the folder's name below one that the user has chosen
DELETED = ".deleted"  # the folder of runs that can be brought back
SETTINGS = "shelf.json"
SAVED = "mrs_runs"  # the folder that is suggested for results, and where `record` writes
MOST_SWEPT = 500  # [-] runs listed of sweeps that are unfolded
MOST_WATCHED = 500  # [-] runs listed of a folder that is watched
KEPT_DELETED = 86400.0  # [s] that a deleted run stays after a GUI that did not end in order


class Shelf:
    """Runs in a folder of the user's, those in folders that are watched, and single ones elsewhere.

    Marks and settings are in one file of the user's data directory, so that all windows share them, and
    nothing is written to folders of others.  Every method may be called from any thread.
    """

    def __init__(self, home=None):
        """``home``: default ``mrs_simulator`` in the user's data directory."""
        self.home = home or user_directory()
        self._entries = Entries()

    # Settings ------------------------------------------------------------------------------------

    def settings(self):
        """Return the settings: folder, most_bytes, watched, others, marks, origins and copies.

        Wrong ones are left out.
        """
        usual = {
            "folder": os.path.join(self.home, "runs"),
            "most_bytes": MOST_BYTES,
            "watched": [os.path.join(os.path.expanduser("~"), SAVED)],
            "others": [],
            "marks": {},
            "origins": {},
            "copies": {},
        }
        return read_settings(os.path.join(self.home, SETTINGS), usual)

    def change(self, **settings):
        """Keep other ``settings``; raises ``OSError`` where they cannot be written."""
        write_settings(os.path.join(self.home, SETTINGS), {**self.settings(), **settings})

    @property
    def folder(self):
        """Return the path of the folder."""
        return self.settings()["folder"]

    def keep_in(self, place):
        """Keep runs below the directory ``place``, in a folder of their own.

        What else is there is the user's: it is neither listed nor removed to make room.  The folder before
        is watched from now on, if it has runs.
        """
        place, settings = os.path.abspath(place), self.settings()
        own = place if os.path.basename(place) == OWN else os.path.join(place, OWN)
        watched, before = [each for each in settings["watched"] if each != own], settings["folder"]
        if before not in (own, *watched) and runs_in(before):
            watched.append(before)
        self.change(folder=own, watched=watched)

    def holds(self, path):
        """Return whether the run at ``path`` is in the folder."""
        return os.path.dirname(os.path.abspath(path)) == os.path.abspath(self.folder)

    def own(self, entries):
        """Return those ``Entry``s that are in the folder."""
        folder = os.path.abspath(self.folder)
        return [entry for entry in entries if os.path.dirname(entry.path) == folder]

    # What is there -------------------------------------------------------------------------------

    def scan(self, unfolded=()):
        """Return the ``Entry`` of each run and sweep, the newest first.

        Runs of sweeps whose paths are ``unfolded`` follow these.
        """
        settings = self.settings()
        paths = runs_in(settings["folder"])
        for folder in settings["watched"]:
            paths += runs_in(folder)[:MOST_WATCHED]
        paths += [path for path in settings["others"] if is_listed(path)]
        copies, listed = settings["copies"], set(paths)
        paths = [path for path in paths if copies.get(path) not in listed]
        within = {path: runs_of(path) for path in paths if path in unfolded}
        swept = [run for runs in within.values() for run in runs][:MOST_SWEPT]
        entries = {each.path: each for each in self._entries.of(dict.fromkeys([*paths, *swept]))}
        for path, entry in entries.items():
            origin = _origin(settings["origins"].get(path))
            marks = _marks(settings["marks"].get(path))
            entries[path] = entry._replace(marks=marks, origin=origin)
        own = [entries[path] for path in dict.fromkeys(paths) if path in entries]
        listed = []
        for entry in sorted(own, key=lambda entry: -entry.time):
            listed.append(entry)
            for run, name in within.get(entry.path, {}).items():
                if run in entries:
                    listed.append(entries[run]._replace(within=entry.path, title=name))
        return listed

    def add(self, path):
        """Add a run, or watch a folder of runs, at ``path``; return the path of the run, None of a folder.

        Raises ``ValueError`` where there is neither, and ``OSError`` where that cannot be kept.
        """
        path = os.path.abspath(path)
        if os.path.isdir(path) and not is_listed(path):
            self._append("watched", path)
            return None
        path = run_at(path)
        if path in self.settings()["copies"]:
            self.note_copy(path, None)
        if not self.holds(path) and not self._is_watched(path):
            self._append("others", path)
        return path

    def _is_watched(self, path):
        return os.path.dirname(path) in self.settings()["watched"]

    def _append(self, name, path):
        paths = self.settings()[name]
        if path not in paths:
            self.change(**{name: [*paths, path]})

    def mark(self, path, **marks):
        """Keep other ``marks`` of the run at ``path``, by the names of ``Marks``."""
        kept = self.settings()["marks"]
        changed = _marks(kept.get(path))._replace(**marks)
        others = {other: value for other, value in kept.items() if other != path}
        own = {path: changed._asdict()} if changed != Marks() else {}
        self.change(marks={**others, **own})

    def note_origin(self, path, name, when):
        """Keep of the run at ``path`` that it goes on otherwise than the run ``name`` of ``when`` [s].

        The time is since 1970, 0 where it is not known.
        """
        self.change(origins={**self.settings()["origins"], path: [name, when]})

    def note_copy(self, path, original):
        """Keep that the run at ``path`` is a copy of that at ``original``, beside which it is not listed.

        None: it is listed from now on.
        """
        copies = {copy: of for copy, of in self.settings()["copies"].items() if copy != path}
        self.change(copies={**copies, path: original} if original else copies)

    # Coming and going ----------------------------------------------------------------------------

    def new_directory(self, title):
        """Return the path of a new run called ``title``, which is not made."""
        title = re.sub(r"[^a-z0-9]+", "_", (title or "run").lower()).strip("_")[:40]
        wanted = "{}_{}".format(title, time.strftime("%Y%m%d_%H%M%S"))
        path, count = os.path.join(self.folder, wanted), 2
        while os.path.exists(path):  # a fast run may take less than a second
            path, count = os.path.join(self.folder, "{}_{}".format(wanted, count)), count + 1
        return path

    def delete(self, path):
        """Take the run at ``path`` away; return what ``restore`` brings back.

        One in the folder is deleted once the GUI ends; the files of others stay.
        """
        settings, path = self.settings(), os.path.abspath(path)
        if not self.holds(path):
            if self._is_watched(path):
                text = "{}: its folder is watched: delete the run there, or watch it no longer"
                raise ValueError(text.format(path))
            if path not in settings["others"]:
                raise ValueError("{}: the run belongs to a sweep".format(path))
            self.change(others=[other for other in settings["others"] if other != path])
            return path, None
        bin_ = os.path.join(settings["folder"], DELETED)
        os.makedirs(bin_, exist_ok=True)
        target = os.path.join(bin_, "{}.{}".format(os.path.basename(path), time.time_ns()))
        os.rename(path, target)
        os.utime(target)  # since when it is there
        return path, target

    def restore(self, deleted):
        """Bring back what ``delete`` has returned; return its path."""
        path, target = deleted
        if target is None:
            self._append("others", path)
            return path
        if os.path.exists(path):
            raise ValueError("{}: there is another run by now".format(path))
        os.rename(target, path)
        return path

    def empty(self, deleted):
        """Remove for ever what ``delete`` has returned, a list, and what was left by a crash."""
        bin_ = os.path.join(self.folder, DELETED)
        gone = [target for _, target in deleted if target is not None]
        with_age = [each.path for each in _entries_in(bin_) if _age(each) > KEPT_DELETED]
        for path in {*gone, *with_age}:
            _remove(path)

    def make_room(self, kept=()):
        """Remove the oldest runs that are not pinned, nor among ``kept``, until the rest fits.

        Return their names.  What was deleted goes first.
        """
        settings = self.settings()
        runs = [(size_of(path), path) for path in runs_in(settings["folder"])]
        bin_ = os.path.join(settings["folder"], DELETED)
        most, left = settings["most_bytes"], sum(size for size, _ in runs) + size_of(bin_)
        if left > most:
            left -= size_of(bin_)
            _remove(bin_)
        gone = []
        stay = {os.path.abspath(path) for path in kept}
        for size, path in sorted(runs, key=lambda run: os.path.getmtime(run[1])):
            if left <= most:
                break
            if path in stay or _marks(settings["marks"].get(path)).pinned:
                continue
            _remove(path)
            left -= size
            gone.append(path)
        if gone:
            marks = {path: value for path, value in settings["marks"].items() if path not in gone}
            self.change(marks=marks)
        return [os.path.basename(path) for path in gone]


def runs_in(folder):
    """Return the paths of runs and sweeps in ``folder``, the newest first; [] where it cannot be read."""
    found = [each for each in _entries_in(folder) if not each.name.startswith(".")]
    runs = [
        each
        for each in found
        if is_listed(each.path) and (each.is_dir() or each.name.endswith(BAG))
    ]
    return [os.path.abspath(each.path) for each in sorted(runs, key=_age)]


def _entries_in(folder):
    try:
        return list(os.scandir(folder))
    except OSError:
        return []


def _age(each):
    """Return how long [s] ago a directory's entry was changed; it may have gone meanwhile."""
    try:
        return time.time() - each.stat().st_mtime
    except OSError:
        return 0.0


def _marks(kept):
    """Return the ``Marks`` that a file holds; what is no such is left out."""
    kept = kept if isinstance(kept, dict) else {}
    kinds = {name: type(value) for name, value in Marks()._asdict().items()}
    return Marks(**{k: kept[k] for k, kind in kinds.items() if isinstance(kept.get(k), kind)})


def _origin(kept):
    """Return the name and the time [s] that a file holds of another run; () of what is no such."""
    is_one = isinstance(kept, list) and list(map(type, kept)) in ([str, float], [str, int])
    return tuple(kept) if is_one else ()


def _remove(path):
    if os.path.islink(path) or os.path.isfile(path):
        os.remove(path)
    else:
        shutil.rmtree(path, ignore_errors=True)
