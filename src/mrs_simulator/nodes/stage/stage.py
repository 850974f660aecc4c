"""``Stage``: a world of robots behind ROS topics and services."""

import random
import time

import numpy as np
import rospy

from mrs_simulator.core.compiling import in_time, is_chosen
from mrs_simulator.core.fields import counted
from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.core.pacing import Pacer
from mrs_simulator.nodes.stage.lockstep import Lockstep, lockstep_wanted
from mrs_simulator.nodes.stage.odometry_times import OdometryTimes
from mrs_simulator.nodes.stage.parts import make_parts
from mrs_simulator.nodes.stage.presets import PRESETS
from mrs_simulator.nodes.stage.readiness import Readiness
from mrs_simulator.nodes.stage.robot_topics import Frames, Inbox
from mrs_simulator.nodes.stage.round_trips import RoundTrips
from mrs_simulator.nodes.stage.run_length import RunLength
from mrs_simulator.nodes.stage.services import StageServices
from mrs_simulator.nodes.stage.starting import only_stage
from mrs_simulator.nodes.stage.status import named
from mrs_simulator.ros.node import node_parameters as declared
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.node.requests import Requests
from mrs_simulator.ros.node.senders import doubled_text
from mrs_simulator.world.world import World

IDLE = 0.02  # [s] of wall time, the longest nap of the main loop
IDLE_CLOCK = 0.05  # [s] of wall time between clock messages while simulated time stands still
WAIT_REPORT = 5.0  # [s] of wall time between reports on what is waited for


class Stage:
    """Owns the world and the clock; one thread, the main loop, touches them."""

    def __init__(self, scenario, preset="none", real=()):
        """Open the world of ``scenario`` and every topic and service.

        ``preset``: one of ``PRESETS``, or "none"; ``real``: rows of the robots that are real.
        """
        self.preset, preset = preset, PRESETS.get(preset)
        self.scenario = scenario = preset.behind(scenario) if preset else scenario
        timeout = scenario.cmd_vel_timeout
        if is_given(declared.CMD_VEL_TIMEOUT):
            timeout = read(declared.CMD_VEL_TIMEOUT)
        self.world = World.from_scenario(
            scenario._replace(cmd_vel_timeout=timeout),
            watch_period=preset.watch_period if preset else 0.0,
            mirrored=real,
        )
        self.lockstep, self._has_real = None, bool(real)
        if lockstep_wanted(real, scenario.speed):
            self.lockstep = Lockstep(read(declared.LOCKSTEP_TIMEOUT))
        self.pacer = Pacer(read(declared.SPEED, scenario.speed))
        self.paused = read(declared.PAUSED)
        self._services = StageServices(self)
        self._readiness = Readiness()
        self._step = 0
        usual = (preset and preset.odom_rate) or max(50.0, scenario.control.rate)
        self._times = OdometryTimes(self.world, scenario, usual)
        self.round_trips = RoundTrips(self.world.n, self._times.command_period)
        self.is_started = False
        self.steps_asked, self.length = 0, RunLength(self.world)
        self.id, self.run = random.SystemRandom().getrandbits(32), 0
        self.trouble = ""  # who else simulates or drives these robots
        self._reported = time.monotonic()
        self.inbox, self.requests = Inbox(), Requests()
        self.stands_for = {}  # kinds as they were published -> as the scenario has them
        self.frames = Frames(
            read(declared.STAGE_WORLD_FRAME),
            read(declared.STAGE_ODOM_FRAME),
            read(declared.STAGE_BASE_FRAME),
        )
        self.rivals = only_stage()
        self.topics, self._set_commands, self.parts = make_parts(self, preset, real)
        self._follow_team()
        self._services.open()

    def _follow_team(self):
        self.inbox.answers.begin(self.world.n)
        for part in self.parts:
            part.follow_team(self.scenario)

    # The main loop -------------------------------------------------------------------------------

    def spin(self):
        """Run until ROS shuts down."""
        self.topics.publish_clock()
        self._rise()
        self._begin_run()
        while not rospy.is_shutdown():
            self.requests.serve()
            self._heed_rivals()
            self._take_commands()
            if self._may_step():
                self._advance()
            else:
                self._idle()
            self._show()
        self.world.close()

    def _begin_run(self):
        """Publish what is known at the world's present step, and the first odometry."""
        for part in self.parts:
            part.begin_run()
        self._publish_odometry()

    def _show(self):
        for part in self.parts:
            part.show()

    def _rise(self):
        """Let robots take off that begin on the ground; odometry is published from then on."""
        while self.world.flights.rising and not rospy.is_shutdown():
            self.requests.serve()
            if self.paused or self.pacer.wait() > 0.0:
                self._idle_clock()
                continue
            self._publish_state()
            self._move()
            self._step += 1
            self.pacer.stepped(self.world.step_size)
            self.topics.publish_clock()
            self.topics.publish_collisions()
            self.topics.publish_incidents()
            self._show()
        self._times.begun = self._step

    def _idle_clock(self):
        if time.monotonic() - self.topics.clock_sent > IDLE_CLOCK:
            self.topics.publish_clock()
        self._show()
        time.sleep(IDLE if self.paused else min(IDLE, self.pacer.wait()))

    def _may_step(self):
        if not self.is_started:
            self.is_started = self._ready()
            return False
        if self.paused and not self.steps_asked:
            return False
        if self.lockstep and not self.lockstep.may_go_on():
            return False
        if self.length.take_end():  # with the commands of its last moment
            self.paused, self.steps_asked = True, 0
            return False
        return self.paused or self.pacer.wait() == 0.0

    def _ready(self):
        waits = self._readiness.missing(self)
        if waits:
            self._report("waiting for " + " and ".join(waits))
            return False
        for warning in self.scenario.warnings() + self._times.notes():
            rospy.logwarn("stage: %s", warning)
        robots = counted(self.world.n, "robot")
        rospy.loginfo("stage: %s, %s, started", robots, self.scenario.fidelity)
        if self._has_real and self.pacer.speed != 1.0:
            rospy.logwarn("stage: simulated time at speed %g, real robots at 1", self.pacer.speed)
        self.pacer.resume()
        self.round_trips.begin(self.world.n, self._times.command_period)
        return True

    def _heed_rivals(self):
        """Stop all robots while another node simulates or drives them too."""
        doubled = {**self.rivals.found(), **self.inbox.doubled()}
        trouble = doubled_text(doubled) if doubled else ""
        if trouble and not self.trouble:
            rospy.logerr("stage: robots stopped: %s", trouble)
            self.world.commands.stop(range(self.world.n))
        self.trouble = trouble

    def _move(self):
        """Let the world make a step; in real time robots wait for compilation only if that is asked for."""
        with in_time(self.pacer.unhurried and not is_chosen()):
            self.world.step()

    def _take_commands(self):
        rows, commands = self.inbox.take(self.world.n)
        if len(rows):
            for part in self.parts:
                commands = part.taken(rows, commands)
            if self.trouble:
                commands = np.zeros_like(commands)
            self._set_commands(rows, commands)
            if self.lockstep:
                self.lockstep.answered(rows)
                self.round_trips.waited_for(rows)
        answers = self.inbox.answers.take()
        if len(answers[0]):
            self.round_trips.answered(*answers, self._now())

    def _advance(self):
        self._publish_state()
        for part in self.parts:
            part.before_step()
        for part in () if self.trouble else self.parts:
            part.advance()
        self._move()
        self._step += 1
        self.pacer.stepped(self.world.step_size)
        self.steps_asked = max(0, self.steps_asked - 1)
        self.topics.publish_clock()
        self.topics.publish_collisions()
        self.topics.publish_incidents()
        for part in self.parts:
            part.after_step()
        if self._times.ends_period(self._step):
            driven = self.world.commands.commanded & self.world.command.any(axis=1)
            self.round_trips.end_period(self._now(), driven)
        due = self._times.due(self._step)
        if len(due):
            self._publish_odometry(due)

    def _now(self):
        return self.topics.stamp().to_sec()

    def _publish_state(self):
        self.topics.publish_state(self.id, self.run)

    def _idle(self):
        self.pacer.measure()
        for part in self.parts:
            part.idle()
        now = time.monotonic()
        if now - self.topics.clock_sent > IDLE_CLOCK:
            self.topics.publish_clock()
            if self.is_started and self.paused:
                self._publish_state()
            elif not self.is_started and (not self.lockstep or self.lockstep.waiting_for):
                self.topics.publish_odometry()
        if self.lockstep and self.is_started and not self.paused and self.lockstep.overdue():
            self._report_silence()
        if self.paused or not self.is_started or self.lockstep:
            time.sleep(0.001 if self.lockstep and self.is_started and not self.paused else IDLE)
        else:
            time.sleep(min(IDLE, self.pacer.wait()))

    def _publish_odometry(self, rows=None):
        """Publish the odometry of the robots in ``rows``, by default of all."""
        rows = np.arange(self.world.n) if rows is None else rows
        if self.lockstep:
            # Commands to all robots follow from any odometry, and each comes by itself.
            self.lockstep.expect(range(self.world.n))
        self.round_trips.sent(self._now())
        stamp, listed = self.topics.stamp(), rows.tolist()
        for part in self.parts:
            part.publish(stamp)
        self.topics.publish_odometry(rows)
        for part in self.parts:
            part.report(stamp, listed)

    def _report_silence(self):
        rospy.logerr(
            "stage: no command from %s within %g s of the odometry at %.3f s; simulated time waits",
            named(self.lockstep.waiting_for),
            self.lockstep.timeout,
            self.world.time,
        )
        # Who has answered may have done so to earlier odometry, and have lost the newest; and whoever
        # waits for a reading that is lost, or that a reset has put off, would wait for ever.
        for part in self.parts:
            part.repeat()
        self.topics.publish_odometry()

    def _report(self, text):
        if time.monotonic() - self._reported > WAIT_REPORT:
            self._reported = time.monotonic()
            rospy.loginfo("stage: %s", text)

    def after_change(self):
        """Begin anew with the world's robots, which were changed or put back."""
        self.run += 1
        self._follow_team()
        spare_garbage_collection(anew=True)
        # What was said to the robots before is not meant for these.
        self.inbox.take(self.world.n)
        self._times.begin(self._step)
        self.round_trips.begin(self.world.n, self._times.command_period)
        # One step at rest gives the new poses a stamp of their own: the clock never stands or goes
        # back between two different states.
        self.world.step()
        self.world.contacts.take()
        self.world.faults.take()
        self.topics.publish_clock()
        self._begin_run()
