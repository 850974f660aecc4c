"""Headless experiments: the world and the control in lockstep in one process, without a master."""

import contextlib
import os
import time

import numpy as np

from mrs_simulator.control.array_law import has_form
from mrs_simulator.control.twists import ControlError
from mrs_simulator.control.user_code import call, print_raised, raised
from mrs_simulator.core import compiling
from mrs_simulator.core.doc_links import named, with_page
from mrs_simulator.core.kinematics import are_within
from mrs_simulator.core.reports import report
from mrs_simulator.core.snapshots import NotCopied
from mrs_simulator.protocols.loading import choose_protocol
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.controller_log import failure
from mrs_simulator.record.recording import InMemory, begin_facts, write_facts
from mrs_simulator.scenario.incidents import PUSHED, Event
from mrs_simulator.scenario.scenario import FARTHEST
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.state.layout import basic_layout
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.draw.figure_process import drawing
from mrs_simulator.study.results.provenance import write_provenance
from mrs_simulator.study.results.report import RUN_FILE, begin_run, write_report
from mrs_simulator.study.run.sensor_files import SensorRecorder, lines_of, recorded_sensors
from mrs_simulator.study.run.sensor_sizes import with_sizes
from mrs_simulator.study.run.snapshots import global_streams, kept_of
from mrs_simulator.study.run.stepping import Stepping
from mrs_simulator.vehicles.odometry_rates import odometry_steps
from mrs_simulator.verdict.requirements.step_trace import StepTrace
from mrs_simulator.verdict.theory.meetings import meetings_ahead
from mrs_simulator.verdict.user_values import texts_of
from mrs_simulator.world.command_watchdogs import LARGEST_COMMAND
from mrs_simulator.world.contact.contact_arrays import collisions_of
from mrs_simulator.world.world import EVERY, World

PROGRESS_AFTER = 2.0  # [s] of wall time before a progress bar appears
ROWS_AT_ONCE = 4000  # [-] samples times robots that are made by one compiled call


class LawFailed(RuntimeError):
    """The protocol raised, or returned no usable commands; the run ends there."""


class Experiment:
    """A world and a control; ``run`` closes the loop between them."""

    def __init__(self, scenario, protocol=None):
        """``protocol``: a ``PioneerControl`` subclass, by default the one the scenario names."""
        self.scenario, self._protocol = choose_protocol(scenario, protocol)
        self.streams = global_streams()  # as the run began, for one that is made again
        self.open()

    def _join(self, protocol):
        """Make control, sensors and estimator of the world's robots."""
        scenario = self.scenario
        self.control = make_control(scenario, protocol)
        self._every = scenario.steps_per_command, scenario.steps_per_record
        self.layout = self.control.team.layout(lambda column: column.given(scenario))
        self._is_basic = {*self.layout.widths} - {("estimate", 3)} == {*basic_layout().widths}
        self.sensors = Suite.of_scenario(scenario, *self.world.senses)
        self.estimator = _estimator(scenario, self.world.team)
        asked = scenario.estimates.asked if scenario.estimates else ()
        rate, team = scenario.odometry_rate, self.world.team
        self._odometry_steps = 1 if rate is None else odometry_steps(team, rate, scenario.step)
        required = sorted({name for each in scenario.requirements for name, _ in each.sensors})
        names = (*self.control.SENSORS, *asked, *required)
        self._asked_for = dict.fromkeys(range(scenario.n), names)
        self.sensors.activate(self._asked_for)
        mounts, kinds = self.sensors.mounts, self.world.team.kinds
        self._recorded = recorded_sensors(scenario.record, mounts, kinds)
        self._recorder = None  # of these sensors
        self.trace = StepTrace(scenario.requirements) if scenario.requirements else None
        self._collisions, self._begun, self.incidents = [], [], []
        self.warnings = scenario.warnings() + self.world.notes + self.control.team.notes
        self.warnings += [] if self.sensors.is_idle else self.sensors.notes
        self.warnings += self.control.foreseen + self._warned()

    def _warned(self):
        """Return the law's warnings; that it raised is one, too, and costs no run."""
        source = "{}.warnings()".format(type(self.control).__name__)
        try:
            return texts_of(call(self.control.warnings, self.scenario.starts), source)
        except Exception as error:
            print_raised(error)
            return ["{} raised {}".format(source, named(raised(error)))]

    def record_sensors(self, out, report):
        """Write the sensors that the scenario's ``record`` names to the directory ``out``.

        ``report`` is called beforehand with a text on each file's size.  Return ``SensorFiles``, or None.
        """
        if not self._recorded:
            return None
        known = self.scenario, *self.world.senses[:2], lines_of
        for each in with_sizes(self._recorded, *known):
            report(each.summary(self.scenario.duration))
        self._recorder = SensorRecorder(self._recorded, self.scenario, self.world, out)
        return self._recorder.files

    def watch(self, wanted):
        """Read the sensors ``wanted``, ``{row: names}``, from now on besides those that the run needs."""
        both = {row: (*own, *wanted.get(row, ())) for row, own in self._asked_for.items()}
        self.sensors.activate_from(both, max(0, self.step), self.world.sensed)

    def samples(self):
        """Step through the scenario; yield ``(time, pose, command)`` at the recorded steps.

        ``time`` [s], ``pose`` (n, 3) in the common frame, ``command`` (n, a) held from then on; the
        caller's own arrays.
        Raises ``LawFailed`` after all robots were commanded to stop.
        """
        self.begin()
        blocks = self._fused_steps() if self._can_fuse() else self.stepping()
        for (stamp,), (pose,), (command,) in blocks:
            yield stamp, pose, command

    def record(self, recorder):
        """Step through the scenario, and record it; yield how many samples were recorded each time.

        Raises as :meth:`samples` does.
        """
        self.begin()
        recorder.write_together()
        most = max(1, ROWS_AT_ONCE // self.scenario.n) if self._is_basic else 1
        for block in self._fused_steps(most) if self._can_fuse() else self.stepping(most):
            if len(block[0]) > 1:
                recorder.block(*block)
            else:
                (stamp,), (pose,), (command,) = block
                recorder.sample(stamp, self.state(pose, command))
            yield len(block[0])

    def compile(self):
        """Compile what takes the world from sample to sample, and make a step by it, where that can be.

        Return whether it can.
        """
        if not self._is_compilable():
            return False
        self.begin()
        return bool(list(self._fused_steps(steps=1)))

    def begin(self):
        """Let robots take off, and the law begin, before the first sample."""
        if self.step < 0:
            self.world.rise()
            self.asked(self.control.start)

    def go_on(self, commanded=True):
        """Go on to the next step, the first time to 0; return whether it is to be recorded.

        ``commanded``: whether the law commands the robots; else they are to stand.  Raises ``LawFailed``
        after all robots were commanded to stop.
        """
        command_every, record_every = self._every
        if self.step >= 0:
            self.advance()
        self.step += 1
        self._read(self.step)
        if self.step % command_every == 0:
            self.command_all() if commanded else self.halt()
        if self.trace is not None:
            world = self.world
            readings = None if self.sensors.is_idle else self.sensors.readings(world.time)
            self.trace.add(self.state(world.pose, world.command), readings)
        return self.step % record_every == 0

    def halt(self):
        """Command all robots to stand."""
        self.world.set_commands(EVERY, np.zeros_like(self.world.command))

    def advance(self):
        """Let the world make a step."""
        self.world.step()
        self.take_collisions()
        self.incidents.extend(self.world.faults.take())

    def take_collisions(self):
        """Take over the collisions that have begun in the world."""
        self._begun += self.world.contacts.take_begun()

    @property
    def collisions(self):
        """Return the ``Collision``s so far, a list that grows."""
        self._collisions += collisions_of(self._begun)
        self._begun.clear()
        return self._collisions

    def push(self, row, by):
        """Put robot ``row`` elsewhere, ``by`` (2,) [m], as an event of the scenario that is due now."""
        events = (
            *self.scenario.events,
            Event(round(self.world.time, 9), row + 1, PUSHED, by=tuple(by)),
        )
        self.world.faults.push(row, np.asarray(by, dtype=float))
        self.scenario = self.scenario._replace(events=events)

    def _read(self, step):
        """Read sensors, and estimate poses, after ``step`` steps."""
        if not self.sensors.is_idle:
            self.sensors.update(step, self.world.sensed)
        if self._recorder is not None:
            self._recorder.update(step, self.world)
        if self.estimator is not None:
            self._estimate(step)

    def snapshot(self):
        """Return what :meth:`restore` needs to go on from the last sample to the same bits.

        Where something cannot be copied, such as a law's generator or a solver's memory, ``restore`` runs
        the experiment again from its start.
        """
        if self._recorder is not None:
            raise NotCopied("sensors are recorded to files, which cannot be taken back")
        return kept_of(self)

    def restore(self, kept):
        """Go back to the sample at which :meth:`snapshot` returned ``kept``; :meth:`samples`, called again,
        goes on from there.

        Raises ``NotRepeated`` where the law keeps a state elsewhere than in itself, or where a run that
        cannot be copied is not the same again.
        """
        kept.restore(self)

    @property
    def stateful(self):
        """Return what a ``Snapshot`` of this experiment keeps the state of."""
        more = [] if self.estimator is None else [self.estimator]
        return [self, *self.world.stateful, self.control, self.sensors, *more]

    def open(self):
        """Begin anew, with a new world and a new control."""
        self.step = -1  # of the last sample, -1 before the first
        self.world = World.from_scenario(self.scenario)
        try:
            self._join(self._protocol)
        except BaseException:
            self.world.close()
            raise

    def sample(self):
        """Return ``(time, pose, command)`` now, as :meth:`samples` does.

        Raises ``LawFailed`` where the team is driven apart.
        """
        world = self.world
        self._check_near(world)
        # Column by column, as they lie there: anything else takes ten times as long.
        return world.time, world.pose.copy(order="F"), world.command.copy(order="F")

    def _estimate(self, step):
        """Let the estimator take in what odometry and sensors measure after ``step`` steps."""
        published = (
            np.broadcast_to(step // self._odometry_steps * self._odometry_steps, self.scenario.n)
            * self.scenario.step
        )
        readings = self.estimator.fresh(self.sensors.readings(self.world.time))
        self.estimator.update(np.rint(1e9 * published), self.world.estimates.pose(), readings)

    def _is_compilable(self):
        """Return whether ``FusedStepping`` could take the world from sample to sample."""
        return has_form(self.control) and self.can_fuse

    @property
    def can_fuse(self):
        """Return whether nothing but the law looks at robots between samples, and steps can be fused."""
        return self.sensors.is_idle and self.can_fuse_between_readings

    @property
    def can_fuse_between_readings(self):
        """Return whether nothing but the law and sensors looks at robots, and steps can be fused."""
        if not (self._recorder is None and self.estimator is None and self.trace is None):
            return False
        return self.world.can_fuse(self.scenario.steps_per_command)

    def _can_fuse(self):
        """Return whether ``FusedStepping`` is to take the world from sample to sample."""
        if not self._is_compilable():
            return False
        saved = getattr(self.world.motion, "SAVED", compiling.SAVED)
        compiled, hint = compiling.pays(steps_of(self.scenario), self.scenario.n, saved)
        if hint:
            _report(hint)
        return compiled

    def _fused_steps(self, most=1, steps=None):
        """Return the blocks of up to ``most`` samples up to ``steps``, see ``FusedSteps.blocks``."""
        from mrs_simulator.study.run.fused_steps import FusedSteps  # numba only where it is wanted

        if self.step < 0:
            self.command_all()
        return FusedSteps(self, most).blocks(steps_of(self.scenario) if steps is None else steps)

    def stepping(self, most=1):
        """Return the blocks of up to ``most`` samples of robots that go from command to command."""
        steps = steps_of(self.scenario)
        stepping = Stepping(self, most) if Stepping.fits(self) else None
        while self.step < steps:
            if stepping is not None and stepping.is_worth():
                yield from stepping.block(steps)
            elif self.go_on():
                stamp, pose, command = self.sample()
                yield [stamp], pose[np.newaxis], command[np.newaxis]

    def command_within(self, command):
        """Give all robots the ``command`` (n, a) that the law wants, within limits."""
        self.give(self.asked(self.control.runner.limited, command))

    def command_all(self):
        """Ask the law, and command all robots."""
        self.give(self._command(self._known()))

    def give(self, command):
        """Give all robots the ``command`` (n, a); ``LawFailed`` where the world refuses it."""
        if not self.world.set_commands(EVERY, command):
            self._refuse_too_fast(command)

    def _refuse_too_fast(self, command):
        """Raise ``LawFailed`` for a ``command`` (n, a) that the world would refuse, after all stand."""
        self.halt()
        row = int(np.abs(command).max(axis=1).argmax())
        text = "at {:.3f} s robot{} was commanded {:.3g}, wanted at most {:g}: the team is driven apart"
        values = self.world.time, row + 1, np.abs(command[row]).max(), LARGEST_COMMAND
        raise LawFailed(text.format(*values))

    def state(self, pose, command):
        """Return the ``StateTable`` to record of robots now at ``pose`` (n, 3) under ``command`` (n, a)."""
        estimate, world = self.estimator and self.estimator.pose, self.world
        if self._is_basic:  # hand points, which the recorder finds
            return StateTable(world.time, pose=pose, command=command, estimate=estimate)
        state = world.state().replace(pose=pose, command=command, estimate=estimate)
        return world.team.recorded(state, self.control.l)

    def _check_near(self, world):
        places = world.pose[:, :2]
        if not are_within(places, FARTHEST):
            far = np.flatnonzero(~(np.abs(places) <= FARTHEST).all(axis=1))
            self.halt()
            text = "at {:.3f} s robot{} was more than {:g} m away: the team is driven apart"
            raise LawFailed(text.format(world.time, far[0] + 1, FARTHEST))

    def requirement_results(self):
        """Return what became of the scenario's requirements, as ``results.evaluated`` does."""
        return self.trace.results(self.scenario, self.control, self.collisions)

    def _known(self):
        """Return the odometry, (n, 3), and of robots that leave the ground their heights, (n, 4)."""
        pose, z = self.world.estimates.pose(), self.world.estimates.z()
        pose = pose if self.estimator is None else self.estimator.pose
        return pose if z is None else np.column_stack([pose, z])

    def _joints(self):
        return self.world.joints if self.world.team.has_joints else None

    def _command(self, pose):
        known = pose, self.world.time, self._joints()
        if not self.sensors.is_idle:
            known += (self.sensors.readings(self.world.time),)
        return self.asked(self.control.commands, *known)

    def asked(self, function, *arguments):
        """Return what the law's ``function`` returns; ``LawFailed`` where it raises."""
        try:
            return call(function, *arguments)
        except Exception as error:
            self.halt()
            text = "at {:.3f} s {}".format(self.world.time, failure(raised(error)))
            raise LawFailed(text) from error


def run_experiment(
    scenario,
    out,
    protocol=None,
    progress=False,
    formats=("png", "pdf"),
    look=None,
    apart=None,
    announce=None,
):
    """Run ``scenario``, write everything to the directory ``out`` and return the verdict.

    Writes ``scenario.yaml`` and, as it goes, ``run.csv``; then ``run.json``, the figures, in ``formats``
    and as the ``style.Look`` has them, and ``verdict.json``.  A run that is interrupted or whose law
    fails is reported as far as it went; ``verdict["ended"]`` says which.  ``apart``: the ``Drawing`` that
    is to draw them, by default one that begins now; ``announce``: called with the verdict before figures
    are drawn.
    """
    with contextlib.nullcontext(apart) if apart else drawing(formats) as apart:
        run, control = perform(scenario, out, protocol, progress, apart)
        verdict = write_report(run, out, formats, control, look, apart, announce)
    closest = verdict["min_distance"]  # in the samples too, at which the world does not look
    if closest is not None and closest < run.meta["closest_approach"]:
        meta = dict(run.meta, closest_approach=closest)
        write_facts(os.path.join(out, RUN_FILE), run.collisions, meta)
    write_provenance(run.scenario, out, look)
    return verdict


def perform(scenario, out, protocol=None, progress=False, apart=None):
    """Run ``scenario``, record it in the directory ``out``; return the ``Run`` and its control.

    ``apart``: a ``figure_process.Drawing`` that is to draw the run.
    """
    experiment = Experiment(scenario, protocol)
    scenario = experiment.scenario
    ahead = meetings_ahead(experiment.control, scenario)
    for text in ahead:
        _report("warning: " + text)
    experiment.warnings += ahead
    started, ended = time.monotonic(), "complete"
    kept = {
        "layout": experiment.layout,
        "kept": samples_of(scenario),
        "memory": apart and apart.memory,
    }
    with begin_run(scenario, out, report=_report, **kept) as recorder:
        begin_facts(recorder.path, lockstep=True)
        sensors = experiment.record_sensors(out, _report)
        if apart is not None:
            apart.begin(recorder)
        try:
            _finish(experiment.record(recorder), scenario, progress)
        except KeyboardInterrupt:
            ended = "interrupted"
        except LawFailed as error:
            ended = str(error)
            world = experiment.world
            if world.time == 0.0:  # where the robots stand is known all the same
                recorder.sample(world.time, experiment.state(world.pose, world.command))
            cause = error.__cause__
            if isinstance(cause, ControlError):  # of which no line of the law says more
                _report(with_page(cause))
            elif cause:
                print_raised(cause)
        finally:
            if sensors is not None:
                sensors.close()
    wall = time.monotonic() - started
    meta = {"real_time_factor": experiment.world.time / wall}
    meta.update(facts_of(experiment, recorder, sensors, ended))
    experiment.world.close()
    write_facts(recorder.path, experiment.collisions, meta)
    return recorder.run(scenario), experiment.control


def played(scenario, protocol=None):
    """Run ``scenario`` and return the ``Run``, of which nothing is written, and its control.

    Otherwise as :func:`perform`; the real-time factor is not measured, and no warning printed.
    """
    experiment, ended = Experiment(scenario, protocol), "complete"
    scenario = experiment.scenario
    recorder = InMemory(
        range(1, scenario.n + 1), scenario.hand_length, experiment.layout, samples_of(scenario)
    )
    with contextlib.closing(experiment.world) as world:
        try:
            _finish(experiment.record(recorder), scenario, False)
        except LawFailed as error:
            ended = str(error)
            if world.time == 0.0:  # where the robots stand is known all the same
                recorder.sample(world.time, experiment.state(world.pose, world.command))
        meta = facts_of(experiment, recorder, None, ended)
    return recorder.run_with(scenario, experiment.collisions, meta), experiment.control


def facts_of(experiment, recorder, sensors, ended):
    """Return what ``run.json`` is to say of the run so far, by the names in ``FACTS``.

    ``sensors``: the ``SensorFiles`` beside the ``recorder``, or None; ``ended``: "complete", or why not.
    """
    facts = {
        "closest_approach": experiment.world.contacts.closest,
        "warnings": experiment.warnings
        + recorder.warnings()
        + (sensors.warnings() if sensors is not None else []),
        "deadlock": [list(each) for each in experiment.control.safety_filter.deadlock],
        "ended": ended,
        "lockstep": True,
    }
    if experiment.incidents:
        facts["incidents"] = experiment.incidents
    if experiment.trace is not None:
        facts["requirements"] = experiment.requirement_results()
    return facts


def _report(text):
    report("experiment: " + text)


def _finish(recording, scenario, progress):
    """Let ``recording`` go on to its end, with a bar of its ``progress``, if that is wanted."""
    if not progress:
        for _ in recording:
            pass
        return
    from tqdm import tqdm  # only a terminal needs it

    total = samples_of(scenario)
    with tqdm(total=total, unit="sample", delay=PROGRESS_AFTER, leave=False) as bar:
        for count in recording:
            bar.update(count)


def steps_of(scenario):
    """Return how many steps a complete run of ``scenario`` has."""
    return int(round(scenario.duration / scenario.step))


def samples_of(scenario):
    """Return how many samples a complete run of ``scenario`` has."""
    return steps_of(scenario) // scenario.steps_per_record + 1


def _estimator(scenario, team):
    """Return the ``Estimator`` of the ``scenario``, None where it has no ``estimates``."""
    if scenario.estimates is None:
        return None
    from mrs_simulator.sensors.pose_filter.estimation import Estimator

    return Estimator.of_scenario(scenario, team)
