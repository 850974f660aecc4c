"""Asks how the claims of a run stand while it goes on, and for the verdict when it is over; without Qt."""

import math
import shutil
import tempfile
import time
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.state.columns import JOINTS, OUT_OF_PLANE, TWIST
from mrs_simulator.study.run.run_so_far import SoFar

PERIOD = 0.5  # [s] of wall time between two looks at a run
MOST_SAMPLES, MOST_NUMBERS = 600, 200000  # [-] of a run that are looked at
FEWEST_SAMPLES = 20


class Said(NamedTuple):
    """An answer on a run: how claims stand at ``time`` [s] since it began, or its verdict, or an error."""

    time: float
    standings: Any = None
    verdict: Any = None
    error: Any = None


class RunJudge:
    """Asks about the run in ``history`` in the background, one question at a time."""

    def __init__(self, study, history):
        self._study, self._history = study, history
        self._worker, self._asked_at = DebouncedWorker(0.0), -math.inf
        self._of, self._waits = None, None  # what was asked: (cleared, newest time, whether over)
        self._judged = None  # (cleared, [s]) up to where there is a verdict

    def follow(self, ran):
        """Ask, if it is time; ``ran``: the run's ``(scenario, facts)``, None where it is not known."""
        history, now = self._history, time.monotonic()
        begun = history.begun is not None and len(history.time) > history.first_row() + 1
        if self._waits is not None or not begun or ran is None or "unknown_law" in ran[1]:
            return
        if now < self._asked_at + PERIOD:
            return
        over = self.is_over(ran[0])
        key = history.cleared, float(history.moved if over else history.time[-1]), over
        if key == self._of or (over and self._is_judged()):
            return
        self._of = self._waits = key
        self._asked_at = now
        self._worker.ask(self._verdict(ran) if over else self._standings(ran))

    def is_over(self, scenario):
        """Return whether the run is as long as its ``scenario`` wants, or nothing commands robots."""
        return self._history.lasts(scenario.duration) or not self._study.is_controlled()

    def _is_judged(self):
        """Return whether there is a verdict already: a run that goes on after its duration keeps it."""
        if self._judged is None or self._judged[0] != self._history.cleared:
            return False
        return self._study.is_controlled() or self._judged[1] == self._history.moved

    def _standings(self, ran):
        so_far, ask = self._so_far(ran[1]), self._study.edited.ask_apart
        lasted = float(so_far.time[-1])
        return lambda: Said(lasted, standings=ask("standings_of", ran[0], so_far))

    def _verdict(self, ran):
        """Return the function that writes the run to a directory for a moment, and returns its verdict."""
        history, ask = self._history, self._study.edited.ask_apart
        lasted = float(history.time[-1] - history.begun)
        directory = tempfile.mkdtemp(prefix="mrs_simulator_verdict_")
        write = self._study.files.writing(history, directory, ran)

        def work():
            try:
                write()
                return Said(lasted, verdict=ask("verdict_on", ran[0], directory))
            finally:
                shutil.rmtree(directory, ignore_errors=True)

        return work

    def _so_far(self, facts):
        """Return the samples so far, thinned."""
        history = self._history
        first, last = history.first_row(), len(history.time) - 1
        most = max(FEWEST_SAMPLES, MOST_NUMBERS // (8 * len(history.numbers)))
        count = min(MOST_SAMPLES, most, last - first + 1)
        rows = np.unique(np.linspace(first, last, count).round().astype(int))
        state, begun = history.state.at(rows), history.begun
        # No difference of poses tells the velocities of real robots.
        columns = (JOINTS, TWIST, OUT_OF_PLANE) if history.real else (JOINTS,)
        meta = dict(facts, lockstep=history.recorded is not None, **history.facts_of_real())
        if history.incidents:
            meta["incidents"] = [i._replace(time=i.time - begun) for i in history.incidents]
        return SoFar(
            (history.cleared, begun),
            state.time - begun,
            history.numbers,
            state.pose.copy(),
            np.array(state.heights),
            state.command.copy(),
            history.axes,
            {each.name: state[each].copy() for each in columns if state.has(each)},
            tuple(c._replace(time=c.time - begun) for c in history.collisions),
            meta,
        )

    def take(self):
        """Return the newest ``Said``, once; None where there is none, or its run is gone."""
        found = self._worker.take()
        if found is None:
            return None
        asked, self._waits = self._waits, None
        if asked is None or asked[0] != self._history.cleared:
            return None
        said, error = found
        if error is not None:
            said = Said(asked[1] - (self._history.begun or 0.0), error=error)
        if asked[2]:
            self._judged = asked[:2]
        return said

    def close(self):
        """Ask for nothing more."""
        self._worker.ask(None)
