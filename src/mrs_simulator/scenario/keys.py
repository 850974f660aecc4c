"""The keys of a scenario, each declared once: by this they are read, written and documented."""

import math

from mrs_simulator.core.fields import NAMES, NUMBER, POSITIVE, REQUIRED, Field
from mrs_simulator.scenario.control import CONTROL, Control, read_control
from mrs_simulator.scenario.incidents import EVENT, read_events
from mrs_simulator.scenario.network.links import LINKS, NO_FAULTS, SWITCHING, read_links
from mrs_simulator.scenario.network.topology import read_topology
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.requirements import read_requirements
from mrs_simulator.scenario.safety import SAFETY
from mrs_simulator.scenario.search import (
    DEAD_ROBOTS,
    EDGE_RANGE,
    NO_SEARCH,
    POSE_RANGE,
    PUSH_RANGE,
    read_search,
)
from mrs_simulator.scenario.surroundings.environment import (
    CALM,
    CURRENT,
    WAVES,
    WIND,
    read_environment,
)
from mrs_simulator.scenario.surroundings.maps import MAP, read_map
from mrs_simulator.scenario.surroundings.moving_obstacles import TRACK
from mrs_simulator.scenario.surroundings.obstacle_reading import (
    OBSTACLE,
    obstacle_to_plain,
    read_obstacles,
)
from mrs_simulator.scenario.team.estimates import FILTER, read_estimates
from mrs_simulator.scenario.team.limits import limits_to_plain, read_limits
from mrs_simulator.scenario.team.load import LOAD, read_load
from mrs_simulator.scenario.team.mismatch import MISMATCH, NO_MISMATCH, read_mismatch
from mrs_simulator.scenario.team.odometry_errors import ERRORS, GYRO, read_odometry_errors

FIDELITIES = ("kinematic", "dynamic", "point_mass")
ENGINES = ("pybullet", "planar")  # of motion with forces on wheels, the first by default
ODOMETRIES = ("world", "wheel")
LONGEST_STEP = 0.02  # [s], of the simulated world unless the scenario says otherwise


def read_step(top, others):
    """Return the ``step`` of the world, by default the longest that divides the command period."""
    period = 1.0 / others["control"].rate
    default = period / math.ceil(period / LONGEST_STEP - 1e-9)
    step = top.number("step", default, low=1e-5, high=1.0)
    if abs(period / step - round(period / step)) > 1e-6 or step > period * (1.0 + 1e-9):
        text = "{}: {:g} s, wanted the command period 1/rate = {:g} s divided by a whole number"
        raise ScenarioError(text.format(top.at("step"), step, period))
    return step


def topology_to_plain(topology, n):
    """Return the plain values of ``topology``."""
    return {"edges": [list(edge) for edge in topology.edges], "directed": topology.directed}


# Read together, by ``read_team``.
TEAM = (
    Field("robots", rule="length of `poses`", meaning="number of robots"),
    Field(
        "poses",
        rule=REQUIRED,
        meaning="`[x, y, theta]` of each wheel-axle centre, or a [layout](#where-robots-begin): "
        "`{layout: grid, spacing: 2.0}`",
    ),
    Field(
        "model",
        "pioneer3dx",
        meaning="kind of robot, or a list with one for each: a shipped one, or "
        "[a file of your own](robots_of_your_own.md) beside the scenario",
    ),
    Field("kind", rule="`model`", meaning="the same as `model`"),
    Field(
        "groups",
        meaning="a team of [several kinds](#teams-of-several-kinds), instead of `poses` and `model`",
    ),
    Field(
        "kinds", meaning="kinds of this scenario alone, by name: [below](#teams-of-several-kinds)"
    ),
    Field(
        "altitude",
        0.0,
        "m",
        meaning="height at which flying robots begin: one for all, a list with one for each, or one in "
        "each of `groups`",
    ),
    Field(
        "sensors",
        rule="those of the kinds",
        meaning="sensors that are added, taken away or tuned: [sensors](sensors.md)",
    ),
)
SEED = Field(
    "seed",
    0,
    low=0,
    high=2**32 - 1,
    meaning="of everything random; the same seed gives the same bytes on the same machine",
)
# All others, in the order in which they are read and written.
KEYS = (
    Field(
        "title",
        "",
        meaning="shown in verdict and figures; another protocol or number of robots (`--protocol`, "
        "`--robots`) makes its own",
    ),
    Field(
        "fidelity",
        FIDELITIES[0],
        choices=FIDELITIES,
        meaning="`kinematic`: the robots' motion integrated exactly; `dynamic`: masses, wheels, contact "
        "and friction; `point_mass`: points, as theory has them",
    ),
    Field(
        "engine",
        ENGINES[0],
        choices=ENGINES,
        meaning="what moves robots on wheels with `fidelity: dynamic`: `pybullet`, or `planar`, many times "
        "as fast, for robots with ramps ([engines](engines.md))",
    ),
    Field(
        "limits",
        "firmware",
        read=lambda top, others: read_limits(top),
        plain=lambda limits, n: limits_to_plain(limits),
        meaning="`firmware`, `top`, `none`, or `{v_max, omega_max, v_accel, omega_accel}`; "
        "`{preset: top, v_max: 0.5}`: each robot's own limits of that preset, and no faster than this",
    ),
    Field(
        "odometry",
        ODOMETRIES[0],
        choices=ODOMETRIES,
        meaning="`world`: true poses; `wheel`: what a robot counts from its wheels: it begins at zero "
        "wherever the robot stands, and drifts. The control adds the pose at which the robot began. Points "
        "(`point_mass`) have no wheels",
    ),
    Field(
        "odometry_errors",
        read=read_odometry_errors,
        rule="those built in",
        meaning="of `odometry: wheel`: unequal wheels, a wrong track, motion noise "
        "([sensors](sensors.md#odometry))",
    ),
    Field("control", Control(), read=read_control, meaning="how the team is controlled"),
    Field(
        "topology",
        read=lambda top, others: read_topology(top, others["poses"], others["seed"]),
        plain=topology_to_plain,
        meaning="a [preset](#graphs), `{preset: cycle}`, or `{edges: [[i, j, weight], ...], directed: "
        "true}`; edge `[i, j]`: robot i receives from robot j",
    ),
    Field(
        "links",
        NO_FAULTS,
        read=read_links,
        plain=lambda links, n: links.to_plain(n),
        rule="perfect edges",
        meaning="delay, loss and switching of edges: [below](#edges-with-faults)",
    ),
    Field(
        "mismatch",
        NO_MISMATCH,
        read=read_mismatch,
        rule="none",
        meaning="how robots [differ from their data sheet](#robots-that-are-not-as-their-data-sheet): "
        "`{delay: 0.1, speed: 0.97, track: 1.05}`",
    ),
    Field(
        "load",
        read=read_load,
        meaning="what robots with arms [carry together](manipulators.md#carrying-together)",
    ),
    Field(
        "environment",
        CALM,
        read=read_environment,
        rule="calm",
        meaning="[current, wind and waves](#current-wind-and-waves), which move "
        "[vessels](kinds.md#what-a-drive-makes-of-a-command) and, as wind, quadrotors",
    ),
    Field(
        "obstacles",
        (),
        read=lambda top, others: read_obstacles(top),
        plain=lambda obstacles, n: [obstacle_to_plain(each) for each in obstacles],
        meaning="boxes, cylinders, walls, land: [below](#obstacles)",
    ),
    Field(
        "map",
        read=lambda top, others: read_map(top),
        meaning="a file with walls that collide and are seen: [below](#maps)",
    ),
    Field(
        "estimates",
        read=read_estimates,
        meaning="where the poses come from that the control knows: `odometry`, a sensor of poses, or a "
        "Kalman filter, `{ekf: [gps, imu]}`: [sensors.md](sensors.md#estimated-poses)",
    ),
    Field("duration", 60.0, "s", **POSITIVE, meaning="of simulated time"),
    SEED,
    Field("speed", 1.0, low=0.0, meaning="simulated over wall time, 0: as fast as possible"),
    Field(
        "record_rate",
        10.0,
        "Hz",
        **POSITIVE,
        meaning="samples in `run.csv`, every whole number of `step`s that is nearest: 15 Hz with 0.02 s "
        "becomes 16.7 Hz, headless and over ROS. This holds for `odometry_rate` and the sensors' rates "
        "too, and a warning names the rate that is kept; real robots keep the rate itself",
    ),
    Field(
        "record",
        (),
        rule="none",
        type=NAMES,
        meaning="names of [sensors](sensors.md#recording) whose readings are recorded beside it: "
        "`[laser, sonar]`",
    ),
    Field(
        "takeoff",
        False,
        meaning="flying robots begin on the ground and rise to their `altitude` before the law begins: "
        "without ROS before time 0, over ROS before the stage publishes any odometry",
    ),
    Field(
        "requirements",
        (),
        rule="none",
        read=lambda top, others: read_requirements(top),
        plain=lambda requirements, n: dict(requirements),
        meaning="[formulas](requirements.md) that the run is to keep, by name",
    ),
    Field(
        "search",
        NO_SEARCH,
        read=lambda top, others: read_search(top),
        rule="none",
        meaning="what may vary between the runs of [break and assure](search.md)",
    ),
    Field(
        "events",
        (),
        rule="none",
        read=lambda top, others: read_events(top, top.n),
        meaning="[faults and pushes](#faults-and-pushes), each at its time",
    ),
    Field(
        "odometry_rate",
        None,
        "Hz",
        **POSITIVE,
        choices=("kinds",),
        type=NUMBER,
        rule="each step headless; over ROS 50 Hz, or `control.rate` where that is higher",
        meaning="rate of odometry; `kinds`: each robot's as its kind has it. Between two messages the "
        "control goes by the last one. A rate is rounded to a whole number of steps, and a warning says "
        "where that changes it",
    ),
    Field(
        "cmd_vel_timeout",
        None,
        "s",
        **POSITIVE,
        type=NUMBER,
        rule="each kind's own, 0.6 s of a Pioneer",
        meaning="a robot without a command for this long is stopped",
    ),
    Field(
        "step",
        LONGEST_STEP,
        "s",
        read=read_step,
        rule="at most 0.02 s",
        meaning="of the world; divides the command period",
    ),
)

# By the key that holds them: what their keys are under, and these.
NESTED = {
    "links": (("", LINKS), ("switching.", SWITCHING)),
    "mismatch": (("", MISMATCH),),
    "odometry_errors": (("", ERRORS), ("gyro.", GYRO)),
    "estimates": (("", FILTER),),
    "load": (("", LOAD),),
    "safety": (("", SAFETY),),
    "obstacles": (("", OBSTACLE), ("track.", TRACK)),
    "map": (("", MAP),),
    "environment": (("", CURRENT), ("wind.", WIND), ("waves.", WAVES)),
    "events": (("", EVENT),),
    "search": (
        ("poses.", POSE_RANGE),
        ("edges.", EDGE_RANGE),
        ("", (DEAD_ROBOTS,)),
        ("pushes.", PUSH_RANGE),
    ),
}
HEAD = ["| key | default | |", "|---|---|---|"]


def nested_table(key):
    """Return the table of the keys under ``key``, one of ``NESTED``, in Markdown."""
    return "\n".join(HEAD + [each.row(before) for before, own in NESTED[key] for each in own])


def table():
    """Return the table of all keys in Markdown."""
    rows = list(HEAD)
    for field in TEAM + KEYS:
        is_control = field.name == "control"
        rows += [each.row("control.") for each in CONTROL] if is_control else [field.row()]
    return "\n".join(rows)
