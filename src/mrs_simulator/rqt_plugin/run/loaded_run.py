"""A recorded run read back for the window: its samples, its theory and its verdict; without Qt."""

import contextlib
import functools
import os
from typing import Any, NamedTuple, Optional

import numpy as np

from mrs_simulator.protocols import HOMES
from mrs_simulator.record.run_changes import changed_by
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.run.history import History
from mrs_simulator.state.columns import TWIST
from mrs_simulator.study.results.report import VERDICT_FILE, read_run
from mrs_simulator.verdict.verdict_file import read_verdict

MOST_CHANGES = 50  # [-] of settings, of which the law is asked
MOST_TARGETS = 200  # [-] samples for which targets are asked
NO_SCENARIO = "its scenario is not known: neither targets nor theory are shown"


class LoadedRun(NamedTuple):
    """A run as the window shows it."""

    path: str  # of its folder, or of a bag
    history: History
    scenario: Any  # None where it is not known
    settings: Any  # ``((since [s], law_answers.Facts), ...)``, None where its law is not known
    targets: Any  # of each of some samples, (rows (k,), (k, n, d) [m]), None where there are none
    error: Any  # the formation error (m,) [m] of poses (m, n, 3), a function, or None
    prediction: Any  # a ``law_answers.Prediction``, or None
    verdict: Optional[dict]  # as in verdict.json, None where it was not judged yet
    troubles: tuple = ()  # what could not be had, texts

    @property
    def begin(self):
        """Return the time [s] at which the run begins."""
        return float(self.history.time[0])

    def facts_at(self, row):
        """Return the law's ``Facts`` of the settings at the sample ``row``, None where not known."""
        passed = self.history.time[row] - self.begin
        known = [facts for since, facts in self.settings or () if since <= passed]
        return known[-1] if known else None

    def targets_at(self, row):
        """Return the targets (n, d) [m] at the sample ``row``, of the nearest of which they are known."""
        if self.targets is None:
            return None
        rows, targets = self.targets
        return targets[np.abs(rows - row).argmin()]

    @property
    def is_users_law(self):
        """Return whether its law is not a shipped one, which may take long to answer."""
        return self.scenario is not None and self.scenario.control.protocol not in HOMES


def load_run(path, data, ask):
    """Return the ``LoadedRun`` of the run at ``path``, whose samples are in the file ``data``.

    It may take long, and is for a thread of its own.  ``ask``: as ``LawProcess.ask``.  Raises what
    ``report.read_run`` raises, and ``OSError``; what a law raises is among the troubles.
    """
    run, verdict = read_run(data), None
    with contextlib.suppress(OSError, ValueError):  # not judged, or no verdict: it is judged anew
        verdict = read_verdict(os.path.join(path, VERDICT_FILE))
    answers = (None, None, None, None, (NO_SCENARIO,))
    if run.scenario is not None and not run.meta.get("unknown_law"):
        answers = _answers(run, ask)
    *found, troubles = answers
    return LoadedRun(path, history_of(run), run.scenario, *found, verdict, troubles)


def _answers(run, ask):
    """Return what the law of ``run`` says: settings, targets, error, prediction; and what went wrong."""
    scenario = run.scenario
    if not scenario.path and scenario.control.protocol not in HOMES:
        return None, None, None, None, (NO_SCENARIO,)  # a bag's law may be anybody's
    changes = run.meta.get("changes", [])
    now = changed_by(scenario, changes)
    try:
        settings = _settings(scenario, changes, ask)
        rows = np.unique(np.linspace(0, len(run.time) - 1, MOST_TARGETS).astype(int))
        targets = ask("targets_at", now, run.pose[rows])
        prediction = ask("prediction", scenario._replace(poses=run.pose[0].copy()))
    except Exception as error:  # a file of one's own may raise anything
        return None, None, None, None, ("no theory: {}".format(reason(error)),)
    if changes and prediction.time is not None:  # theory is of the settings of the beginning
        held = np.asarray(prediction.time) <= changes[0].time
        prediction = prediction._replace(time=prediction.time[held], error=prediction.error[held])
    if targets is None:
        return settings, None, None, prediction, ()
    return settings, (rows, targets), functools.partial(ask, "errors", now), prediction, ()


def _settings(scenario, changes, ask):
    """Return the law's ``Facts`` of a run of ``scenario``, each with the time [s] since when."""
    found = [(-np.inf, ask("facts", scenario))]
    for count, change in enumerate(changes[:MOST_CHANGES], 1):
        found.append((change.time, ask("facts", changed_by(scenario, changes[:count]))))
    return tuple(found)


def history_of(run):
    """Return a ``History`` of the samples, collisions and incidents of a ``Run``."""
    history = History()
    numbers = tuple(int(number) for number in run.robots)
    state = run.replace(robots=numbers)
    if not state.has(TWIST):
        state = state.replace(twist=mean_twist(run.time, run.pose))
    history.fill(state)
    history.scenario = run.scenario
    history.collisions.extend(run.collisions)
    history.incidents.extend(run.meta.get("incidents", []))
    return history


def mean_twist(time, pose):
    """Return twists (m, n, 3) [m/s, m/s, rad/s] in robots' frames, of differences of ``pose`` (m, n, 3).

    They are means over the samples beside each; zeros of a run of one sample.
    """
    if len(time) < 2:
        return np.zeros_like(pose)
    unwrapped = np.concatenate([pose[:, :, :2], np.unwrap(pose[:, :, 2:], axis=0)], axis=2)
    rates = np.gradient(unwrapped, time, axis=0)
    cosine, sine = np.cos(pose[:, :, 2]), np.sin(pose[:, :, 2])
    along = cosine * rates[:, :, 0] + sine * rates[:, :, 1]
    across = cosine * rates[:, :, 1] - sine * rates[:, :, 0]
    return np.stack([along, across, rates[:, :, 2]], axis=2)
