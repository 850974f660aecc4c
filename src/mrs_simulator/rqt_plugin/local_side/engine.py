"""The simulation of a GUI without ROS: a program that runs an experiment at a pace, on request.

It sends what happens as ``(name, value)``, and is sent requests as ``(name, arguments)``.
"""

import contextlib
import sys
import tempfile
import threading
import time
import traceback
from multiprocessing.connection import Client

import numpy as np

from mrs_simulator.control.user_code import call, raised
from mrs_simulator.control.worker_process import named_place
from mrs_simulator.core.compiling import in_time
from mrs_simulator.core.fields import counted
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.pacing import Pacer
from mrs_simulator.core.writing import Forgiving
from mrs_simulator.record.controller_log import LAW_FAILED, deadlock_text, failure
from mrs_simulator.record.run_changes import controller_settings
from mrs_simulator.rqt_plugin.local_side.run_record import RunRecord, sizes
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.run.stage_run import OF_THE_STAGE
from mrs_simulator.rqt_plugin.run.study_state import BY_REQUEST, EMERGENCY, RELEASED
from mrs_simulator.scenario.incidents import FARTHEST_PUSH
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.state.status import Controller, Stage
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run.ahead import FIDELITIES
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles.portable import portable
from mrs_simulator.verdict.theory.meetings import meetings_ahead
from mrs_simulator.world.world import World

NO_CONTROLLER = "no controller runs"
# Wall times [s]: between two looks at requests, two pictures, two statuses, two pictures at rest.
LOOK, PICTURE, STATUS, REST = 0.005, 0.03, 0.1, 0.2
NAP = 0.01  # [s] of wall time that is waited at most for a request
UNMOVED = 1e-6  # [m] within which a robot is where it is held
BEAT = 0.4  # [s] of wall time without a status after which the last one is sent again


class Link:
    """The connection to the GUI.  Statuses go on while a law holds up everything else."""

    def __init__(self, address):
        self._connection, self._lock = Client(address), threading.Lock()
        self._status, self._sent = None, time.monotonic()
        self._thread = threading.get_ident()  # which runs laws
        threading.Thread(target=self._beat, daemon=True).start()

    def send(self, name, value=None):
        """Send ``value`` as ``name``; waits while the GUI is behind."""
        with self._lock:
            if name == "stage":
                self._status, self._sent = value, time.monotonic()
            self._connection.send((name, value))

    def requests(self, wait):
        """Return the requests that came; where there is none, after ``wait`` [s] at most."""
        taken = []
        while self._connection.poll(0.0 if taken else wait):
            taken.append(self._connection.recv())
        return taken

    def _beat(self):
        while True:
            time.sleep(BEAT)
            if self._status is not None and time.monotonic() - self._sent > BEAT:
                try:
                    self.send("stage", self._status)
                    self.send("law_at", place_of(sys._current_frames().get(self._thread)))
                except OSError:  # the GUI is gone, and this program ends
                    return


def place_of(frame):
    """Return file, line and function of a user's code that a ``frame`` is in, "" without such code."""
    stack = traceback.extract_stack(frame) if frame is not None else ()
    return named_place((each.filename, each.lineno, each.name) for each in reversed(stack))


class Engine:
    """A world, and once a controller was started the ``Experiment`` that it is of."""

    def __init__(self, link, scenario, speed, directory):
        """``speed``: 0 for as fast as possible; ``directory``: of the runs' files."""
        self._directory, self._record = directory, None  # the ``RunRecord`` of the experiment
        self._link, self._pacer, self._paused = link, Pacer(speed), False
        self._home = scenario  # with the robots where a reset puts them
        # of the world as it begins, after a controller where that left them
        self._staged = scenario
        self._world, self._experiment = World.from_scenario(scenario), None
        self._ran = None  # the scenario of the controller, as its settings are now
        self._running, self._trouble, self._emergency = False, "", False
        self._is_over, self._steps = False, 0  # whether the duration is over; steps asked for
        self._held = {}  # (x, y) [m] where a person holds robots, by row
        self._watched = {}  # names of sensors by row
        self._known = 0, 0  # collisions and incidents that were sent
        self._last = dict.fromkeys(("look", "picture", "status"), -np.inf)

    def spin(self):
        """Run until the GUI is gone."""
        self._publish_scenario()
        while True:
            self._serve()
            if self._may_step():
                self._step()
            self._publish()

    # The run -------------------------------------------------------------------------------------

    @property
    def world(self):
        """Return the world that is simulated now."""
        return self._world if self._experiment is None else self._experiment.world

    def _may_step(self):
        if self._experiment is None or (self._experiment.step < 0 and not self._running):
            return False  # time begins with the controller
        return self._steps > 0 or not self._paused and self._pacer.wait() == 0.0

    def _step(self):
        experiment = self._experiment
        self._steps = max(0, self._steps - 1)
        try:
            experiment.begin()
            with in_time(self._pacer.unhurried):
                is_sample = experiment.go_on(self._running)
            if is_sample:
                self._record.sample()
        except LawFailed as error:
            self._fail(error)
            is_sample = True
        self._pacer.stepped(self.world.step_size)
        if is_sample:
            self._send_state(is_sample)
            self._hold()
        if self.world.time >= self._ran.duration - 1e-9 and not self._is_over:
            self._is_over = self._paused = True
            text = "the run's {:g} s are over: Save it, or Go on"
            self._answer("paused", True, text.format(self._ran.duration))

    def _hold(self):
        """Push the robots that a person holds to where they are held, once a sample."""
        world = self.world
        for row, place in self._held.items():
            by = np.asarray(place, dtype=float) - world.pose[row, :2]
            if np.hypot(*by) > UNMOVED and row < world.n:
                self._experiment.push(row, np.clip(by, -FARTHEST_PUSH, FARTHEST_PUSH).tolist())

    def _on_hold(self, row, place):
        """Hold robot ``row`` at ``place`` (x, y) [m] of the common frame; None: let it go."""
        if place is None:
            self._held.pop(row, None)
        elif self._experiment is None or not self._running:
            raise ValueError("{}: robots are pushed while one drives them".format(NO_CONTROLLER))
        elif self._staged.fidelity not in FIDELITIES:
            raise ValueError("with forces no robot can be put elsewhere")
        else:
            self._held[row] = place

    def _fail(self, error):
        cause = error.__cause__
        traceback.print_exception(type(error), error, error.__traceback__)
        said = failure(raised(cause)) if cause is not None else "{}: {}".format(LAW_FAILED, error)
        self._running, self._trouble = False, said
        self._record.fail(error)
        self._send_status()

    def _open(self, scenario, running):
        """Make the experiment of ``scenario`` in place of what there was."""
        experiment = Experiment(scenario)
        experiment.warnings += meetings_ahead(experiment.control, experiment.scenario)
        directory = tempfile.mkdtemp(prefix="run_", dir=self._directory)
        record = RunRecord(experiment, directory)
        self._end_run()
        self._held = {}
        self._record = record
        self.world.close()
        self._experiment, self._ran = experiment, experiment.scenario
        self._paused = self._paused and not self._is_over
        self._is_over, self._known = False, (0, 0)
        self._running, self._trouble = running, "" if running else BY_REQUEST
        self._on_watch(self._watched)
        self._pacer.resume()
        self._link.send("run", directory)
        self._publish_settings()
        self._send_status()  # before the first step, which may take long

    def close(self):
        """Finish the files of the run, and free what the world holds."""
        self._end_run()
        self.world.close()

    def _end_run(self):
        if self._record is not None:
            record, self._record = self._record, None
            try:
                record.close()
            except OSError as error:  # a full disk, which the next run need not suffer from
                print("simulation: {}".format(error), file=sys.stderr)

    def _placed(self, scenario):
        """Return ``scenario`` with robots where they are now, as they began if they never moved."""
        if self._experiment is None or self._experiment.step < 0:
            begin = self._staged
            return scenario._replace(poses=begin.poses, kinds=begin.kinds, altitude=begin.altitude)
        state = self.world.state()
        altitude = state.heights if self.world.team.is_spatial else scenario.altitude
        return scenario._replace(poses=self.world.pose.copy(), altitude=altitude, takeoff=None)

    # Requests ------------------------------------------------------------------------------------

    def _serve(self):
        """Answer the requests, waiting for some while there is nothing else to do."""
        now = time.monotonic()
        busy = self._may_step()
        if busy and now - self._last["look"] < LOOK:
            return
        self._last["look"] = now
        paced = not self._paused and self._experiment is not None and self._pacer.speed > 0.0
        wait = 0.0 if busy else min(NAP, self._pacer.wait() or NAP) if paced else NAP
        for name, arguments in self._link.requests(wait):
            try:
                success, said = True, getattr(self, "_on_" + name)(*arguments) or ""
            except (Exception, SystemExit) as error:  # of a law, which may raise anything
                traceback.print_exc()
                success, said = False, reason(raised(error))
            if name == "control" and not success:
                self._link.send("control_ended", said)
            elif name not in ("watch", "control", "write") and not (name == "hold" and success):
                self._answer(name, success, said)

    def _answer(self, name, success, said):
        self._link.send("result", (name, success, said))

    def _on_control(self, path):
        """Make a controller of the scenario at ``path``, which drives the robots from where they are."""
        given = load_scenario(path)
        if given.n != self._staged.n:
            text = "a controller of {} robots, wanted one of the simulated {}"
            raise ValueError(text.format(given.n, self._staged.n))
        own = {name: getattr(self._staged, name) for name in OF_THE_STAGE}
        self._open(self._placed(given._replace(**own)), running=not self._emergency)

    def _on_end_control(self):
        self._on_stop()
        if self._experiment is not None:  # the robots stay where they are
            self._end_run()
            self._staged = self._placed(self._staged)
            self._experiment.world.close()
            self._world, self._experiment = World.from_scenario(self._staged), None

    def _on_start(self):
        if self._experiment is None:
            raise ValueError(NO_CONTROLLER)
        if self._emergency:
            raise ValueError("emergency stop: release it first")
        if not self._running:
            self._open(self._placed(self._ran), running=True)
        return "running"

    def _on_stop(self):
        if self._experiment is not None and self._running:
            self._experiment.halt()
            self._running, self._trouble = False, BY_REQUEST
            self._record.note_stop(BY_REQUEST)
        return "stopped"

    def _on_emergency(self, on):
        if on and self._experiment is not None:
            self._on_stop()
            self._trouble = EMERGENCY
            self._record.note_stop(EMERGENCY)
        elif self._emergency and not on and self._trouble == EMERGENCY:
            self._trouble = RELEASED + ", press Start controller"
        self._emergency = bool(on)

    def _on_pause(self, on):
        self._paused = bool(on)
        self._pacer.resume()
        return "paused" if on else "goes on"

    def _on_step(self, steps):
        self._steps += int(steps)

    def _on_set_speed(self, speed):
        self._pacer.set_speed(float(speed))

    def _on_reset(self):
        """Put the robots to where they began; time begins with the controller."""
        self._begin_anew(self._home)
        return "the robots are where they began: start the controller"

    def _on_set_team(self, poses, kinds, altitude):
        staged = self._staged
        if staged.topology is not None:
            staged = staged._replace(topology=staged.topology.for_robots(len(poses)))
        poses = np.asarray(poses, dtype=float).tolist()
        altitude = None if altitude is None else np.asarray(altitude, dtype=float).tolist()
        changed = dict(robots=len(poses), poses=poses, altitude=altitude, model=list(kinds))
        self._begin_anew(staged.changed(**changed))
        self._publish_scenario()
        return counted(self.world.n, "robot")

    def _begin_anew(self, staged):
        """Simulate the team of ``staged`` from its beginning; a controller of as many robots stands by."""
        world, had_controller = World.from_scenario(staged), self._experiment is not None
        self.close()
        self._world, self._experiment = world, None
        self._home = self._staged = staged
        self._running, self._paused = False, False
        self._link.send("run")
        if had_controller:  # else it would be said of one that is asked for meanwhile
            self._link.send("control_ended", "")
        self._send_state(is_sample=False)

    def _on_set_parameters(self, values):
        control = self._controlled()
        call(control.set_parameters, values)
        changed = self._ran.control._replace(parameters=dict(control.parameters))
        self._ran = self._ran._replace(control=changed)
        self._publish_settings()
        return "parameters set"

    def _on_set_topology(self, edges, directed):
        control = self._controlled()
        topology = Topology(self._ran.n, edges, directed)
        call(control.set_topology, topology)
        changed = self._ran.control._replace(parameters=dict(control.parameters))
        self._ran = self._ran._replace(topology=topology, control=changed)
        self._publish_settings()
        return "{} edges".format(len(edges))

    def _controlled(self):
        if self._experiment is None:
            raise ValueError(NO_CONTROLLER)
        return self._experiment.control

    def _on_write(self, token, directory):
        """Bring the files of the run in ``directory`` up to date; answer ``token`` with what is in them."""
        found = None
        try:
            record = self._record
            is_current = record is not None and record.directory == directory
            found = record.write() if is_current else sizes(directory)
        finally:
            self._link.send("written", (token, found))

    def _on_watch(self, wanted):
        """Read the sensors ``wanted``, names by row, besides those that the run needs."""
        self._watched = wanted
        if self._experiment is not None:
            self._experiment.watch(wanted)

    # What is sent --------------------------------------------------------------------------------

    def _publish(self):
        now, moves = time.monotonic(), self._experiment is not None and not self._paused
        if now - self._last["picture"] >= (PICTURE if moves else REST):
            self._send_state(is_sample=False)
        if now - self._last["status"] >= STATUS:
            self._pacer.measure()
            self._send_status()
            if self._experiment is not None and self._watched:
                readings = self._experiment.sensors.readings(self.world.time)
                self._link.send("readings", (self.world.time, readings))

    def _send_status(self):
        self._last["status"] = time.monotonic()
        self._link.send("stage", self._stage())
        if self._experiment is not None:
            self._link.send("control", self._controller())

    def _send_state(self, is_sample):
        self._last["picture"] = time.monotonic()
        world, experiment = self.world, self._experiment
        state = world.state()
        everything = dict(robots=tuple(state.robots), fresh=np.ones(world.n, dtype=bool))
        estimator = experiment and experiment.estimator
        estimate = estimator.pose.copy() if is_sample and estimator is not None else None
        self._link.send("state", (state.replace(**everything).copy(), is_sample, estimate))
        if experiment is not None:
            collisions, incidents = experiment.collisions, experiment.incidents
            for name, found, known in zip(
                ("collisions", "incidents"), (collisions, incidents), self._known
            ):
                if len(found) > known:
                    self._link.send(name, found[known:])
            self._known = len(collisions), len(incidents)

    def _stage(self):
        world, flights = self.world, self.world.flights.states()
        return Stage(
            stamp=world.time,
            fidelity=self._staged.fidelity,
            robots=world.n,
            speed=self._pacer.speed,
            real_time_factor=self._pacer.real_time_factor,
            paused=self._paused,
            lockstep=True,
            trouble="",
            missed_periods=0,
            command_periods=0,
            real_silent=(),
            closest_approach=world.contacts.closest,  # measuring now would change what is recorded
            flight=tuple(flights.get(row, "") for row in range(world.n)) if flights else (),
        )

    def _controller(self):
        experiment = self._experiment
        control, topology = experiment.control, experiment.control.topology
        return Controller(
            stamp=self.world.time,
            protocol=type(control).__name__,
            period=control.period,
            running=self._running,
            trouble=self._trouble,
            stale=(),
            stopped=(),
            axes=self.world.team.axes,
            command=self.world.command.copy(),
            edges=tuple(topology.edges),
            directed=topology.directed,
            targets=self._targets(control),
            warnings=(
                *experiment.warnings,
                *filter(None, [deadlock_text(control.safety_filter.deadlock)]),
            ),
        )

    def _targets(self, control):
        """Return where points are wanted, (n, d) [m], (0, 2) for nowhere."""
        state, none = self.world.state(), np.empty((0, 2))
        pose = self.world.pose
        if self.world.team.is_spatial:
            pose = np.column_stack([pose, state.heights])
        try:
            targets = call(control.targets, control.points(pose))
        except Exception:  # a display's places never stop the run
            return none
        return none if targets is None else np.array(targets, dtype=float)

    def _publish_scenario(self):
        self._link.send("scenario", portable(self._staged)[0].to_yaml())

    def _publish_settings(self):
        settings = controller_settings(self._ran)
        self._record.note_settings(settings)
        self._link.send("applied", (self.world.time, settings))


def main():
    """Run the engine of a GUI; arguments: its address, scenario, speed, and where runs are recorded."""
    address, path, speed, directory = sys.argv[1:5]
    sys.stdout, sys.stderr = Forgiving(sys.stdout), Forgiving(sys.stderr)  # laws print, too
    with refusing_bad_input("simulation"):
        engine = Engine(Link(address), load_scenario(path), float(speed), directory)
    try:
        engine.spin()
    except (EOFError, ConnectionError, KeyboardInterrupt):
        pass  # the GUI has ended, or ends this program
    finally:
        with contextlib.suppress(OSError):  # of a directory that the GUI has removed
            engine.close()


if __name__ == "__main__":
    main()
