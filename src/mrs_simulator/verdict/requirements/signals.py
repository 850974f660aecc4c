"""The values of the signals that requirements speak of, in a recorded run."""

import functools
import re

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.core.spectra import algebraic_connectivity
from mrs_simulator.core.temporal_logic.formula import EDGE, PAIR, ROBOT
from mrs_simulator.core.temporal_logic.robustness import Signal
from mrs_simulator.scenario.requirements import ALL_SIGNALS, CURVE, SENSOR
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.state.columns import OUT_OF_PLANE, TWIST
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.requirements.clearances import clearance, of_obstacle, of_robot


class Absent(ValueError):
    """A signal that this run does not have; the message says why."""


def signal_of(name, control, run):
    """Return the ``Signal`` called ``name`` of ``run``; ``Absent`` where there is none.

    ``control``: the run's protocol, None where it is not known.
    """
    kind = ALL_SIGNALS[name]
    find = VALUES.get(name) or functools.partial(_OPEN[name.split(".")[0]], name)
    values = np.asarray(find(control, run), dtype=float)
    labels = _LABELS[kind.domain](control, run) if kind.domain else ()
    return Signal(values, kind.unit, kind.domain, labels)


def _places(run):
    """Return the robots' centres in space, (m, n, 3) [m]."""
    return np.dstack([run.pose[:, :, :2], run.heights])


def _pairs(run):
    return np.triu_indices(len(run.robots), 1)


def _distance(control, run):
    first, second = _pairs(run)
    places = _places(run)
    return np.array([_apart(places[:, i], places[:, j]) for i, j in zip(first, second)])


def _apart(a, b):
    return np.sqrt(((a - b) ** 2).sum(axis=-1))


def _prisms(run):
    if run.scenario is None and not run.kinds:
        raise Absent("the run does not say of which kinds its robots are")
    team = Team.from_scenario(run.scenario) if run.scenario is not None else Team.of(run.kinds)
    height = _places(run)[:, :, 2]
    bodies = [kind.body for kind in team.kinds]
    return [of_robot(body, run.pose[:, k], height[:, k]) for k, body in enumerate(bodies)]


def _clearance(control, run):
    prisms = _prisms(run)
    return np.array([clearance(prisms[i], prisms[j]) for i, j in zip(*_pairs(run))])


def _obstacle_clearance(control, run):
    if run.scenario is None:
        raise Absent("the run does not say which obstacles there were")
    times = run.time - run.time[0] + run.meta.get("scene_time", 0.0)
    obstacles = [of_obstacle(each, times) for each in obstacles_of(run.scenario)]
    result = np.full((len(run.robots), len(run.time)), np.inf)
    for row, prism in enumerate(_prisms(run)):
        for obstacle in obstacles:
            result[row] = np.minimum(result[row], clearance(prism, obstacle))
    return result


def _edges(control, run):
    """Return the edges (k, 2), rows of robots, of the graph at the start; undirected ones once."""
    if control is None:
        raise Absent("without a protocol no graph is known")
    graph = control.graph_at(run.hand[0], run.hand[0]) or control.topology
    receivers, senders, _ = graph.arcs
    edges = sorted({(min(i, j), max(i, j)) for i, j in zip(receivers.tolist(), senders.tolist())})
    return np.array(edges, dtype=int).reshape(-1, 2)


def _length(control, run):
    return np.array([_apart(run.hand[:, i], run.hand[:, j]) for i, j in _edges(control, run)])


def _speed(control, run):
    rates = _rates(np.moveaxis(_places(run), 1, 0), run.time, _apart)
    return _as_told(run, rates, lambda: np.sqrt((_linear(run) ** 2).sum(axis=-1)))


def _turn_rate(control, run):
    rates = _rates(run.pose[:, :, 2].T, run.time, lambda now, before: wrap_angle(now - before))
    return _as_told(run, rates, lambda: run.twist[:, :, 2])


def _linear(run):
    """Return the robots' linear velocities as recorded, (m, n, 3) [m/s]."""
    up = run.out_of_plane[:, :, 0] if run.has(OUT_OF_PLANE) else np.zeros(run.pose.shape[:2])
    return np.dstack([run.twist[:, :, :2], up])


def _as_told(run, rates, velocities):
    """Return the ``rates`` (n, m); of real robots the ``velocities()`` (m, n) that they measure.

    A real robot's pose is the one received last, which a sample may hold for the second time, or two
    poses later than the sample before: differences of them would be none, or twice what it drives.
    """
    real = run.are_real
    if not real.any():
        return rates
    if not run.has(TWIST):
        raise Absent("run.csv has no velocities of robots that may be real: report on their bag")
    silent = real.any(axis=0) & ~run.twist.any(axis=(0, 2)) & rates.any(axis=1)
    if silent.any():
        raise Absent("robot{}: its odometry tells no velocity".format(run.robots[silent.argmax()]))
    return np.where(real, velocities(), rates.T).T


def _rates(values, time, difference):
    """Return the change of ``values`` (n, m, ...) since the sample before over its time, 0 at the first."""
    result = np.zeros(values.shape[:2])
    if len(time) > 1:
        result[:, 1:] = difference(values[:, 1:], values[:, :-1]) / np.diff(time)
    return result


def _error(control, run):
    if control is None:
        raise Absent("without a protocol no place is wanted")
    at_once = getattr(control.targets, "of_samples", False)
    found, begun, time = np.empty(run.hand.shape[:2]), control.time, run.time - run.time[0]
    try:
        for rows in blocks(*found.shape) if at_once else range(len(time)):
            control.time, hand = time[rows] if at_once else float(time[rows]), run.hand[rows]
            hand = _apart_in_memory(hand) if at_once else hand
            wanted = call(control.targets, hand)
            if np.shape(wanted) != hand.shape:
                text = "the protocol {} wants no place of each robot (targets)"
                raise Absent(text.format(type(control).__name__))
            found[rows] = _apart(hand, np.asarray(wanted, dtype=float))
    finally:
        control.time = begun
    return found.T


def _apart_in_memory(hand):
    """Return ``hand`` (m, n, d) with each sample's numbers next to each other, in their order of before.

    Sums over them go as over those of one sample then, to the bit.
    """
    if hand.strides[1] >= hand.strides[2]:
        return np.ascontiguousarray(hand)
    return np.ascontiguousarray(hand.swapaxes(1, 2)).swapaxes(1, 2)


def _deviation(control, run):
    track = None
    if control is not None:
        track = call(control.predicted_track, run.hand[0], run.time - run.time[0])
    if np.shape(track) != run.hand.shape:
        raise Absent("the protocol predicts no way of each robot")
    return _apart(run.hand, np.asarray(track, dtype=float)).T


def _energy(control, run):
    energy = None if control is None else call(control.energy, run.hand[0])
    if energy is None or energy.moving:
        raise Absent("the protocol states no energy of the places")
    return energy.values(run.hand, run.hand, run.time - run.time[0])


def _lambda_2(control, run):
    if control is None:
        raise Absent("without a protocol no graph is known")
    start = run.hand[0]
    if control.graph_at(start, start) is None:
        return np.full(len(run.time), algebraic_connectivity(control.topology))
    return [algebraic_connectivity(control.graph_at(start, hand)) for hand in run.hand]


def _contacts(control, run):
    if run.are_real.all():
        raise Absent("nothing reports collisions of real robots")
    if run.meta.get("collisions_unknown"):
        raise Absent("the program that recorded was killed: collisions are not known")
    times = np.sort([each.time for each in run.collisions])
    return np.searchsorted(times, run.time, side="right")


def _curve(name, control, run):
    """Return the law's curve whose name, in small letters without its unit, is behind the dot."""
    curves = [] if control is None else call(control.curves, run)
    known = {plain_name(each.name): each for each in curves if each.across == "time [s]"}
    wanted = name.split(".", 1)[1]
    if wanted not in known:
        text = "the law has no curve {} over time, wanted one of {}"
        raise Absent(text.format(wanted, ", ".join(sorted(known)) or "none"))
    curve = known[wanted]
    time, values = (np.asarray(each, dtype=float) for each in (curve.at, curve.measured))
    return np.interp(run.time - run.time[0], time, values)


def plain_name(name):
    """Return the ``name`` of a curve as formulas write it: "floor seen [-]" is floor_seen."""
    return re.sub(r"[^a-z0-9]+", "_", name.split("[")[0].lower()).strip("_")


def _reading(name, control, run):
    """Return the least values (n, m) of a sensor's newest readings, as the run kept them."""
    kept = run.meta.get("readings", {})
    found = kept.get(tuple(name.split(".")[1:]))
    if found is None:
        raise Absent("{}: readings are kept in runs without ROS alone".format(name))
    if np.isnan(found).any():
        text = "{}: a robot never had such a reading; mrs-simulator requirements lists those of a scenario"
        raise Absent(text.format(name))
    return found


def _of_two(run, rows):
    def label(index):
        first, second = run.robots[rows[index]]
        return "robot{} and robot{}".format(first, second)

    return label


_LABELS = {
    ROBOT: lambda control, run: ["robot{}".format(number) for number in run.robots],
    PAIR: lambda control, run: _of_two(run, np.column_stack(_pairs(run))),
    EDGE: lambda control, run: _of_two(run, _edges(control, run)),
}
_OPEN = {CURVE: _curve, SENSOR: _reading}
VALUES = {
    "time": lambda control, run: run.time - run.time[0],
    "x": lambda control, run: run.pose[:, :, 0].T,
    "y": lambda control, run: run.pose[:, :, 1].T,
    "height": lambda control, run: _places(run)[:, :, 2].T,
    "heading": lambda control, run: run.pose[:, :, 2].T,
    "speed": _speed,
    "turn_rate": _turn_rate,
    "error": _error,
    "deviation": _deviation,
    "obstacle_clearance": _obstacle_clearance,
    "distance": _distance,
    "clearance": _clearance,
    "length": _length,
    "energy": _energy,
    "lambda_2": _lambda_2,
    "contacts": _contacts,
}
