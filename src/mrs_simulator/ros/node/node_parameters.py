"""The parameters of the nodes, each declared once: what reads, checks, lists and documents them uses this.

``python3 -m mrs_simulator.ros.node.node_parameters docs/nodes.md`` brings that page's tables up to date.
"""

import re
import sys
from typing import Any, NamedTuple, Optional, Tuple

from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH
from mrs_simulator.scenario.control import RATES
from mrs_simulator.scenario.scenario import MOST_ROBOTS

# Kinds.  A pattern has one {} for the robot's number; for each robot: a number, or one for each.
NUMBER, FLAG, TEXT, PATTERN = "a number", "true or false", "a text", "a pattern"
NUMBERS, FOR_EACH_ROBOT, ROBOTS = "numbers", "a number for each robot", "robots' numbers"


class NodeParameter(NamedTuple):
    """A parameter of a node: its name on the server, below the node's, and what values it may have."""

    name: str
    kind: str
    default: Any  # None where a rule gives it, or nothing does
    meaning: str  # in Markdown
    unit: str = ""
    rule: str = ""  # that gives the default, in words
    low: Optional[float] = None
    above: Optional[float] = None
    high: Optional[float] = None
    choices: Tuple[str, ...] = ()
    size: int = 0  # of NUMBERS
    sizes: Tuple[int, ...] = ()  # of NUMBERS: others that are allowed, too

    def wanted(self):
        """Return in words what values are allowed."""
        if self.kind == TEXT and self.choices:
            return "one of " + ", ".join(self.choices)
        if self.kind == PATTERN:
            return "one {} for the robot's number"
        if self.kind == NUMBERS:
            return "{} numbers".format(" or ".join(map(str, (self.size, *self.sizes))))
        bounds = [
            "{} {:g}".format(word, bound)
            for word, bound in (("of at least", self.low), ("above", self.above))
            if bound is not None
        ]
        if self.high is not None:
            bounds.append("{}at most {:g}".format("" if bounds else "of ", self.high))
        text = "{} {}".format(self.kind, " and ".join(bounds)).strip()
        return text + "".join(", or " + choice for choice in self.choices)

    def default_text(self):
        """Return the default in words, with its unit."""
        if self.rule:
            return self.rule
        if self.default in (None, ""):
            return "none"
        value = str(self.default).lower() if self.kind == FLAG else self.default
        value = "{:g}".format(value) if isinstance(value, float) else str(value)
        quoted = "`{}`".format(value) if self.kind in (TEXT, PATTERN) else value
        return "{} {}".format(quoted, self.unit).strip()


SPEED = NodeParameter(
    "speed",
    NUMBER,
    None,
    "simulated over wall time, 0: as fast as possible",
    "",
    "the scenario's",
    0.0,
)
PAUSED = NodeParameter("paused", FLAG, False, "start paused")
PRESET = NodeParameter(
    "preset",
    TEXT,
    "none",
    "`rosaria`, `crazyswarm`, `ardrone`, `heron`, `wamv`: see below; also an argument",
    choices=("none", "rosaria", "crazyswarm", "ardrone", "heron", "wamv"),
)
TAKEOFF_HEIGHT = NodeParameter(
    "takeoff_height", NUMBER, 1.0, "to which `/robotN/takeoff` lets a robot rise", "m", above=0.0
)
ODOM_RATE = NodeParameter(
    "odom_rate",
    NUMBER,
    None,
    "of odometry and tf; where the scenario gives a rate, which may be each kind's own, this one may not "
    "be given",
    "Hz",
    "the scenario's `odometry_rate`, else 50 Hz, or `control.rate` where that is higher; preset "
    "`rosaria`: 10 Hz",
    above=0.0,
)
CMD_VEL_TIMEOUT = NodeParameter(
    "cmd_vel_timeout",
    NUMBER,
    None,
    "each robot's watchdog",
    "s",
    "the scenario's, 0.6 s",
    above=0.0,
)
LOCKSTEP = NodeParameter(
    "lockstep",
    FLAG,
    False,
    "advance only when every robot has been commanded since the last odometry; `auto`, which "
    "simulation.launch says: where all robots are simulated and the speed is not 1",
    choices=("auto",),
)
LOCKSTEP_TIMEOUT = NodeParameter(
    "lockstep_timeout",
    NUMBER,
    5.0,
    "of wall time, after which the silent robots are named, and odometry and readings are published again: "
    "none that is lost, or that a reset puts off, stalls a run",
    "s",
    above=0.0,
)
WAIT_FOR_CONTROL = NodeParameter(
    "wait_for_control",
    FLAG,
    False,
    "stand at time zero until every robot's commands are connected",
)
MOST_BY_SERVICE = NodeParameter(
    "most_robots",
    NUMBER,
    1000,
    "largest team that `stage/set_team` takes; the scenario's own may be larger",
    low=1,
    high=MOST_ROBOTS,
)
WAIT_FOR_RECORDERS = NodeParameter(
    "wait_for_recorders",
    NUMBER,
    0,
    "stand at time zero until so many subscribe to `stage/state`",
    low=0,
)
STAGE_WORLD_FRAME = NodeParameter("world_frame", TEXT, "world", "of the transforms it publishes")
STAGE_ODOM_FRAME = NodeParameter(
    "odom_frame", PATTERN, "robot{}/odom", "`{}` is the robot's number"
)
STAGE_BASE_FRAME = NodeParameter("base_frame", PATTERN, "robot{}/base_link", "likewise")
TRUE_POSE_TOPIC = NodeParameter(
    "pose_topic",
    PATTERN,
    "",
    "pattern, `/robot{}/pose`: the true poses of the simulated robots as geometry_msgs/PoseStamped at "
    "`~odom_rate`, to rehearse `_frame_source:=external`",
)
VIEW = NodeParameter("view", FLAG, False, "pybullet's own window (needs a display)")

RATE = NodeParameter(
    "rate", NUMBER, None, "of commands", "Hz", "the scenario's, 50 Hz", RATES[0], high=RATES[1]
)
SATURATION = NodeParameter(
    "saturation",
    TEXT,
    None,
    "`robot`, `team`, `none`: who is slowed where a limit is reached",
    rule="the scenario's, `robot`",
    choices=("robot", "team", "none"),
)
AUTOSTART = NodeParameter(
    "autostart",
    FLAG,
    None,
    "begin to control at once, else when `start` is called; with real robots the node says with which "
    "`preflight` they are checked first",
    rule="true, false if any robot is real",
)
ONE_FOR_EACH = LOCKSTEP._replace(
    meaning="one command for each odometry; `auto` as for the stage, by `~speed`, else the scenario's speed"
)
ODOM_TIMEOUT = NodeParameter(
    "odom_timeout",
    NUMBER,
    0.5,
    "a robot silent for longer, a real one in wall time, is named, and all are stopped; a message older "
    "than this is refused, below",
    "s",
    above=0.0,
)
ODOM_FRAME = NodeParameter(
    "odom_frame",
    TEXT,
    "",
    "the frame in which odometry is published, `robot{}/odom`; another is refused (not with `tf` and "
    "`external`)",
    rule='any with "odom" in it, or none',
)
ODOM_TOPIC = NodeParameter(
    "odom_topic",
    PATTERN,
    "/robot{}/odom",
    "`{}` is the robot's number; remapping the names will do as well",
)
CMD_VEL_TOPIC = NodeParameter("cmd_vel_topic", PATTERN, "/robot{}/cmd_vel", "likewise")
SENSOR_TOPIC = NodeParameter(
    "sensor_topic",
    PATTERN,
    "/robot{}/*",
    "of the sensors that the law asks for: `{}` is the robot's number, `*` the sensor's name; RosAria's "
    "are `/robot{}/RosAria/*`",
)
SENSOR_TIMEOUT = NodeParameter(
    "sensor_timeout",
    NUMBER,
    0.5,
    "beyond a sensor's latency: one silent for longer, and for 2.5 of its periods, is named, and all "
    "robots are stopped",
    "s",
    above=0.0,
)
FRAME_SOURCE = NodeParameter(
    "frame_source",
    TEXT,
    None,
    "where common poses come from, below",
    rule="`odometry`; with odometry `wheel`: `scenario`",
    choices=("odometry", "scenario", "first", "tf", "external"),
)
POSE_TOPIC = NodeParameter("pose_topic", PATTERN, "/robot{}/pose", "of `external`")
POSE_TIMEOUT = NodeParameter("pose_timeout", NUMBER, 0.5, "of `external` and `tf`", "s", above=0.0)
WORLD_FRAME = NodeParameter("world_frame", TEXT, "world", "of `tf`")
BASE_FRAME = NodeParameter("base_frame", PATTERN, "robot{}/base_link", "of `tf`")
REAL = NodeParameter(
    "real",
    ROBOTS,
    "",
    "numbers of the real robots, `2,4`, on whom the defaults below depend; they rule lockstep out",
    rule="in simulated time none, else all",
)
RESUME = NodeParameter(
    "resume",
    FLAG,
    None,
    "go on by itself after a silence; false: only when `start` is called",
    rule="true, false if any robot is real",
)
STUCK_TIME = NodeParameter(
    "stuck_time",
    NUMBER,
    2.0,
    "a robot commanded to move, 0.05 m/s or 0.1 rad/s at least, that does less than a fifth of it for so "
    "long is stopped; given, it holds for all (not meant for `point_mass`, which knows no heading); "
    "0: no bound",
    "s",
    "2 s, no bound for simulated robots",
    0.0,
)
FROZEN_TIME = NodeParameter(
    "frozen_time",
    NUMBER,
    0.5,
    "a robot that is commanded to move by more than 20 mm or 2 degrees in this time, while its odometry "
    "says the same to the bit, is stopped: a driver without its robot repeats the last pose; 0: no bound",
    "s",
    "0.5 s, no bound for simulated robots",
    0.0,
)
MAX_JUMP = NodeParameter(
    "max_jump",
    NUMBER,
    0.3,
    "given, it holds for all; and 1.5 times what its top speed explains: a robot farther from where it "
    "was received last has jumped, below; 0: any jump is followed",
    "m, rad",
    "0.3 m and rad, no bound for simulated robots",
    0.0,
)
GEOFENCE = NodeParameter(
    "geofence",
    NUMBERS,
    None,
    "`[x_min, y_min, x_max, y_max]` in m: a robot outside, or that would be before it stands, is stopped; "
    "of robots that fly it may have `z_min, z_max` besides",
    "m",
    size=4,
    sizes=(6,),
)
MIN_DISTANCE = NodeParameter(
    "min_distance",
    NUMBER,
    0.0,
    "two robots whose centres are nearer, or would be before they stand, are both stopped",
    "m",
    low=0.0,
)
V_MAX = NodeParameter(
    "v_max",
    FOR_EACH_ROBOT,
    None,
    "lower top speeds for first trials, in m/s: a number for all, or one for each robot, "
    "`[0.1, 0.2, 0.2, 0.2]`; paths keep their shape. The law, preflight and record know the highest",
    "m/s",
    "the scenario's",
    above=0.0,
)
OMEGA_MAX = V_MAX._replace(name="omega_max", meaning="likewise, in rad/s", unit="rad/s")
TEAM_TOPICS = NodeParameter(
    "team_topics",
    TEXT,
    "auto",
    "`always`, `never`: use `stage/odometry` and `stage/command` instead of each robot's topics; `auto`: "
    "from 50 simulated robots on, and with [arms](manipulators.md#over-ros), if a stage offers them",
    choices=("auto", "always", "never"),
)
ENABLE_MOTORS = NodeParameter(
    "enable_motors",
    PATTERN,
    "",
    "pattern of a std_srvs/Empty service, `/robot{}/RosAria/enable_motors`, or of a topic followed by its "
    "type, std_msgs/Bool or p2os_msgs/MotorState: called for every robot at each start; no robot moves "
    "before all have answered",
)
MOTORS_STATE = NodeParameter(
    "motors_state",
    PATTERN,
    "",
    "pattern of a topic, `/robot{}/RosAria/motors_state`, of std_msgs/Bool or with another type after a "
    "blank (p2os_msgs/MotorState): a robot whose motors go off, as by its emergency button, is stopped at "
    "once",
)
DEADBAND = NodeParameter(
    "deadband",
    NUMBER,
    None,
    "a command of which no component is larger is sent as zero, for drivers that ignore small changes "
    "([p2os](robots.md#p2os-instead-of-rosaria))",
    "m/s, rad/s",
    "the scenario's `control.deadband`",
    low=0.0,
)
LAW_LIMIT = NodeParameter(
    "law_limit",
    NUMBER,
    None,
    "of wall time: a law that takes longer for a command, while robots move, is given up: they stop, and "
    "`start` makes it anew. The status names one that is waited for; neither it nor any answer waits",
    "s",
    "1 s or two periods, 30 s where no robot is real",
    above=0.0,
)
LAW_PROCESS = NodeParameter(
    "law_process",
    FLAG,
    None,
    "a law of one's own runs in a process of its own, which can be ended whatever it is at; else in a "
    "thread of the node",
    rule="true, false for a law whose file uses ROS",
)
DRY_RUN = NodeParameter(
    "dry_run",
    FLAG,
    False,
    "everything is computed and reported in the status, nothing is published to the robots",
)

PLACE_TOLERANCE = NodeParameter(
    "place_tolerance",
    NUMBER,
    0.3,
    "how far a robot may be from where the scenario has it",
    "m, rad",
    above=0.0,
)
TIME_LIMIT = NodeParameter(
    "time_limit", NUMBER, 5.0, "of wall time, in which every robot is to publish", "s", above=0.0
)
LEAST_DISTANCE = NodeParameter(
    "min_distance",
    NUMBER,
    1.0,
    "least distance of two centres, measured and predicted",
    "m",
    low=0.0,
)
SILENCE = NodeParameter(
    "silence",
    NUMBER,
    10.0,
    "of wall time: without a sample for so long the run has ended",
    "s",
    above=0.0,
)
HAND_LENGTH = NodeParameter(
    "l", NUMBER, DEFAULT_HAND_LENGTH, "of the points whose trails are drawn", "m", above=0.0
)
PICTURES = NodeParameter(
    "rate", NUMBER, 10.0, "of pictures, while there is a subscriber", "Hz", above=0.0, high=100.0
)

POSES = (
    ODOM_TIMEOUT,
    ODOM_FRAME,
    ODOM_TOPIC,
    FRAME_SOURCE,
    POSE_TOPIC,
    POSE_TIMEOUT,
    WORLD_FRAME,
    BASE_FRAME,
    MAX_JUMP,
)
CONTROL = "pioneer_control"
# In the order in which they are listed.
NODES = {
    "stage": (
        *(SPEED, PAUSED, PRESET, ODOM_RATE, CMD_VEL_TIMEOUT, LOCKSTEP, LOCKSTEP_TIMEOUT),
        *(WAIT_FOR_CONTROL, MOST_BY_SERVICE, WAIT_FOR_RECORDERS),
        *(STAGE_WORLD_FRAME, STAGE_ODOM_FRAME, STAGE_BASE_FRAME, TRUE_POSE_TOPIC, VIEW),
        TAKEOFF_HEIGHT,
    ),
    CONTROL: (
        *(RATE, SATURATION, AUTOSTART, ONE_FOR_EACH, SPEED, *POSES[:3], CMD_VEL_TOPIC, *POSES[3:8]),
        *(SENSOR_TOPIC, SENSOR_TIMEOUT),
        *(
            REAL,
            RESUME,
            STUCK_TIME,
            FROZEN_TIME,
            MAX_JUMP,
            GEOFENCE,
            MIN_DISTANCE,
            V_MAX,
            OMEGA_MAX,
        ),
        *(TEAM_TOPICS, ENABLE_MOTORS, MOTORS_STATE, DEADBAND, LAW_LIMIT, LAW_PROCESS, DRY_RUN),
    ),
    "preflight": (
        PLACE_TOLERANCE,
        LEAST_DISTANCE,
        TIME_LIMIT,
        GEOFENCE,
        V_MAX,
        OMEGA_MAX,
        DEADBAND,
        *POSES,
        SENSOR_TOPIC,
        SENSOR_TIMEOUT,
        REAL,
    ),
    "record": (SILENCE, *POSES, CMD_VEL_TOPIC, SENSOR_TOPIC, V_MAX, OMEGA_MAX, DEADBAND),
    "markers": (HAND_LENGTH,),
    "camera": (PICTURES,),
}
NAMES = frozenset(parameter.name for listed in NODES.values() for parameter in listed)
BEGIN, END = (
    "<!-- parameters of {}, made by mrs_simulator.ros.node.node_parameters -->",
    "<!-- end -->",
)


def table(node):
    """Return the Markdown table of the parameters of ``node``; those of the controller are listed once."""
    shared = [p for p in NODES[node] if node != CONTROL and p in NODES[CONTROL]]
    own = [p for p in NODES[node] if p not in shared]
    rows = ["| `~{}` | {} | {} |".format(p.name, p.default_text(), p.meaning) for p in own]
    if shared:
        names = ", ".join("`~{}`".format(p.name) for p in shared)
        rows.append("| {} | as of `{}` | |".format(names, CONTROL))
    return "\n".join(["| parameter | default | |", "|---|---|---|", *rows])


def with_tables(text):
    """Return the page ``text`` with the table of each node between its marks brought up to date."""
    for node in NODES:
        begin = BEGIN.format(node)
        found = re.compile(re.escape(begin) + "\n.*?" + re.escape(END), re.DOTALL)
        fresh = "{}\n{}\n{}".format(begin, table(node), END)
        text = found.sub(lambda _, fresh=fresh: fresh, text)
    return text


def help_text(node):
    """Return the parameters of ``node`` for its ``--help``."""
    lines = ["parameters, as _name:=value here or on the parameter server below the node's name:"]
    for parameter in NODES[node]:
        meaning = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", parameter.meaning).replace("`", "")
        default = parameter.default_text().replace("`", "")
        lines.append("  {}: {}".format(parameter.name, parameter.wanted()))
        lines.append("      {} (default: {})".format(meaning, default))
    return "\n".join(lines)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as page:
        made = with_tables(page.read())
    with open(sys.argv[1], "w", encoding="utf-8") as page:
        page.write(made)
