"""A bench for one trial: everything is started, a fault is made, and the motion judged."""

import os
import resource
import signal
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))

from motion import LIMITS, REST, Motion  # noqa: E402
from ros_fixtures import PATIENCE, Ros, log_of  # noqa: E402
from table import (  # noqa: E402
    AIR,
    BEGINS_AGAIN,
    COMES_BACK,
    ENDS,
    FREE,
    GOES_ON,
    LANDS,
    LOCKSTEP,
    STANDS,
    STANDS_THEN_GOES_ON,
    STOPS,
    WALL,
    WATER,
)

SCENARIO = """
poses: [[0, 0, 0], [0, 3, 0]]
duration: 1000
control: {protocol: forward.py:Forward, rate: 20}
"""
TEAMS = {  # by mode, Pioneers in all others
    AIR: "model: crazyflie2\naltitude: [0.5, 0.7]\nfidelity: dynamic\n",
    WATER: "model: heron\nfidelity: dynamic\n",
}
PIONEERS = "limits: {v_max: 0.25, omega_max: 1.0, v_accel: 0.3, omega_accel: 1.0}\n"
RELAYED = ("delay", "duplicate", "reorder", "drop half", "drop all", "no number", "no height")
SINKING = 0.1  # [m] by which a robot that hovers may lose or win height
FALLING = 0.4  # [m/s] beyond which one that comes down falls
ROBOTS = (1, 2)
STANDING = 2.0  # [s] of wall time for which it is watched that nothing moves while time stands
STOPPED = "robots stopped: "  # in the log of a controller; real ones then wait to be started
AGAIN = 2.0  # [s] of wall time between two attempts
LASTS = 1.8  # [s] of the robots' time that a fault lasts which they must bear
LATE = 6.0  # [s] the same of a delay of 2 s, whose begin is a silence
SLOWEST = 4  # [-] times the usual patience, for simulated time that is slow on a busy machine
STARVED = (0.02, 0.18)  # [s] of wall time: runs, is stopped, and again
CLOCK = """
import rospy, time
from rosgraph_msgs.msg import Clock
rospy.init_node("jump", anonymous=True)
publisher = rospy.Publisher("/clock", Clock, queue_size=10)
time.sleep(1.0)
for _ in range(20):
    publisher.publish(Clock(rospy.Time(100000)))
    time.sleep(0.02)
"""


class Failed(AssertionError):
    """What the robots must do, and did not."""


class Bench:
    """The nodes of one trial."""

    def __init__(self, row, directory):
        """Start a master, and write what the nodes need to ``directory``."""
        self.row, self.directory = row, directory
        with open(os.path.join(directory, "scenario.yaml"), "w") as file:
            file.write(SCENARIO + TEAMS.get(row.mode, PIONEERS))
        with open(os.path.join(HERE, "forward.py")) as law:
            text = law.read()
        with open(os.path.join(directory, "forward.py"), "w") as file:
            file.write(text)
        self.scenario = os.path.join(directory, "scenario.yaml")
        self.track = os.path.join(directory, "motion.jsonl")
        open(self.track, "w").close()
        self.ros = Ros(directory)
        self.limit = LIMITS.get(row.mode, LIMITS[None])
        self._count, self._starving, self._started_again = 0, None, 0.0
        self.node = {"master": self.ros.master}

    def _start(self, name, command):
        self._count += 1
        return self.ros.start("{}_{}".format(name, self._count), command)

    def _run(self, script, *arguments):
        self._count += 1
        return self.ros.node(script, *arguments, name="{}_{}".format(script, self._count))

    def start(self):
        """Start everything and wait until the robots drive."""
        wall = self.row.mode == WALL
        if wall:
            self._set_wall_time()
        self.node["stage" if not wall else "driver"] = self._start_robots()
        topics = ["/robot{}/RosAria/pose".format(k) for k in ROBOTS] if wall else []
        self._start(
            "motion", [sys.executable, os.path.join(HERE, "motion.py"), self.track, *topics]
        )
        self.relay = self._start_relay()
        self.node["control"] = self._start_control()
        if self.row.victim == "recorder":
            self.node["recorder"] = self._start_recorder()
        if self.row.victim == "GUI":
            self.node["GUI"] = self._start_gui()
        self.wait("the robots drive", self._drive)
        if self.row.victim == "recorder":
            self.wait("rows", lambda: self._recorded() > 1000)

    def _drive(self):
        """Return whether the robots drive; real ones that a stall has stopped before are started again."""
        stopped = self.row.mode == WALL and STOPPED in log_of(self.node["control"])
        if stopped and time.monotonic() - self._started_again > AGAIN:
            self.ros.call("rosservice", "call", "/pioneer_control/start")
            self._started_again = time.monotonic()
        return self.motion().moves()

    def _set_wall_time(self):
        import xmlrpc.client

        xmlrpc.client.ServerProxy(self.ros.uri).setParam("/test", "/use_sim_time", False)

    def _start_robots(self):
        if self.row.mode == WALL:
            self._drivers = [self._start_driver(number) for number in ROBOTS]
            return self._drivers[0]
        # A stage that says its odometry again at once soon has an answer to it.
        wait = 0.05 if self.relay_wanted else 0.3
        lockstep = ["_lockstep:=true", "_lockstep_timeout:={}".format(wait)]
        lockstep = lockstep if self.row.mode == LOCKSTEP else []
        return self._run("stage", "--scenario", self.scenario, "_speed:=1", *lockstep)

    def _start_driver(self, number):
        program = os.path.join(os.path.dirname(HERE), "rosaria_robot.py")
        names = ["__ns:=/robot{}".format(number), "__name:=RosAria"]
        return self._start("driver", [sys.executable, program, *names])

    def _start_control(self):
        arguments = ["--scenario", self.scenario, "_team_topics:=never"]
        if self.row.mode == LOCKSTEP:
            arguments.append("_lockstep:=true")
        odometry, command = self._patterns()
        if self.row.mode == WALL:
            arguments += ["_frame_source:=scenario", "_autostart:=true"]
        arguments += ["_odom_topic:=" + odometry, "_cmd_vel_topic:=" + command]
        return self._run("pioneer_control", *arguments)

    def _patterns(self):
        """Return the patterns of the topics that the control node reads and writes."""
        wall = self.row.mode == WALL
        odometry = "/robot{}/RosAria/pose" if wall else "/robot{}/odom"
        command = "/robot{}/RosAria/cmd_vel" if wall else "/robot{}/cmd_vel"
        if self.relay_wanted:
            disturbed = "/disturbed/robot{}"
            if self.row.victim == "control":
                return odometry, disturbed
            return disturbed, command
        return odometry, command

    @property
    def relay_wanted(self):
        """Return whether the fault is one of a link."""
        return self.row.fault in RELAYED

    def _start_relay(self):
        if not self.relay_wanted:
            return None
        wall = self.row.mode == WALL
        kind, pairs = "Odometry", []
        for number in ROBOTS:
            name = "/robot{}/RosAria/pose" if wall else "/robot{}/odom"
            pair = [name.format(number), "/disturbed/robot{}".format(number)]
            if self.row.victim == "control":
                kind, name = "Twist", "/robot{}/RosAria/cmd_vel" if wall else "/robot{}/cmd_vel"
                pair = ["/disturbed/robot{}".format(number), name.format(number)]
            pairs += pair
        relay = os.path.join(HERE, "relay.py")
        return self._start("relay", [sys.executable, relay, self.row.fault, kind, *pairs])

    def _start_recorder(self):
        self.out = os.path.join(self.directory, "out{}".format(self._count))
        return self._run("record", "--scenario", self.scenario, "--out", self.out)

    def _start_gui(self):
        self.ros.environment["QT_QPA_PLATFORM"] = "offscreen"
        return self._run("mrs_gui", "--scenario", self.scenario)

    def _recorded(self):
        path = os.path.join(self.out, "run.csv")
        return os.path.getsize(path) if os.path.exists(path) else 0

    # The fault -----------------------------------------------------------------------------------

    def fault(self):
        """Make the row's fault; return the wall time [s] from which it is there."""
        kind, victim = self.row.fault, self.node[self.row.victim]
        if self.relay:
            self.relay.send_signal(signal.SIGUSR1)
        elif kind == "freeze":
            victim.send_signal(signal.SIGSTOP)
        elif kind in ("kill", "restart"):
            victim.kill()
            victim.wait()
            if kind == "restart" and self.row.expected not in (COMES_BACK, STANDS_THEN_GOES_ON):
                self._restart()
        elif kind == "starve":
            self._starving = threading.Event()
            threading.Thread(target=self._starve, args=(victim, self._starving)).start()
        elif kind == "full disk":
            size = self._recorded()
            resource.prlimit(victim.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
        elif kind == "clock jump":
            self.ros.python(CLOCK)
        return time.monotonic()

    def repair(self):
        """Undo the fault, as far as it can be."""
        kind, victim = self.row.fault, self.node[self.row.victim]
        if self.relay:
            self.relay.send_signal(signal.SIGUSR2)
        elif kind == "freeze":
            victim.send_signal(signal.SIGCONT)
        elif kind == "restart" and victim.poll() is not None:
            self._restart()
        elif kind == "starve":
            self._starving.set()
        elif kind == "full disk":
            unlimited = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
            resource.prlimit(victim.pid, resource.RLIMIT_FSIZE, unlimited)
        return time.monotonic()

    def _restart(self):
        starts = {
            "stage": self._start_robots,
            "control": self._start_control,
            "recorder": self._start_recorder,
            "GUI": self._start_gui,
            "master": self._start_master,
            "driver": lambda: self._start_driver(ROBOTS[0]),
        }
        self.node[self.row.victim] = starts[self.row.victim]()

    def _start_master(self):
        port = self.ros.uri.rpartition(":")[2]
        return self._start("master", ["rosmaster", "--core", "-p", port])

    @staticmethod
    def _starve(victim, end):
        while not end.is_set() and victim.poll() is None:
            time.sleep(STARVED[0])
            victim.send_signal(signal.SIGSTOP)
            time.sleep(STARVED[1])
            victim.send_signal(signal.SIGCONT)

    # What the robots do --------------------------------------------------------------------------

    def motion(self):
        """Return the robots' motion so far."""
        return Motion(self.track)

    def wait(self, what, condition, limit=PATIENCE):
        """Wait until ``condition`` holds; ``Failed`` after ``limit`` [s] of wall time."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise Failed("not within {:g} s: {}".format(limit, what))
            time.sleep(0.05)

    def trial(self):
        """Make the fault and judge what the robots do; ``Failed`` if it is not what they must."""
        begin, expected = self.fault(), self.row.expected
        if expected in (STOPS, COMES_BACK, LANDS):
            self._stopped(begin)
        elif expected in (STANDS, STANDS_THEN_GOES_ON):
            self._stand(begin)
        elif expected == ENDS:
            time.sleep(STANDING)
            if len(self.motion().since(begin + 1.0).stamp):
                raise Failed("there are states without a stage")
        elif expected == BEGINS_AGAIN:
            self.wait("a new world", lambda: len(self.motion().lives()) > 1)
            self._lasts(self.motion().wall[-1])
        else:
            self._lasts(begin)
        if expected == GOES_ON and not self.motion().moves():
            raise Failed("the robots do not go on")
        if expected == LANDS:
            self.wait("all have landed", lambda: self.motion().landed())
        end = self.repair()
        if expected in (COMES_BACK, STANDS_THEN_GOES_ON):
            self.wait("the robots go on", lambda: self.motion().since(end).moves())
        elif expected == GOES_ON:
            self.wait("the robots go on after it", lambda: self.motion().since(end).moves())
        motion = self.motion()
        if (self.row.fault, self.row.victim) == ("restart", "driver"):
            motion = motion.until(begin)  # then its odometry begins at zero again
        too_fast = motion.too_fast()
        if too_fast:
            raise Failed("impossible motion: " + too_fast)
        if self.row.mode == AIR:
            self._kept_up(motion)
        if self.row.fault == "full disk":
            self._recorded_on()

    def _kept_up(self, motion):
        """See that nobody fell, and nobody left its height that was not to land."""
        if motion.fall() > FALLING:
            raise Failed("a robot came down at {:.2f} m/s".format(motion.fall()))
        if self.row.expected != LANDS and motion.climb() > SINKING:
            raise Failed("a robot was {:.2f} m from its height".format(motion.climb()))

    def _lasts(self, begin):
        """Wait until the robots' time has gone on by ``LASTS`` since ``begin`` [s] of wall time."""

        def over():
            parts = self.motion().since(begin).lives()
            lasts = LATE if self.row.fault == "delay" and self.row.mode == FREE else LASTS
            return sum(part.span for part in parts) > lasts

        # In lockstep each period of a disturbed link waits for what the stage says again.
        self.wait("the robots' time goes on", over, SLOWEST * PATIENCE)

    def _stopped(self, begin):
        """Wait until the robots' time, or a dead robot's silence, is over, and see that all stand."""
        end = time.monotonic() + PATIENCE
        stamps = self.motion().until(begin).stamp
        while time.monotonic() < end:
            since = self.motion().after(stamps[-1] + self.limit)
            if since.span > 1.0 or time.monotonic() > begin + self.limit + 5.0:
                break
            time.sleep(0.05)
        creep = self.motion().after(stamps[-1] + self.limit).creep()
        if creep > REST:
            text = "{:g} s after the fault a robot still moves: {:.3f} m"
            raise Failed(text.format(self.limit, creep))

    def _stand(self, begin):
        time.sleep(1.0 + STANDING)
        creep = self.motion().since(begin + 1.0).creep()
        if creep > 0.001:
            raise Failed("a robot moves while time should stand: {:.3f} m".format(creep))

    def _recorded_on(self):
        """See that the recorder lost nothing that it could keep, and that what it has is whole."""
        path, size = os.path.join(self.out, "run.csv"), self._recorded()
        self.wait("rows again", lambda: self._recorded() > size)
        with open(path) as file:
            lines = file.readlines()
        if {line.count(",") for line in lines} != {8}:
            raise Failed("{}: rows that are not whole".format(path))

    def close(self):
        """End everything."""
        if self._starving:
            self._starving.set()
        for process in self.ros.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
        self.ros.close()


def run(row):
    """Run the trial ``row``; return "" if the robots did what they must, else what they did."""
    with tempfile.TemporaryDirectory(prefix="mrs_faults_") as directory:
        bench = Bench(row, directory)
        try:
            bench.start()
            bench.trial()
        except Failed as failed:
            return str(failed)
        finally:
            bench.close()
    return ""
