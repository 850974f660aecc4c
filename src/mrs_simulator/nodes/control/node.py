"""The control node: odometry in, the protocol's law, velocity commands out."""

import contextlib
import random
import threading
import time
from typing import Any, NamedTuple

import numpy as np
import rospy

from mrs_simulator.control.user_code import CallFailed, TimedOut
from mrs_simulator.core.fields import counted
from mrs_simulator.core.step_rates import on_steps
from mrs_simulator.nodes.control.command_gate import CommandGate
from mrs_simulator.nodes.control.command_times import CommandTimes
from mrs_simulator.nodes.control.common_frame import START, make_common_frame
from mrs_simulator.nodes.control.control_topics import (
    find_rivals,
    heed_rates,
    open_commands,
    open_sensors,
    refuse_arms_without_stage,
)
from mrs_simulator.nodes.control.estimated_poses import EstimatedPoses
from mrs_simulator.nodes.control.guards import Guards, going_on, slower, stopping_team
from mrs_simulator.nodes.control.law_client import Law, where_to_run
from mrs_simulator.nodes.control.motors import Motors
from mrs_simulator.nodes.control.reconfigure import ParameterServer
from mrs_simulator.nodes.control.requests import GOES_ON, Requests, how_to_start
from mrs_simulator.nodes.control.status import ControlHealth, ObeyedPublisher, StatusPublisher
from mrs_simulator.nodes.real.real_robots import real_among
from mrs_simulator.nodes.stage.lockstep import lockstep_wanted
from mrs_simulator.record.controller_log import LAW_FAILED, deadlock_text
from mrs_simulator.ros.node.clock_watch import ClockWatch
from mrs_simulator.ros.node.diagnostics import Diagnostics
from mrs_simulator.ros.node.node_parameters import (
    AUTOSTART,
    DRY_RUN,
    LAW_LIMIT,
    RATE,
    RESUME,
    SATURATION,
)
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.node.senders import doubled_text
from mrs_simulator.scenario.surroundings.moving_obstacles import scene_time
from mrs_simulator.vehicles.team_in_space import team_of

NAP = 0.05  # [s] of wall time, the longest wait of the main loop
REPORT_PERIOD = 5.0  # [s] of wall time between reports of what is missing
STALL = 1.0  # [s] of wall time, or two periods, without a command after which a law hangs
STALLED = "the law took too long for its command: see to it"
STILL = 1.0  # [s] of wall time after which the status says that the law is waited for
SIMULATED_LIMIT = 30.0  # [s] of wall time for a law while nothing real moves
FLUSH = 0.1  # [s] of wall time for the last zeros to leave


class Job(NamedTuple):
    """What the law is to be asked."""

    epoch: int  # a start or a stop meanwhile makes the answer void
    pose: Any  # (n, 3) [m, m, rad]
    known: Any  # the same; of robots that leave the ground (n, 4), with their heights
    now: float  # [s] time of the robots
    time: float  # [s] since the law began
    begins: bool
    readings: Any = None  # of the robots' sensors, ``{row: {name: reading}}``; None: none are used
    joints: Any = None  # (n, k) [rad] of robots with arms
    answered: Any = None  # (n,) [s] stamps of the odometry of the poses
    arrived: float = -np.inf  # [s] of wall time when the newest of it came


class ControlNode:
    """Runs one protocol over ROS; whatever goes wrong, the robots are stopped."""

    def __init__(self, scenario, protocol, fork_server=None):
        """``protocol``: a ``PioneerControl`` subclass; ``fork_server``: forks processes for it, or None."""
        self.scenario = scenario
        rate = read(RATE, scenario.control.rate)
        self.period = 1.0 / rate
        saturation = read(SATURATION, scenario.control.saturation)
        slowed = slower(scenario)
        control = slowed.control._replace(rate=rate, saturation=saturation)
        real = real_among(scenario.n)
        usual = max(STALL, 2.0 * self.period) if real else SIMULATED_LIMIT
        self.law_limit = read(LAW_LIMIT, usual)
        apart = where_to_run(protocol, fork_server)
        self._obeyed = ObeyedPublisher(scenario._replace(control=control))
        self.law = Law(slowed._replace(control=control), protocol, SIMULATED_LIMIT, apart)
        self.dry_run = read(DRY_RUN)
        known = self.law.numbers, saturation, self.dry_run, team_of(scenario).axes
        team = stopping_team(scenario)
        ahead = team, going_on(scenario, team, self.period)
        self.guards = Guards(*known, control.deadband, ahead)
        self.motors = Motors(self.law.numbers, self.dry_run)
        self.lockstep = lockstep_wanted(real, scenario.speed)
        self.resumes = read(RESUME, not real)
        # Whoever only names a law at real robots is not to see them move.
        self.running = read(AUTOSTART, not real)
        self.trouble = "" if self.running else "not started"
        self._lock = threading.Lock()
        self._real = bool(real)
        self._times = CommandTimes(self.period)
        self._answered, self._begun = None, None
        self._epoch = 0
        self._recovers = False  # whether the next command is the first after a trouble
        self._asked = None  # [s] of wall time since when the law is waited for
        self._all_received = False  # with ~autostart it is waited for once
        self._acted = 0.0  # [s] the time of the last command
        self._id = random.SystemRandom().getrandbits(32)
        self._sent = 0  # commands so far
        self._warnings, self._jump = [], ""
        self._awaiting = None  # [s] of wall time since when a reading is waited for in lockstep
        self._held = ()  # the last deadlock that was logged
        self._compute_time, self._latency = 0.0, 0.0
        self._reported = 0.0  # [s] of wall time when it was last reported what is missing
        self._simulated = rospy.get_param("/use_sim_time", False)
        simulated = set(range(scenario.n)).difference(real) if self._simulated else ()
        self._simulated_rows = sorted(simulated)
        self._open_topics(real)
        if scenario.odometry_rate is not None:
            heed_rates(self.inbox, scenario)

    def _open_topics(self, real):
        scenario, numbers, team = self.scenario, self.law.numbers, team_of(self.scenario)
        self._status = StatusPublisher(team.axes)
        self.frame = make_common_frame(scenario, leads=True)
        self.inbox = self.frame.inbox
        wake = self.inbox.wake if self.lockstep else None
        self.sensors = open_sensors(scenario, self.law.state.sensors, real, wake)
        self.estimates = None
        if scenario.estimates is not None:
            self.estimates = EstimatedPoses(scenario, self.frame, self.sensors)
        refuse_arms_without_stage(team, self.inbox)
        topics, self.rivals = None, None
        if not self.dry_run:
            self.rivals = find_rivals(numbers, self._simulated)
            topics = open_commands(team, numbers, self.inbox, real, self._simulated)
        self.outlet = CommandGate(
            topics, len(numbers), insists=bool(real), axes=team.axes, landing=team.landing
        )
        if self.running:
            self.outlet.open()
        # Odometry may come before the clock that makes its command due.
        self._clock = ClockWatch(self.inbox.wake, bool(real)) if self._simulated else None
        self._reconfigure = ParameterServer(self.law)
        self._requests = Requests(self)
        self._health = ControlHealth(self._status, self.inbox, self.sensors, self.estimates)
        self._diagnostics = Diagnostics(lambda: self._health.report(self._sent))
        rospy.on_shutdown(self._on_shutdown)
        if real and not self.dry_run:
            threading.Thread(target=self._watch, daemon=True).start()

    def _pose(self):
        """Return the poses (n, 3) that the control knows."""
        return self.frame.pose() if self.estimates is None else self.estimates.pose()

    # The main loop -------------------------------------------------------------------------------

    def spin(self):
        """Run until ROS shuts down."""
        rospy.loginfo(
            "pioneer_control: %s for %s, a command every %g s%s",
            self.law.name,
            counted(self.scenario.n, "robot"),
            self.period,
            ", in a dry run: nothing is published to the robots" if self.dry_run else "",
        )
        if self.running:
            self.motors.enable()
        elif self._real:
            text = "pioneer_control: real robots stand until they are started. Check them: %s"
            rospy.loginfo(text, how_to_start(self.scenario.control.protocol))
        while not rospy.is_shutdown():
            self.inbox.wait(NAP if self._simulated else min(NAP, self.period))
            with self._lock:
                job = self._turn()
            if job is not None:
                if job.begins:  # who records is to know of a start before its first command
                    self._publish_status(asks_law=False)
                self._ask(job)
            self._meanwhile()

    def _meanwhile(self):
        """To be called all the time, also while the law is waited for."""
        self.outlet.insist()
        self._publish_status()

    def _turn(self):
        """Return the ``Job`` that is due, or None."""
        silent = self.who_is_silent()
        trouble = silent or self.motors.missing()
        self._all_received = self._all_received or not silent
        jump = self.frame.jump_trouble()
        if jump and jump != self._jump:
            self._stop(jump)
            rospy.logerr("pioneer_control: robots stopped: %s", jump)
        self._jump = jump
        if not self.lockstep:
            self._estimate()
        if trouble:
            self._hold(trouble)
            if silent and self._all_received and self.running and not self.resumes:
                # Whoever walks up to robots that stand is not to be surprised by them.
                start = START.format(rospy.resolve_name("~start"))
                self._stop("{}: see to it, {}".format(silent, start))
        elif self.lockstep:
            return self._answer()
        elif self._times.take(rospy.get_time(), self._is_up_to_date, self.running):
            return self._job()
        return None

    def _estimate(self):
        if self.estimates is not None:
            self.estimates.update()

    def who_is_silent(self):
        """Return why it is unknown where the robots are now, or ""."""
        trouble = self._doubled()
        trouble = trouble or (self._clock.trouble() if self._clock else "")
        trouble = trouble or self.frame.missing(rospy.get_time())
        if self.sensors and not self.lockstep:
            trouble = trouble or self.sensors.missing(rospy.get_time())
        return trouble

    def _doubled(self):
        """Return who else drives these robots or publishes where they are, or ""."""
        others = self.rivals.found() if self.rivals else {}
        sensors = self.sensors.doubled() if self.sensors else {}
        return doubled_text({**others, **self.frame.doubled(), **sensors})

    def _is_up_to_date(self, now):
        """Return whether the simulated robots' odometry that is due by ``now`` [s] is there."""
        return not self._simulated_rows or self.inbox.is_up_to_date(self._simulated_rows, now)

    def _answer(self):
        """Lockstep: commands for each odometry, the last ones between two periods of the control."""
        stamp = self.inbox.complete()
        if stamp is None or self._awaits_readings(stamp):
            return None
        repeated = self.inbox.take_repeated()
        if stamp != self._answered:
            self._answered = stamp
            self._estimate()
            if self._times.take(stamp.to_sec(), running=self.running):
                return self._job()
            self._send(self.outlet.command, self.inbox.stamps())
        elif repeated:
            self._send(self.outlet.command, self.inbox.stamps())
        return None

    def _awaits_readings(self, stamp):
        """Return whether readings up to the odometry's ``stamp`` are still to come, in lockstep."""
        if self.sensors is None or not self.running:
            return False
        begun = stamp.to_sec() if self._begun is None else self._begun
        # From a sensor that connects later than it was read nothing comes while time waits.
        awaited = self.sensors.unconnected() if self._begun is None else ""
        awaited = awaited or self.sensors.awaited(stamp.to_sec(), begun)
        since = time.monotonic() if self._awaiting is None else self._awaiting
        self._awaiting = since if awaited else None
        if awaited and time.monotonic() - since > STILL:
            self._hold(awaited)
        return bool(awaited)

    def _job(self):
        if not self.running:
            if self.lockstep:
                self._send(np.zeros_like(self.outlet.command))
            return None
        now = self._answered.to_sec() if self.lockstep else rospy.get_time()
        # A simulator that was started again begins another run.
        begins = self._begun is None or now < self._acted
        self._acted = now
        since = 0.0 if begins else now - self._begun
        # as a run without ROS counts it
        since = on_steps(since, self.scenario.step) if self.lockstep else since
        # What was missing is there; the law may take its time all the same.
        self._recovers, self.trouble = begins or bool(self.trouble), self.guards.text()
        # Odometry that comes between these lines makes an answer look older than it is, never newer.
        answered, arrived = self.inbox.stamps(), self.inbox.arrived
        pose = self._pose()
        job = Job(self._epoch, pose, self.frame.with_heights(pose), now, since, begins)
        job = job._replace(joints=getattr(self.inbox, "joints", None))
        job = job._replace(answered=answered, arrived=arrived)
        if self.sensors:
            job = job._replace(readings=self.sensors.readings(now if begins else self._begun))
        return job

    def _ask(self, job):
        """Ask the law, and send what the guards let pass of its answer."""
        self._asked = started = time.monotonic()
        try:
            warnings, command = self._asked_law(job)
        except (CallFailed, TimedOut) as error:
            with self._lock:
                self._lose(error)
            return
        finally:
            self._asked = None
        with self._lock:
            self._take(job, warnings, command, time.monotonic() - started)

    def _asked_law(self, job):
        # A law may take long to begin: no robot moves yet.
        patience = self.law_limit if self.outlet.command.any() else SIMULATED_LIMIT
        # What moves among real robots begins with the law, as far as anybody knows.
        begun = scene_time(job.now) if self._simulated else 0.0
        warnings = self.law.begin(job.known, self._meanwhile, begun) if job.begins else None
        limit = max(patience, self.law_limit)
        known = job.known, job.time, limit, self._meanwhile, job.readings
        command = self.law.commands(*known, joints=job.joints)
        return warnings, command

    def _take(self, job, warnings, command, took):
        if job.epoch != self._epoch:  # it was stopped meanwhile, or started again
            if self.lockstep:
                self._send(np.zeros_like(command))
            return
        if job.begins:
            self._warn(warnings)
            self._begun = job.now
        off = self.motors.off()
        command = self.guards.passed(command, job.known, job.now, self.inbox.changed, off)
        if self.outlet.stalled:
            self._stop("{}, {}".format(STALLED, START.format(rospy.resolve_name("~start"))))
            return
        self._compute_time = took
        self._tell_deadlock()
        if self._recovers and not self.guards.stopped:
            rospy.loginfo("pioneer_control: running (%s)", self.law.name)
        self.trouble = self.guards.text()
        self._obeyed.note(self.law, job.now, job.begins)
        self._send(command, job.answered)
        self._latency = time.monotonic() - job.arrived

    def _tell_deadlock(self):
        """Log that the safety filter holds robots still, once for each set of them."""
        held = self.law.state.deadlock
        if held and held != self._held:
            rospy.logwarn("pioneer_control: %s", deadlock_text(held))
        self._held = held

    def _deadlock(self):
        """Return the deadlock in words, a list of one text or none."""
        text = deadlock_text(self.law.state.deadlock) if self.running else ""
        return [text] if text else []

    def _lose(self, error):
        """Stop: the law raised, or did not end."""
        if rospy.is_shutdown():  # which has stopped the robots, and ended the law
            return
        if isinstance(error, TimedOut):
            self.law.end()
            start = START.format(rospy.resolve_name("~start"))
            self._stop("{} ({}), {}".format(STALLED, error, start))
            rospy.logerr("pioneer_control: robots stopped: %s", self.trouble)
        else:
            said = error.said
            said = said if said.startswith(error.kind) else "{}: {}".format(error.kind, said)
            self._stop("{}: {}".format(LAW_FAILED, said.replace("\n", "; ")))
            rospy.logerr("pioneer_control: the law failed\n%s", error.trace)

    def _warn(self, warnings):
        self._warnings = warnings
        for warning in self._warnings:
            rospy.logwarn("pioneer_control: %s", warning)

    def _hold(self, trouble):
        """Stop the robots as long as something is missing."""
        # In lockstep nothing moves before its answer, and zeros would be one.
        moving = bool(np.any(self.outlet.command)) and not self.lockstep
        self.trouble = self.trouble if not self.running else trouble
        if not self.lockstep:
            self._times.forget()  # what passes meanwhile are no missed periods
        if moving:
            self._send(np.zeros_like(self.outlet.command))
        if moving or time.monotonic() - self._reported > REPORT_PERIOD:
            self._reported = time.monotonic()
            text = "robots stopped: " if moving else "waiting: "
            (rospy.logerr if moving else rospy.loginfo)("pioneer_control: %s%s", text, trouble)

    def _watch(self):
        """Stop real robots whose law hangs: not every driver stops them by itself."""
        while not rospy.is_shutdown():
            time.sleep(NAP)
            if self.outlet.shut_if_stalled(max(STALL, 2.0 * self.period)):
                rospy.logerr("pioneer_control: robots stopped: %s", STALLED)

    def _stop(self, reason):
        self.running, self.trouble = False, reason
        self._epoch += 1
        self.motors.forget()
        self.outlet.shut()

    def _send(self, command, answered=None):
        self.outlet.send(command, answered)
        self._sent += 1

    # What is asked of it -------------------------------------------------------------------------

    def remake_law(self):
        """Make a law that was given up anew; ``ValueError`` or ``TimedOut`` where it cannot be."""
        if self.law.lost:
            self.law.remake()
            self._begun = None

    def start(self):
        """Let the robots be driven; return whether they are, and words for it."""
        with self._lock:
            if self._goes_on():
                return True, GOES_ON
            if self.outlet.emergency:
                return False, "emergency stop: release it first"
            silent = self.who_is_silent()
            if silent and not self.resumes:
                return False, silent + ": no robot is to move later by surprise, start again then"
            self._all_received = True  # or it goes on by itself after any silence
            # Robots that are let go on join the others, whose law goes on too.
            self._begun = self._begun if self.running and self.guards.stopped else None
            self.running = True
            self._times.forget()
            self._epoch += 1
            self.outlet.open()
            if self.estimates is not None:
                self.estimates.restart(list(self.frame.jumped()))
            self.frame.accept()
            if self.sensors:
                self.sensors.forget()
            self.motors.enable()
            self.trouble = silent or self.motors.missing()
            self.guards.release(self.frame.with_heights(self._pose()))
            self.trouble = self.trouble or self.guards.text()
            return True, "running"

    def _goes_on(self):
        """Return whether the robots are driven already, with nothing to be released."""
        waits = self.trouble or self.outlet.emergency or self.who_is_silent()
        return self.running and not waits and self._begun is not None

    def stop(self, reason):
        """Stop the robots, until they are started."""
        with self._lock:
            self._stop(reason)

    def set_topology(self, topology):
        """Let the law have another graph; ``ValueError`` if it is not over these robots."""
        self.law.set_topology(topology)
        self._reconfigure.show()

    def _on_shutdown(self):
        self.running = False
        self.outlet.shut()
        self.law.end()
        with contextlib.suppress(OSError, rospy.ROSException):  # the master may have ended before
            self._reconfigure.close()
        time.sleep(FLUSH)

    def _publish_status(self, asks_law=True):
        trouble = self.trouble or self._waited_for()
        if not self._status.is_due(self.running, trouble):
            return
        topology = self.law.state.topology
        refused, refusal = self.frame.refused()
        facts = dict(
            refused=refused,
            refusal=refusal,
            controller=self._id,
            protocol=self.law.name,
            warnings=[*self._warnings, *self._deadlock()],
            directed=topology.directed,
            running=self.running,
            trouble=trouble,
            stale=self._stale(),
            stopped=self.guards.stopped,
            dry_run=self.dry_run,
            period=self.period,
            compute_time=self._compute_time,
            latency=self._latency,
            missed_periods=self._times.missed,
        )
        targets = self._targets() if asks_law else self.law.known_targets
        self._status.publish(facts, self.outlet.command, topology.edges, targets)

    def _stale(self):
        """Return the numbers of the robots of which odometry, or a reading, is not known now."""
        now = rospy.get_time()
        stale = self.frame.stale(now)
        if self.sensors:
            more = {self.law.numbers[row] for row in self.sensors.stale(now)}
            stale = sorted(more.union(stale))
        return stale

    def _waited_for(self):
        """Return for how long the law has been waited for, in words, or ""."""
        asked = self._asked
        waited = 0.0 if asked is None else time.monotonic() - asked
        return "the law has not answered for {:.0f} s".format(waited) if waited > STILL else ""

    def _targets(self):
        pose = self.frame.with_heights(self._pose())
        if self.law.lost or not np.isfinite(pose).all():
            return None
        try:
            return self.law.targets(pose, self.law_limit, self._meanwhile)
        except CallFailed as error:  # a display's places never stop the control
            text = "pioneer_control: targets: %s: %s"
            rospy.logerr_throttle(REPORT_PERIOD, text % (error.kind, error))
        except TimedOut as error:
            with self._lock:
                self._lose(error)
        return None
