"""What if: how a run would go on from one of its moments with other gains, edges or places.

The run is repeated headless, once, with snapshots on the way.  From the one before a moment it goes on to
that moment, robots are put where they were recorded, and what is changed is changed.
"""

import os
import time
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.graphs import Topology
from mrs_simulator.record.recording import write_facts
from mrs_simulator.record.run_changes import (
    Change,
    changed_by,
    controller_settings,
    differences,
    read_changes,
    to_plain,
)
from mrs_simulator.scenario.incidents import PUSHED, Event
from mrs_simulator.study.results.provenance import write_provenance
from mrs_simulator.study.results.report import begin_run, write_report
from mrs_simulator.study.run.experiment import Experiment, LawFailed, facts_of, samples_of

LASTS = 0.5  # [-] of the run's duration, that is looked ahead at least
SNAPSHOTS = 100  # [-] of a run
SAME = 1e-9  # [m] within which a robot is where the repeated run has it
ALIKE = 1e-3  # [m] within which the recorded run is the repeated one
MOST_SHOWN = 300  # [-] samples of a future
FIDELITIES = ("point_mass", "kinematic")  # of robots that can be put elsewhere
NOT_MOVED = "what if: fidelity {}, wanted one of {}: with forces no robot can be put elsewhere"
TOO_LATE = "at {:.1f} s: wanted a moment within the first {:g} s, 1.5 times the scenario's duration"
UNLIKE = (
    "the run is not to be had by simulating it again: robot{} was {:.3g} m elsewhere at {:.2f} s; "
    "wanted a run of the simulation that nobody disturbed"
)


class Edit(NamedTuple):
    """What is otherwise from ``time`` [s] of a run on."""

    time: float
    recorded: Any  # (n, 3) [m, m, rad], where the robots were then
    places: dict  # (x, y) [m] of robots that are put elsewhere, by row
    parameters: dict  # of the law, by name
    topology: Any = None  # ``(edges, directed)``, None for as it was


class Future(NamedTuple):
    """How a run goes on, as far as it is known."""

    time: Any  # (m,) [s] since the run began
    pose: Any  # (m, n, 3) [m, m, rad]
    error: Any  # (m,) [m], the largest distance of a controlled point from its target, or None
    is_whole: bool  # else there is more to come
    trouble: str = ""  # why it ends early


class Moments:
    """The moments of one run, by simulating it again; ``changes``: those during the run."""

    def __init__(self, scenario, changes=()):
        """Raises ``ValueError`` for robots that cannot be put elsewhere."""
        if scenario.fidelity not in FIDELITIES:
            raise ValueError(NOT_MOVED.format(scenario.fidelity, " or ".join(FIDELITIES)))
        self.duration = scenario.duration  # [s] of the run itself
        self.scenario = scenario._replace(duration=(1.0 + LASTS) * scenario.duration, record=())
        self._experiment, self._changes, self._made = Experiment(self.scenario), list(changes), 0
        self._samples, self._kept = self._experiment.samples(), []
        every, steps = self.scenario.steps_per_record, self.scenario.duration / self.scenario.step
        self._gap = max(every, int(steps / SNAPSHOTS) // every * every)
        self._next()

    def step_at(self, moment):
        """Return the step of the last sample until ``moment`` [s]."""
        every = self.scenario.steps_per_record
        return int(round(moment / self.scenario.step)) // every * every

    def reach(self, moment, seconds=np.inf):
        """Go on to ``moment`` [s] for about ``seconds`` of wall time; return whether it is near.

        A call goes on by one snapshot at least.
        """
        end, wanted = time.perf_counter() + seconds, self.step_at(moment)
        if wanted > self.step_at(self.scenario.duration):
            raise ValueError(TOO_LATE.format(moment, self.scenario.duration))
        if self._kept[-1][0] + self._gap > wanted:
            return True
        self._back_to(self._kept[-1][0])
        while self._kept[-1][0] + self._gap <= wanted:
            before = len(self._kept)
            while len(self._kept) == before and self._next():
                pass
            if time.perf_counter() > end or len(self._kept) == before:
                return False
        return True

    def _next(self):
        """Go on to the next sample, and keep it where it is time to; return whether there is one."""
        if next(self._samples, None) is None:
            return False
        step = self._experiment.step
        self._make_changes(step)
        if not self._kept or step >= self._kept[-1][0] + self._gap:
            self._kept.append((step, self._experiment.snapshot(), self._made))
        return True

    def _make_changes(self, step):
        """Make the changes of the run that are due."""
        now = step * self.scenario.step
        due = [each for each in self._changes if each.time <= now + 1e-9]
        if len(due) > self._made:
            scenario, self._made = changed_by(self.scenario, due), len(due)
            obey(self._experiment.control, scenario.control.parameters, scenario.topology)
            self._samples = self._experiment.samples()  # what is compiled is of one law

    def _back_to(self, step):
        """Go back to the last kept sample before, or at, ``step``."""
        step, kept, made = [each for each in self._kept if each[0] <= step][-1]
        self._experiment.restore(kept)
        self._samples, self._made = self._experiment.samples(), made

    def at(self, moment):
        """Return the experiment at the last sample until ``moment`` [s]."""
        wanted = self.step_at(moment)
        self.reach(moment)
        self._back_to(wanted)
        while self._experiment.step < wanted and self._next():
            pass
        return self._experiment


def put(world, edit):
    """Put the robots of ``world`` where they were recorded, and those of ``edit.places`` there."""
    wanted = np.array(edit.recorded, dtype=float)
    for row, place in edit.places.items():
        wanted[row, :2] = place
    off = wanted - world.pose
    for row in np.flatnonzero(np.abs(off).max(axis=1) > SAME).tolist():
        world.motion.displace(row, off[row, :2])
        world.motion.pose[row, 2] = wanted[row, 2]


def obey(control, parameters, topology):
    """Have ``control`` obey other ``parameters``, by name, and a ``topology``, None for as it is."""
    if parameters:
        call(control.set_parameters, dict(parameters))
    if topology is not None:
        call(control.set_topology, topology)


class _Looked:
    """One look ahead, which may go on."""

    def __init__(self, moments, edit):
        self._experiment = experiment = moments.at(edit.time)
        world, control = experiment.world, experiment.control
        put(world, edit)
        obey(control, edit.parameters, edit.topology and Topology(world.n, *edit.topology))
        self._end = max(moments.duration, edit.time + LASTS * moments.duration) - 1e-9
        self._samples = experiment.samples()
        self._time, self._pose, self._error = [world.time], [world.pose.copy()], []
        self._whole, self._trouble = False, ""
        self._note_error()

    def _note_error(self):
        control, world = self._experiment.control, self._experiment.world
        z = world.z
        hand = control.points(world.pose if z is None else np.column_stack([world.pose, z]))
        targets = call(control.targets, hand)
        off = np.nan if targets is None else np.linalg.norm(hand - targets, axis=1).max()
        self._error.append(float(off))

    def go_on(self, seconds):
        """Go on for ``seconds`` of wall time; return the ``Future`` so far."""
        end = time.perf_counter() + seconds
        try:
            while not self._whole and time.perf_counter() < end:
                found = next(self._samples, None)
                if found is None:
                    self._whole = True
                    break
                self._time.append(found[0])
                self._pose.append(found[1])
                self._note_error()
                self._whole = found[0] >= self._end
        except LawFailed as error:
            self._whole, self._trouble = True, str(error)
        rows = np.linspace(0, len(self._time) - 1, min(len(self._time), MOST_SHOWN)).astype(int)
        rows, error = np.unique(rows), np.array(self._error)
        error = None if np.isnan(error).all() else error[rows]
        shown = np.array(self._time)[rows], np.array([self._pose[row] for row in rows])
        return Future(*shown, error, self._whole, self._trouble)


_RUN = {}  # the newest key with its ``Moments``, and under "looked" the look that may go on


def prepare_ahead(scenario, key, changes, moment, seconds):
    """Repeat the run ``key`` of ``scenario`` to ``moment`` [s], for ``seconds`` of wall time at most.

    Return whether that moment is reached.  ``changes``: those during the run, as ``run.json`` has them.
    """
    return _moments(scenario, key, changes).reach(moment, seconds)


def look_ahead(scenario, key, changes, edit, seconds):
    """Return the ``Future`` of the run ``key`` after ``edit``, as far as it is known in ``seconds`` [s]."""
    looked = _Looked(_moments(scenario, key, changes), edit)
    _RUN["looked"] = looked
    return looked.go_on(seconds)


def look_further(_, seconds):
    """Go on with the newest look ahead for ``seconds`` of wall time, and return its ``Future``."""
    return _RUN["looked"].go_on(seconds)


def _moments(scenario, key, changes):
    if key not in _RUN:
        _RUN.clear()
        _RUN[key] = Moments(scenario, read_changes(changes))
    return _RUN[key]


def keep_ahead(scenario, changes, edit, directory):
    """Run ``scenario`` with ``edit`` from its beginning, record and judge it in ``directory``.

    Robots that are put elsewhere are pushed by events of the scenario; other gains and edges are changes of
    the run.  Raises ``ValueError`` where the run simulated again is not the recorded one.
    """
    changes = read_changes(changes)
    moments = Moments(scenario, changes)
    moment = moments.step_at(edit.time) * scenario.step
    _refuse_unlike(moments.at(moment).world, edit)
    before = changed_by(scenario, changes)
    after = _settings(before, edit)
    own = differences(controller_settings(before), controller_settings(after))
    changes += [Change(round(moment, 9), key, value) for key, value in own.items()]
    lasts = max(scenario.duration, moment + LASTS * scenario.duration)
    pushed = scenario._replace(duration=lasts, events=_with_pushes(scenario, moment, edit))
    os.makedirs(directory, exist_ok=True)
    _record(pushed, changes, directory)


def _refuse_unlike(world, edit):
    """Raise ``ValueError`` where ``world`` has robots elsewhere than they were recorded."""
    off = np.hypot(*(world.pose - edit.recorded)[:, :2].T)
    row = int(np.argmax(off))
    if not off[row] <= ALIKE:
        raise ValueError(UNLIKE.format(row + 1, off[row], edit.time))


def _settings(scenario, edit):
    """Return ``scenario`` with the gains and edges of ``edit``."""
    control = scenario.control
    given = {**control.parameters, **edit.parameters}
    scenario = scenario._replace(control=control._replace(parameters=given))
    if edit.topology is None:
        return scenario
    return scenario._replace(topology=Topology(scenario.n, *edit.topology))


def _with_pushes(scenario, moment, edit):
    """Return the events of ``scenario`` and, at ``moment`` [s], a push of each robot put elsewhere."""
    pushes = []
    for row, place in edit.places.items():
        by = np.asarray(place) - edit.recorded[row, :2]
        pushes.append(Event(moment, row + 1, PUSHED, by=tuple(by.tolist())))
    return tuple(sorted((*scenario.events, *pushes), key=lambda event: event.at))


def _record(scenario, changes, directory):
    """Run ``scenario`` with ``changes`` on the way, and write everything to ``directory``."""
    experiment, made, ended = Experiment(scenario), 0, "complete"
    kept = samples_of(experiment.scenario)
    with begin_run(scenario, directory, layout=experiment.layout, kept=kept) as recorder:
        samples = experiment.samples()
        try:
            while True:
                found = next(samples, None)
                if found is None:
                    break
                recorder.sample(found[0], experiment.state(*found[1:]))
                due = [each for each in changes if each.time <= found[0] + 1e-9]
                if len(due) > made:
                    made, now = len(due), changed_by(scenario, due)
                    obey(experiment.control, now.control.parameters, now.topology)
                    samples = experiment.samples()
        except LawFailed as error:
            ended = str(error)
    meta = facts_of(experiment, recorder, None, ended)
    meta.update({"changes": to_plain(changes)} if changes else {})
    experiment.world.close()
    write_facts(recorder.path, experiment.collisions, meta)
    write_report(recorder.run(scenario), directory, ("png", "pdf"), experiment.control)
    write_provenance(scenario, directory)
