"""Lays the runs ticked on the list over the run shown: curves, ghosts on the map, and tables."""

import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.pictures.scene import Scene
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.rqt_plugin.map.ghosts import Ghost
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.style import MapStyle
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.loaded_run import load_run
from mrs_simulator.rqt_plugin.shelf.comparison import ComparedRun, told_apart
from mrs_simulator.rqt_plugin.shelf.differences import flat
from mrs_simulator.rqt_plugin.shelf.entry import data_of
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.window.opened_run import source_of
from mrs_simulator.scenario.reading import parse_yaml
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.vehicles import Team, kind

MOST_POINTS = 400  # [-] of a ghost's trail
OWN = "This run"


class Shown(NamedTuple):
    """What a comparison depends on; parts are compared by identity."""

    runs: tuple  # ``LoadedRun``s that are laid over
    scenario: Any  # of the run shown
    verdict: Any
    opened: Any  # the run shown where it was opened

    def is_as(self, other):
        """Return whether ``other`` is of the same runs, as they were."""
        pairs = zip((*self.runs, *self[1:]), (*other.runs, *other[1:]))
        return len(self.runs) == len(other.runs) and all(one is two for one, two in pairs)


@guarded
class Comparison:
    """The runs laid over the run shown, which is the window's own or one that was opened."""

    def __init__(self, panels, study, history, replay, opened, results):
        self._panels, self._study, self._history = panels, study, history
        self._replay, self._opened, self._results = replay, opened, results
        self._paths, self._loaded = [], {}
        self._worker, self._rows = DebouncedWorker(0.0), None
        self._shown = Shown((), None, None, None)
        self._sources, self._kinds, self._own_name = [], [], ""
        panels.shelf.list.compared_changed.connect(self._on_compared)

    def _on_compared(self, paths):
        self._paths = list(paths)
        self._loaded = {path: run for path, run in self._loaded.items() if path in paths}
        missing, ask = [p for p in paths if p not in self._loaded], self._study.edited.ask_apart
        if missing:
            self._worker.ask(lambda: _loaded(missing, ask))
            panels = self._panels
            if panels.results_tabs.currentWidget() is not panels.comparison:
                panels.results_tabs.setCurrentWidget(panels.curves)

    def follow(self):
        """Take in runs that were read, and compare anew what has changed."""
        found = self._worker.take()
        for path, run, error in found[0] if found is not None else ():
            if error is not None:
                text = "not compared: {}: {}".format(path, reason(error))
                self._panels.say(ErrorMessage(text))
            elif path in self._paths:
                self._loaded[path] = run
        shown = self._now()
        if not shown.is_as(self._shown):
            self._shown = shown
            self._compare()

    def named(self):
        """Return ``(name, path)`` of the run shown and of those laid over it, [] where none is."""
        names = [self._own_name, *(source.name for source in self._sources)]
        paths = ["", *(run.path for run in self._shown.runs)]
        return list(zip(names, paths)) if self._sources else []

    def _now(self):
        """Return what a comparison would be of now."""
        opened = self._opened.run
        base = self._opened.path or self._results.of_run()
        runs = [self._loaded[path] for path in self._paths if path in self._loaded and path != base]
        if not runs:
            return Shown((), None, None, None)
        scenario = self._history.scenario or self._study.scenario
        scenario = scenario if opened is None else opened.scenario
        return Shown(tuple(runs), scenario, self._panels.verdict.verdict, opened)

    def _compare(self):
        panels, shown = self._panels, self._shown
        entries = {entry.path: entry.name for entry in panels.shelf.list.runs.entries}
        base = self._opened.path or self._results.of_run()
        title = getattr(shown.scenario, "title", "")
        own = entries.get(base) or title or OWN
        compared = [ComparedRun(own, _keys(shown.scenario), shown.verdict)]
        for run in shown.runs:
            compared.append(
                ComparedRun(entries.get(run.path, run.path), _keys(run.scenario), run.verdict)
            )
        compared = told_apart(compared) if shown.runs else []
        names = [each.name for each in compared]
        self._sources = [source_of(run, name) for run, name in zip(shown.runs, names[1:])]
        self._kinds = [_kinds(run) for run in shown.runs]
        self._rows = None
        self._own_name = names[0] if names else ""
        panels.curves.compare(self._sources, self._own_name)
        panels.comparison.compare(compared)
        self.show_frame()
        if panels.map.untouched:
            panels.map.fit()

    # The map -------------------------------------------------------------------------------------

    def show_frame(self):
        """Show the runs at the moment since their begin that is shown of the other."""
        passed = self._passed()
        rows = [_row(source.history.time, source.begin + passed) for source in self._sources]
        if rows != self._rows:
            self._rows = rows
            given = zip(range(1, 1 + len(rows)), self._sources, self._kinds, rows)
            ghosts = [self._ghost(*each) for each in given]
            self._panels.map.show_ghosts(ghosts, self._own_name)

    def _passed(self):
        """Return the time [s] since the run that is shown began, inf where there is none."""
        source = self._panels.curves.source
        time, cursor = source.history.time, self._replay.cursor
        if not len(time):
            return math.inf
        return max(0.0, (cursor.time if cursor.is_past else float(time[-1])) - source.begin)

    def _ghost(self, place, source, kinds, row):
        history = source.history
        state = history.state.at(row)
        state = state.replace(fresh=np.ones(len(state.robots), dtype=bool))
        style = MapStyle.of(self._panels.map, max(state.robots, default=1))
        scene = Scene(kinds, state, style.shades_of(state.robots, state.fresh))
        rows = np.unique(np.linspace(0, row, min(MOST_POINTS, row + 1)).astype(int))
        places = np.moveaxis(history.pose[rows, :, :2], 1, 0)
        trails = tuple(trail[np.isfinite(trail).all(axis=1)] for trail in places)
        return Ghost(source.name, place, scene, Shapes.of_kinds(kinds), trails)

    def end(self):
        """End the thread."""
        self._worker.ask(None)


def _loaded(paths, ask):
    """Return ``(path, run, error)`` of the runs at ``paths``, one of the latter two None; in a thread."""
    result = []
    for path in paths:
        try:
            result.append((path, load_run(path, data_of(path), ask), None))
        except (OSError, ValueError) as error:
            result.append((path, None, error))
    return result


def _keys(scenario):
    """Return the flat keys of a ``Scenario``, {} of None."""
    if scenario is None:
        return {}
    return flat(parse_yaml(from_anywhere(scenario).to_yaml(), "scenario"))


def _kinds(run):
    """Return the ``Kind``s of the robots of a ``LoadedRun``."""
    if run.scenario is None:
        return (kind(DEFAULT_KIND),) * len(run.history.numbers)
    return tuple(Team.from_scenario(run.scenario).kinds)


def _row(time, moment):
    """Return the row of the sample of ``moment`` [s], the first or the last one beyond the run."""
    return max(0, int(np.searchsorted(time, moment + 1e-9, side="right")) - 1)
