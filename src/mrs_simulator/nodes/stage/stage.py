"""``Stage``: a world of robots behind ROS topics and services."""

import random
import time

import numpy as np
import rospy

from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.core.pacing import Pacer
from mrs_simulator.nodes.stage.arm_topics import ArmTopics
from mrs_simulator.nodes.stage.ignored_axes import Unobeyed
from mrs_simulator.nodes.stage.lockstep import Lockstep, lockstep_wanted
from mrs_simulator.nodes.stage.map_topics import MapTopics
from mrs_simulator.nodes.stage.mirror import Mirror, RealTopics
from mrs_simulator.nodes.stage.odometry_times import OdometryTimes
from mrs_simulator.nodes.stage.parts import parts_of
from mrs_simulator.nodes.stage.presets import PRESETS
from mrs_simulator.nodes.stage.readiness import Readiness
from mrs_simulator.nodes.stage.robot_topics import Frames, Inbox, RobotTopics
from mrs_simulator.nodes.stage.round_trips import RoundTrips
from mrs_simulator.nodes.stage.scenario_topic import ScenarioTopic
from mrs_simulator.nodes.stage.sensor_topics import SensorTopics
from mrs_simulator.nodes.stage.services import StageServices
from mrs_simulator.nodes.stage.starting import only_stage
from mrs_simulator.nodes.stage.status import StatusTopic, named
from mrs_simulator.nodes.stage.window import Window
from mrs_simulator.nodes.stage.world_topics import WorldTopics
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
        self._preset = preset = PRESETS.get(preset)
        self.scenario = scenario = preset.behind(scenario) if preset else scenario
        timeout = scenario.cmd_vel_timeout
        if is_given(declared.CMD_VEL_TIMEOUT):
            timeout = read(declared.CMD_VEL_TIMEOUT)
        self.world = World.from_scenario(
            scenario._replace(cmd_vel_timeout=timeout),
            watch_period=preset.watch_period if preset else 0.0,
            mirrored=real,
        )
        self.mirror = Mirror(real, scenario)
        self.lockstep = None
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
        self.steps_asked = 0
        self.id, self.run = random.SystemRandom().getrandbits(32), 0
        self.trouble = ""  # who else simulates or drives these robots
        self._reported = time.monotonic()
        self.inbox, self.unobeyed = Inbox(), Unobeyed()
        self.requests = Requests()
        self.frames = Frames(
            read(declared.STAGE_WORLD_FRAME),
            read(declared.STAGE_ODOM_FRAME),
            read(declared.STAGE_BASE_FRAME),
        )
        self.rivals = only_stage()
        self.sensors = SensorTopics(self.frames, self.mirror.rows)
        self.topics = WorldTopics(
            *(self.world, self.frames, self.inbox, self.mirror.rows),
            topics_of=self._topics_of,
            fixed=self.sensors.fixed_frames,
        )
        self.arms = ArmTopics(self.world, self.inbox)
        self.drivers = preset and preset.drivers(self.world, self.requests, absent=real)
        self.parts = parts_of(self, real)
        self.status = StatusTopic(self)
        self.scenario_topic = ScenarioTopic()
        self.unobeyed.begin(self.world.team)
        self._follow_team()
        self._map = MapTopics(scenario, self.frames.world, self.topics.stamp())
        self._services.open()
        self.window = Window(self.world)

    def _follow_team(self):
        self.inbox.answers.begin(self.world.n)
        self.sensors.follow_team(self.scenario, self.world)
        is_wheel = self._published_odometry() == "wheel"
        self.topics.follow_team(self.scenario.odometry_errors if is_wheel else None)
        for part in self.parts:
            part.follow_team()
        self.scenario_topic.publish(self.scenario)
        spare_garbage_collection()

    def _topics_of(self, row):
        if row in self.mirror.rows:
            return RealTopics(row, self.inbox, self.mirror)
        return RobotTopics(row, self.inbox, self._published_odometry(), self.frames)

    def _published_odometry(self):
        """Return whose odometry robots publish: "world", "wheel", or of a driver, "rosaria"."""
        return (self._preset and self._preset.odometry) or self.scenario.odometry

    # The main loop -------------------------------------------------------------------------------

    def spin(self):
        """Run until ROS shuts down."""
        self.topics.publish_clock()
        self._rise()
        self.sensors.publish(self.world)
        self._publish_odometry()
        while not rospy.is_shutdown():
            self.requests.serve()
            self._heed_rivals()
            self._take_commands()
            if self._may_step():
                self._advance()
            else:
                self._idle()
            self.window.show()
        self.world.close()

    def _rise(self):
        """Let robots take off that begin on the ground; odometry is published from then on."""
        while self.world.flights.rising and not rospy.is_shutdown():
            self.requests.serve()
            if self.paused or self.pacer.wait() > 0.0:
                self._idle_clock()
                continue
            self._publish_state()
            self.world.step()
            self._step += 1
            self.pacer.stepped(self.world.step_size)
            self.topics.publish_clock()
            self.topics.publish_collisions()
            self.topics.publish_incidents()
            self.status.publish()
            self.window.show()
        if self._step:
            self._times.begun = self._step
            self.sensors.begin(self.world)

    def _idle_clock(self):
        if time.monotonic() - self.topics.clock_sent > IDLE_CLOCK:
            self.topics.publish_clock()
        self.status.publish()
        time.sleep(IDLE if self.paused else min(IDLE, self.pacer.wait()))

    def _may_step(self):
        if not self.is_started:
            self.is_started = self._ready()
            return False
        if self.paused and not self.steps_asked:
            return False
        if self.lockstep and self.lockstep.waiting_for:
            return False
        return self.paused or self.pacer.wait() == 0.0

    def _ready(self):
        waits = self._readiness.missing(self)
        if waits:
            self._report("waiting for " + " and ".join(waits))
            return False
        for warning in self.scenario.warnings() + self._times.notes():
            rospy.logwarn("stage: %s", warning)
        rospy.loginfo("stage: %d robots, %s, started", self.world.n, self.scenario.fidelity)
        if self.mirror.rows and self.pacer.speed != 1.0:
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

    def _take_commands(self):
        rows, twists = self.inbox.take(self.world.n)
        if len(rows):
            if self.drivers:
                twists = self.drivers.taken(rows, twists)
            commands = self.arms.joined(rows, self.unobeyed.taken(rows, twists))
            if self.trouble:
                commands = np.zeros_like(commands)
            (self.drivers.command if self.drivers else self.world.set_commands)(rows, commands)
            if self.lockstep:
                self.lockstep.answered(rows)
        answers = self.inbox.answers.take()
        if len(answers[0]):
            self.round_trips.answered(*answers, self._now())

    def _advance(self):
        self._publish_state()
        self.mirror.place(self.world)
        for part in () if self.trouble else self.parts:
            part.advance()
        self.world.step()
        self._step += 1
        self.pacer.stepped(self.world.step_size)
        self.steps_asked = max(0, self.steps_asked - 1)
        self.topics.publish_clock()
        self.topics.publish_collisions()
        self.topics.publish_incidents()
        self.sensors.publish(self.world)  # whoever waits for odometry has received them then
        if self._times.ends_period(self._step):
            driven = self.world.commands.commanded & self.world.command.any(axis=1)
            self.round_trips.end_period(self._now(), driven)
        due = self._times.due(self._step)
        if len(due):
            self._publish_odometry(due)
        self.status.publish()

    def _now(self):
        return self.topics.stamp().to_sec()

    def _publish_state(self):
        self.topics.publish_state(self.id, self.run)

    def _idle(self):
        self.pacer.measure()
        self.sensors.publish(self.world)
        now = time.monotonic()
        if now - self.topics.clock_sent > IDLE_CLOCK:
            self.topics.publish_clock()
            self.mirror.place(self.world)  # real robots know no pause
            if self.is_started and self.paused:
                self._publish_state()
            elif not self.is_started and (not self.lockstep or self.lockstep.waiting_for):
                self.topics.publish_odometry()
        if self.lockstep and self.is_started and not self.paused and self.lockstep.overdue():
            self._report_silence()
        self.status.publish()
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
        for part in self.parts:
            part.publish(self.topics.stamp())
        self.topics.publish_odometry(rows)
        if self.drivers:
            self.drivers.report(self.topics.stamp(), rows.tolist())

    def _report_silence(self):
        rospy.logerr(
            "stage: no command from %s within %g s of the odometry at %.3f s; simulated time waits",
            named(self.lockstep.waiting_for),
            self.lockstep.timeout,
            self.world.time,
        )
        # Who has answered may have done so to earlier odometry, and have lost the newest; and whoever
        # waits for a reading that is lost, or that a reset has put off, would wait for ever.
        self.sensors.repeat()
        self.topics.publish_odometry()

    def _report(self, text):
        if time.monotonic() - self._reported > WAIT_REPORT:
            self._reported = time.monotonic()
            rospy.loginfo("stage: %s", text)

    def after_change(self):
        """Begin anew with the world's robots, which were changed or put back."""
        self.run += 1
        self.mirror.begin_at(self.scenario.poses)
        self._follow_team()
        # What was said to the robots before is not meant for these.
        self.inbox.take(self.world.n)
        self.status.begin()
        self.unobeyed.begin(self.world.team)
        self._times.begin(self._step)
        self.round_trips.begin(self.world.n, self._times.command_period)
        # One step at rest gives the new poses a stamp of their own: the clock never stands or goes
        # back between two different states.
        self.world.step()
        self.world.contacts.take()
        self.world.faults.take()
        self.topics.publish_clock()
        self.sensors.begin(self.world)
        self.sensors.publish(self.world)
        self._publish_odometry()
