"""The parameters of the nodes, declared once for all that reads, checks, lists or documents them."""

import re

from mrs_simulator.core.fields import EACH, FLAG, NUMBER, NUMBERS, PATTERN, POSITIVE, TEXT, Field
from mrs_simulator.core.kinematics import DEFAULT_HAND_LENGTH
from mrs_simulator.scenario.control import RATES
from mrs_simulator.scenario.scenario import MOST_ROBOTS

ROBOTS = "robots' numbers"  # a kind of the launch files' texts

SPEED = Field(
    "speed",
    None,
    low=0.0,
    rule="the scenario's",
    type=NUMBER,
    meaning="simulated over wall time, 0: as fast as possible",
)
PAUSED = Field("paused", False, meaning="start paused")
PRESET = Field(
    "preset",
    "none",
    choices=("none", "rosaria", "crazyswarm", "ardrone", "heron", "wamv"),
    meaning="`rosaria`, `crazyswarm`, `ardrone`, `heron`, `wamv`: see below; also an argument",
)
TAKEOFF_HEIGHT = Field(
    "takeoff_height", 1.0, "m", **POSITIVE, meaning="to which `/robotN/takeoff` lets a robot rise"
)
ODOM_RATE = Field(
    "odom_rate",
    None,
    "Hz",
    **POSITIVE,
    rule="the scenario's `odometry_rate`, else 50 Hz, or `control.rate` where that is higher; preset "
    "`rosaria`: 10 Hz",
    type=NUMBER,
    meaning="of odometry and tf; where the scenario gives a rate, which may be each kind's own, this one "
    "may not be given",
)
CMD_VEL_TIMEOUT = Field(
    "cmd_vel_timeout",
    None,
    "s",
    **POSITIVE,
    rule="the scenario's, 0.6 s",
    type=NUMBER,
    meaning="each robot's watchdog",
)
LOCKSTEP = Field(
    "lockstep",
    False,
    choices=("auto",),
    meaning="advance only when every robot has been commanded since the last odometry; `auto`, which "
    "simulation.launch says: where all robots are simulated and the speed is not 1",
)
LOCKSTEP_TIMEOUT = Field(
    "lockstep_timeout",
    5.0,
    "s",
    **POSITIVE,
    meaning="of wall time, after which the silent robots are named, and odometry and readings are "
    "published again: none that is lost, or that a reset puts off, stalls a run",
)
WAIT_FOR_CONTROL = Field(
    "wait_for_control",
    False,
    meaning="stand at time zero until every robot's commands are connected",
)
MOST_BY_SERVICE = Field(
    "most_robots",
    1000,
    low=1,
    high=MOST_ROBOTS,
    meaning="largest team that `stage/set_team` takes; the scenario's own may be larger",
)
WAIT_FOR_RECORDERS = Field(
    "wait_for_recorders",
    0,
    low=0,
    meaning="stand at time zero until so many subscribe to `stage/state`, and no further topic for 0.3 s",
)
STAGE_WORLD_FRAME = Field("world_frame", "world", meaning="of the transforms it publishes")
STAGE_ODOM_FRAME = Field(
    "odom_frame", "robot{}/odom", type=PATTERN, meaning="`{}` is the robot's number"
)
STAGE_BASE_FRAME = Field("base_frame", "robot{}/base_link", type=PATTERN, meaning="likewise")
TRUE_POSE_TOPIC = Field(
    "pose_topic",
    "",
    type=PATTERN,
    meaning="pattern, `/robot{}/pose`: the true poses of the simulated robots as geometry_msgs/PoseStamped "
    "at `~odom_rate`, to rehearse `_frame_source:=external`",
)
VIEW = Field("view", False, meaning="pybullet's own window (needs a display)")
RATE = Field(
    "rate",
    None,
    "Hz",
    low=RATES[0],
    high=RATES[1],
    rule="the scenario's, 50 Hz",
    type=NUMBER,
    meaning="of commands",
)
SATURATION = Field(
    "saturation",
    None,
    choices=("robot", "team", "none"),
    rule="the scenario's, `robot`",
    type=TEXT,
    meaning="`robot`, `team`, `none`: who is slowed where a limit is reached",
)
AUTOSTART = Field(
    "autostart",
    None,
    rule="true, false if any robot is real",
    type=FLAG,
    meaning="begin to control at once, else when `start` is called; with real robots the node says with "
    "which `preflight` they are checked first",
)
ONE_FOR_EACH = LOCKSTEP._replace(
    meaning="one command for each odometry; `auto` as for the stage, by `~speed`, else the scenario's speed"
)
ODOM_TIMEOUT = Field(
    "odom_timeout",
    0.5,
    "s",
    **POSITIVE,
    meaning="a robot silent for longer, a real one in wall time, is named, and all are stopped; a message "
    "older than this is refused, below",
)
ODOM_FRAME = Field(
    "odom_frame",
    "",
    rule='any with "odom" in it, or none',
    meaning="the frame in which odometry is published, `robot{}/odom`; another is refused (not with `tf` "
    "and `external`)",
)
ODOM_TOPIC = Field(
    "odom_topic",
    "/robot{}/odom",
    type=PATTERN,
    meaning="`{}` is the robot's number; remapping the names will do as well",
)
CMD_VEL_TOPIC = Field("cmd_vel_topic", "/robot{}/cmd_vel", type=PATTERN, meaning="likewise")
SENSOR_TOPIC = Field(
    "sensor_topic",
    "/robot{}/*",
    type=PATTERN,
    meaning="of the sensors that the law asks for: `{}` is the robot's number, `*` the sensor's name; "
    "RosAria's are `/robot{}/RosAria/*`",
)
SENSOR_TIMEOUT = Field(
    "sensor_timeout",
    0.5,
    "s",
    **POSITIVE,
    meaning="beyond a sensor's latency: one silent for longer, and for 2.5 of its periods, is named, and "
    "all robots are stopped",
)
FRAME_SOURCE = Field(
    "frame_source",
    None,
    choices=("odometry", "scenario", "first", "tf", "external"),
    rule="`odometry`; with odometry `wheel`: `scenario`",
    type=TEXT,
    meaning="where common poses come from, below",
)
POSE_TOPIC = Field("pose_topic", "/robot{}/pose", type=PATTERN, meaning="of `external`")
POSE_TIMEOUT = Field("pose_timeout", 0.5, "s", **POSITIVE, meaning="of `external` and `tf`")
WORLD_FRAME = Field("world_frame", "world", meaning="of `tf`")
BASE_FRAME = Field("base_frame", "robot{}/base_link", type=PATTERN, meaning="of `tf`")
REAL = Field(
    "real",
    "",
    rule="in simulated time none, else all",
    type=ROBOTS,
    meaning="numbers of the real robots, `2,4`, on whom the defaults below depend; they rule lockstep out",
)
RESUME = Field(
    "resume",
    None,
    rule="true, false if any robot is real",
    type=FLAG,
    meaning="go on by itself after a silence; false: only when `start` is called",
)
STUCK_TIME = Field(
    "stuck_time",
    2.0,
    "s",
    low=0.0,
    rule="2 s, no bound for simulated robots",
    meaning="a robot commanded to move, 0.05 m/s or 0.1 rad/s at least, that does less than a fifth of it "
    "for so long is stopped; given, it holds for all (not meant for `point_mass`, which knows no heading); "
    "0: no bound",
)
FROZEN_TIME = Field(
    "frozen_time",
    0.5,
    "s",
    low=0.0,
    rule="0.5 s, no bound for simulated robots",
    meaning="a robot that is commanded to move by more than 20 mm or 2 degrees in this time, while its "
    "odometry says the same to the bit, is stopped: a driver without its robot repeats the last pose; "
    "0: no bound",
)
MAX_JUMP = Field(
    "max_jump",
    0.3,
    "m, rad",
    low=0.0,
    rule="0.3 m and rad, no bound for simulated robots",
    meaning="given, it holds for all; and 1.5 times what its top speed explains: a robot farther from "
    "where it was received last has jumped, below; 0: any jump is followed",
)
GEOFENCE = Field(
    "geofence",
    None,
    "m",
    type=NUMBERS,
    sizes=(4, 6),
    meaning="`[x_min, y_min, x_max, y_max]` in m: a robot outside, or that would be before it stands, is "
    "stopped; of robots that fly it may have `z_min, z_max` besides",
)
MIN_DISTANCE = Field(
    "min_distance",
    0.0,
    "m",
    low=0.0,
    meaning="two robots whose centres are nearer, or would be before they stand, are both stopped",
)
V_MAX = Field(
    "v_max",
    None,
    "m/s",
    **POSITIVE,
    rule="the scenario's",
    type=EACH,
    meaning="lower top speeds for first trials, in m/s: a number for all, or one for each robot, "
    "`[0.1, 0.2, 0.2, 0.2]`; paths keep their shape. The law, preflight and record know the highest",
)
OMEGA_MAX = V_MAX._replace(name="omega_max", meaning="likewise, in rad/s", unit="rad/s")
TEAM_TOPICS = Field(
    "team_topics",
    "auto",
    choices=("auto", "always", "never"),
    meaning="`always`, `never`: use `stage/odometry` and `stage/command` instead of each robot's topics; "
    "`auto`: from 50 simulated robots on, and with [arms](manipulators.md#over-ros), if a stage offers "
    "them",
)
ENABLE_MOTORS = Field(
    "enable_motors",
    "",
    type=PATTERN,
    meaning="pattern of a std_srvs/Empty service, `/robot{}/RosAria/enable_motors`, or of a topic followed "
    "by its type, std_msgs/Bool or p2os_msgs/MotorState: called for every robot at each start; no robot "
    "moves before all have answered",
)
MOTORS_STATE = Field(
    "motors_state",
    "",
    type=PATTERN,
    meaning="pattern of a topic, `/robot{}/RosAria/motors_state`, of std_msgs/Bool or with another type "
    "after a blank (p2os_msgs/MotorState): a robot whose motors go off, as by its emergency button, is "
    "stopped at once",
)
DEADBAND = Field(
    "deadband",
    None,
    "m/s, rad/s",
    low=0.0,
    rule="the scenario's `control.deadband`",
    type=NUMBER,
    meaning="a command of which no component is larger is sent as zero, for drivers that ignore small "
    "changes ([p2os](robots.md#p2os-instead-of-rosaria))",
)
LAW_LIMIT = Field(
    "law_limit",
    None,
    "s",
    **POSITIVE,
    rule="1 s or two periods, 30 s where no robot is real",
    type=NUMBER,
    meaning="of wall time: a law that takes longer for a command, while robots move, is given up: they "
    "stop, and `start` makes it anew. The status names one that is waited for; neither it nor any answer "
    "waits",
)
LAW_PROCESS = Field(
    "law_process",
    None,
    rule="true, false for a law whose file uses ROS",
    type=FLAG,
    meaning="a law of one's own runs in a process of its own, which can be ended whatever it is at; else "
    "in a thread of the node",
)
DRY_RUN = Field(
    "dry_run",
    False,
    meaning="everything is computed and reported in the status, nothing is published to the robots",
)
PLACE_TOLERANCE = Field(
    "place_tolerance",
    0.3,
    "m, rad",
    **POSITIVE,
    meaning="how far a robot may be from where the scenario has it",
)
TIME_LIMIT = Field(
    "time_limit", 5.0, "s", **POSITIVE, meaning="of wall time, in which every robot is to publish"
)
LEAST_DISTANCE = Field(
    "min_distance",
    1.0,
    "m",
    low=0.0,
    meaning="least distance of two centres, measured and predicted",
)
SILENCE = Field(
    "silence",
    10.0,
    "s",
    **POSITIVE,
    meaning="of wall time: without a sample for so long the run has ended",
)
HAND_LENGTH = Field(
    "l", DEFAULT_HAND_LENGTH, "m", **POSITIVE, meaning="of the points whose trails are drawn"
)
PICTURES = Field(
    "rate", 10.0, "Hz", **POSITIVE, high=100.0, meaning="of pictures, while there is a subscriber"
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


def table(node):
    """Return the Markdown table of the parameters of ``node``; those of the controller are listed once."""
    shared = [p for p in NODES[node] if node != CONTROL and p in NODES[CONTROL]]
    own = [p for p in NODES[node] if p not in shared]
    rows = [p.row("~") for p in own]
    if shared:
        names = ", ".join("`~{}`".format(p.name) for p in shared)
        rows.append("| {} | as of `{}` | |".format(names, CONTROL))
    return "\n".join(["| parameter | default | |", "|---|---|---|", *rows])


def help_text(node):
    """Return the parameters of ``node`` for its ``--help``."""
    lines = ["parameters, as _name:=value here or on the parameter server below the node's name:"]
    for parameter in NODES[node]:
        meaning = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", parameter.meaning).replace("`", "")
        default = parameter.default_text().replace("`", "")
        lines.append("  {}: {}".format(parameter.name, parameter.wanted()))
        lines.append("      {} (default: {})".format(meaning, default))
    return "\n".join(lines)
