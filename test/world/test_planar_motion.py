"""The planar engine: what wheels on flat ground do, and that it agrees with the untuned solver."""

from types import SimpleNamespace

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.core.kinematics import Limits, wrap_angle
from mrs_simulator.scenario.scenario import ScenarioError, scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.vehicles import kind
from mrs_simulator.world.motion import compiled_rolling, planar
from mrs_simulator.world.motion.dynamic import DynamicMotion
from mrs_simulator.world.motion.planar import PlanarMotion
from mrs_simulator.world.motion.planar_body import GRAVITY
from mrs_simulator.world.motion.rolling import Wheels, held_twists, loads, rolled, who_tips
from mrs_simulator.world.motion.rolling_steps import compiled_roll_step, roll_step, stand_all
from mrs_simulator.world.world import EVERY, World

UNTUNED = {"substep": 1.0 / 240.0, "iterations": 50}
PLACE, HEADING = 0.02, 0.02  # [m], [rad] that trajectories may be from those of the untuned solver
NO_RAMP = Limits(1.5, 6.28, np.inf, np.inf)
STEP = 0.02
PIONEER = kind("pioneer3dx")


def column(value, count=1):
    return np.full(count, float(value))


def wheels(count=1, **changes):
    """Return ``Wheels`` with a caster 0.2 m behind the axle, the mass 0.05 m behind and 0.1 m high."""
    weight = 9.0 * GRAVITY
    values = dict(
        mass=9.0, inertia=0.33, ahead=-0.05, height=0.1, half=0.18, load=0.75 * weight, shift=0.5,
        front=0.05, rear=-0.15, friction=0.6, force=1e3,
    )  # fmt: skip
    return Wheels(**{key: column(value, count) for key, value in {**values, **changes}.items()})


def driven(robots, rims, seconds, substeps=5):
    """Return pose, twist, way of the rims and whether it tipped, of one robot told ``rims`` from rest."""
    pose, twist, way, tips = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(2), False
    for _ in range(int(round(seconds / STEP))):
        pose, twist, turned, tipped = rolled(
            robots, pose, twist, np.array(rims, dtype=float)[:, np.newaxis], STEP, substeps
        )
        way, tips = way + turned[:, 0], tips or bool(tipped[0])
    return pose[0], twist[0], way, tips


def test_friction_and_the_shifted_load_limit_how_a_robot_starts():
    # X = mu N, N = 0.75 m g - 0.5 X: X/m = 0.6 0.75 g/(1 + 0.6 0.5) = 3.3958 m/s^2.
    pose, twist, way, tips = driven(wheels(), (9.0, 9.0), 0.4)
    assert twist[0] / 0.4 == pytest.approx(3.3958, rel=1e-3)
    # The velocity goes first in each of the substeps of 4 ms.
    assert pose[0] == pytest.approx(0.5 * 3.3958 * 0.4 * 0.404, rel=1e-3)
    np.testing.assert_allclose(way, 9.0 * 0.4)  # the rims spin
    assert not tips


def test_a_weak_motor_limits_it_before_the_ground_does():
    _, twist, way, _ = driven(wheels(force=9.0), (9.0, 9.0), 0.4)
    assert twist[0] / 0.4 == pytest.approx(2.0 * 9.0 / 9.0, rel=1e-6)
    assert way[0] == pytest.approx(0.5 * 2.0 * 0.16, rel=0.05)  # and its rims roll


def test_friction_limits_how_a_robot_turns():
    # mu N half/I, with the mass over the axle and nothing that leans.
    _, twist, _, _ = driven(wheels(ahead=0.0, height=0.0, shift=0.0), (-9.0, 9.0), 0.06)
    assert twist[2] / 0.06 == pytest.approx(0.6 * 0.75 * 9.0 * GRAVITY * 0.18 / 0.33, rel=1e-3)


def test_who_brakes_harder_than_its_weight_holds_tips():
    # Its caster lifts from 0.05/0.1 g on: friction 0.6 gives more, 0.4 less.
    slides = driven(wheels(shift=0.5), (-9.0, -9.0), 0.1)
    assert slides[3] and not driven(wheels(friction=0.4), (-9.0, -9.0), 0.1)[3]


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.release)])
def test_compiled_wheels_roll_slide_and_tip_to_the_same_bits(compiled):
    if compiled:
        pytest.importorskip("numba")
    loops = compiled_rolling.kernels() if compiled else compiled_rolling.plain_loops()
    draw = np.random.default_rng(3)
    for m in (1, 2, 7, 33):
        robots = Wheels(*(each * draw.uniform(0.5, 2.0, m) for each in wheels(m, force=20.0)))
        rims = draw.uniform(-1.5, 1.5, (2, m))
        twist = held_twists(robots, rims)
        twist[::2] += draw.uniform(-1.0, 1.0, twist[::2].shape)  # the others roll already
        given = robots, draw.uniform(-3.0, 3.0, (m, 3)), twist, rims, 0.02, 5
        told, again = rolled(*given), compiled_rolling.rolled_by(loops, *given)
        assert all(np.array_equal(*each) for each in zip(told, again))
    rolls = (told[1] == held_twists(robots, rims)).all(axis=1)
    assert 0 < rolls.sum() < m and told[3].any()


def test_who_tips_is_one_question_in_both_loops():
    draw, told = np.random.default_rng(5), []
    for height in draw.uniform(0.05, 0.6, 200):
        robot = wheels(height=height)
        pushed = draw.uniform(-60.0, 60.0, (2, 1)) * [[0.2], [1.0]]
        stands = stand_all(np.array(robot), STEP * pushed, STEP)
        told.append((stands, not who_tips(robot, *pushed)[0]))
    assert all(one == other for one, other in told)
    assert 20 < sum(stands for stands, _ in told) < 180


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.release)])
@pytest.mark.parametrize("limits", ["firmware", "top", None])
def test_steps_in_one_call_have_the_bits_of_numpys(limits, compiled, monkeypatch):
    if compiled:
        pytest.importorskip("numba")
    else:  # Python's has other last bits than the C library's
        monkeypatch.setattr(compiled_rolling, "math", SimpleNamespace(hypot=np.hypot))
    loop, made = compiled_roll_step() if compiled else roll_step, []

    def counted(*given):
        made.append(loop(*given))
        return made[-1]

    tracks = []
    for way in (None, counted):
        by = {compiled_roll_step: way}
        monkeypatch.setattr(planar, "same_bits", lambda compiled, _, by=by: by.get(compiled))
        tracks.append(driven_about(limits))
    np.testing.assert_array_equal(*tracks)
    assert sum(made) > (5 if limits is None else 20)
    assert limits is not None or not all(made)  # one tips where nothing ramps


def driven_about(limits):
    """Return poses, twists and travel of two kinds of robots, far apart, under hard commands for 1.4 s."""
    poses, kinds = (
        [[20.0 * k, 0.0, 2.0 * k - 3.0] for k in range(4)],
        ("pioneer3dx", "turtlebot3_burger") * 2,
    )
    world = World(kinds, poses, fidelity="dynamic", engine="planar", limits=limits)
    draw, track = np.random.default_rng(1), []
    for step in range(70):
        if step % 20 == 0:
            world.set_commands(EVERY, draw.uniform(-1.0, 1.0, (4, 2)) * [0.3, 2.0])
        world.step()
        track.append(np.hstack([world.pose, world.twist, world.motion.wheel_travel[0]]))
    world.close()
    return np.array(track)


def test_loads_are_those_of_the_moments():
    left, right = loads(wheels(2), np.array([10.0, 0.0]), np.array([0.0, 20.0]))
    weight = 9.0 * GRAVITY
    np.testing.assert_allclose(left + right, [0.75 * weight - 5.0, 0.75 * weight])
    np.testing.assert_allclose(right - left, [0.0, 0.1 * 20.0 / 0.18])


def test_within_its_limits_a_robot_rolls_exactly():
    pose, twist, way, _ = driven(wheels(), (0.0064, 0.0076), 2.0)
    v, omega = 0.007, 0.0012 / 0.36
    np.testing.assert_allclose(twist, [v, 0.0, omega], atol=1e-12)
    np.testing.assert_allclose(pose[2], 2.0 * omega, atol=1e-9)
    np.testing.assert_allclose(np.hypot(*pose[:2]), 2.0 * v / omega * np.sin(omega), atol=1e-9)
    np.testing.assert_allclose(way, [0.0128, 0.0152], atol=1e-12)


@pytest.mark.parametrize("rims", [(1.2, 1.2), (-0.5, 0.5), (0.4, 1.4)])
def test_substeps_converge(rims):
    few, many = (driven(wheels(), rims, 0.4, substeps)[0] for substeps in (5, 20))
    np.testing.assert_allclose(few, many, atol=0.012)


# Against the solver --------------------------------------------------------------------------------

# Its wheels carry other shares of the weight than its model would have.
ODD = kind("odd", own={"odd": {"base": "f1tenth", "wheels": {"mass_ahead": "0.1 m"}}})
KINDS = ("pioneer3dx", "turtlebot3_burger", "husky", "robotino3", "f1tenth", ODD)
STARTS = np.array([[6.0 * row, 10.0 * column, 0.0] for column in range(3) for row in range(6)])


def manoeuvres(t):
    """Return commands (18, 3) at ``t`` [s]: all kinds spin, drive an S-curve, brake."""
    on = float(t < 1.5)
    spin = [[0.0, 0.0, 3.0 * on]] * 4 + [[on, 0.0, 3.0 * on]] * 2  # a car turns along its circle
    curve = [[0.7, 0.0, 1.5 * np.sin(2.0 * t)]] * 6
    brake = [[1.2 * on, 0.0, 0.0]] * 4 + [[4.0 * on, 0.0, 0.0]] * 2
    command = np.array(spin + curve + brake)
    command[9, 1] = 0.2
    return command


def trajectory(motion, commands, seconds, inside=None):
    """Return poses (steps, n, 3); ``inside``: a list for how many robots were in the solver."""
    poses = []
    for step in range(int(round(seconds / motion.step))):
        motion.advance(commands(step * motion.step))
        poses.append(motion.pose.copy())
        if inside is not None:
            inside.append(len(motion._bodies))
    motion.close()
    return np.array(poses)


def deviation(first, second):
    """Return by how much [m, rad] robots are apart at most, (2, n)."""
    apart = first - second
    return np.stack([
        np.hypot(apart[..., 0], apart[..., 1]).max(axis=0),
        np.abs(wrap_angle(apart[..., 2])).max(axis=0),
    ])  # fmt: skip


def test_robots_spin_curve_and_brake_as_with_the_untuned_solver():
    given, inside = (KINDS * 3, STARTS, (), "top"), []
    planar = trajectory(PlanarMotion(*given), manoeuvres, 2.3, inside)
    away, turned = deviation(planar, trajectory(DynamicMotion(*given, **UNTUNED), manoeuvres, 2.3))
    assert away.max() < PLACE and turned.max() < HEADING
    assert sum(inside) < 20  # one caster lifts for a moment


def test_a_pioneer_starts_as_fast_as_its_wheels_hold():
    # With 4.68 m/s^2, as in the untuned solver: its caster then carries 41.5 N, its wheels 23.4 N each.
    motion = PlanarMotion(("pioneer3dx",), [[0.0, 0.0, 0.0]], limits=NO_RAMP)
    trajectory(motion, lambda t: np.array([[1.5, 0.0]]), 0.2)
    assert motion.twist[0, 0] / 0.2 == pytest.approx(4.68, rel=0.005)


def test_who_slides_and_tips_does_so_as_with_the_untuned_solver():
    def commands(t):
        return np.array([[1.2, 2.0 * np.sin(2.0 * t)], [1.2 * (t < 1.0), 0.0]])

    given, inside = (("pioneer3dx",) * 2, [[0.0] * 3, [0.0, 5.0, 0.0]], (), NO_RAMP), []
    planar = trajectory(PlanarMotion(*given), commands, 2.0, inside)
    away, turned = deviation(planar, trajectory(DynamicMotion(*given, **UNTUNED), commands, 2.0))
    assert away.max() < PLACE and turned.max() < HEADING
    assert inside[20] == 0 and inside[55] == 1 and inside[-1] == 0  # while it is off its caster


@pytest.mark.parametrize(
    "pushing, x, v", [("pioneer3dx", 0.8, 0.3), ("husky", 1.1, 0.4), ("robotino3", 0.9, 0.3)]
)
def test_robots_push_as_with_the_untuned_solver(pushing, x, v):
    team, inside = (pushing, "pioneer3dx"), []

    def commands(t):
        first = [v] + [0.0] * (2 if pushing == "robotino3" else 1)
        return np.array([first, [0.0] * len(first)])

    given = team, [[0.0, 0.0, 0.0], [x, 0.05, 0.3]]
    planar = trajectory(PlanarMotion(*given), commands, 2.5, inside)
    reference = trajectory(DynamicMotion(*given, **UNTUNED), commands, 2.5)
    away, turned = deviation(planar, reference)
    assert away.max() < PLACE and turned.max() < HEADING
    assert inside[0] < 2 == inside[100]
    assert np.abs(reference[-1, 1, :2] - reference[0, 1, :2]).max() > 0.02 or pushing != "husky"


# In the world --------------------------------------------------------------------------------------


def world_of(*kinds, apart=3.0, **options):
    poses = [[apart * row, 0.0, 0.0] for row in range(len(kinds))]
    return World(kinds, poses, fidelity="dynamic", engine="planar", **options)


def drive(world, command, seconds):
    for _ in range(int(round(seconds / world.step_size))):
        world.set_commands(EVERY, np.array(command, dtype=float))
        world.step()
    return world


def test_an_obstacle_stops_a_robot_that_then_drives_off_again():
    wall = Box("wall", 0.9, 0.0, 0.0, 0.1, 2.0, 0.5)
    world = drive(
        world_of("pioneer3dx", obstacles=[wall], odometry_kind="wheel"), [(0.4, 0.0)], 2.5
    )
    assert [each[1:3] for each in world.contacts.take()] == [("robot1", "wall")]
    assert world.pose[0, 0] == pytest.approx(0.9 - 0.05 - PIONEER.body.front, abs=0.02)
    drive(world, [(-0.4, 0.0)], 3.0)
    # On the ground alone again, encoders have counted its wheels' slipping at the wall, and the way back.
    assert not world.motion._bodies and world.pose[0, 0] < 0.3
    assert world.estimates.odometry()[0, 0] > world.pose[0, 0] + 0.005
    world.close()


def test_the_same_run_gives_the_same_bytes():
    def run():
        world = drive(world_of("pioneer3dx", "robotino3", apart=0.75), [(0.3, 0.0, 0.1)] * 2, 1.0)
        world.close()
        return world.pose

    np.testing.assert_array_equal(run(), run())


def test_a_reset_world_begins_anew():
    world = world_of("pioneer3dx", "husky", apart=1.0, odometry_kind="wheel")
    once = drive(world, [(0.3, 0.1), (0.0, 0.3)], 1.5).pose.copy()
    world.reset()
    assert not world.estimates.odometry().any()
    np.testing.assert_array_equal(drive(world, [(0.3, 0.1), (0.0, 0.3)], 1.5).pose, once)
    world.close()


def test_encoders_tell_how_far_robots_went():
    world = world_of("pioneer3dx", "robotino3", "f1tenth", odometry_kind="wheel")
    drive(world, [(0.3, 0.0, 0.3), (0.2, 0.1, 0.0), (0.5, 0.0, 0.2)], 2.0)
    moved = world.pose - [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [6.0, 0.0, 0.0]]
    np.testing.assert_allclose(world.estimates.odometry(), moved, atol=0.02)
    world.close()


def test_a_mirrored_robot_stays_where_it_is_put_and_stops_others():
    world = world_of("pioneer3dx", "pioneer3dx", mirrored=[1])
    world.place([1], [[1.2, 0.0, np.pi / 2]])
    drive(world, [(0.4, 0.0)] * 2, 3.5)
    np.testing.assert_array_equal(world.pose[1], [1.2, 0.0, np.pi / 2])
    assert [each[1:3] for each in world.contacts.take()] == [("robot1", "robot2")]
    assert 0.5 < world.pose[0, 0] < 1.0
    world.close()


def test_robots_on_wheels_of_a_team_with_a_boat_use_the_engine():
    world = World(
        ("heron", "pioneer3dx"),
        [[0.0, 5.0, 0.0], [0.0, 0.0, 0.0]],
        fidelity="dynamic",
        engine="planar",
    )
    assert isinstance(world.motion._wheeled._motion, PlanarMotion)
    drive(world, [(0.0, 0.0), (0.3, 0.0)], 1.0)
    world.close()
    assert 0.1 < world.pose[1, 0] < 0.3


def test_a_verdict_takes_slip_from_the_record(tmp_path):
    short = {"fidelity": "dynamic", "engine": "planar", "duration": 6.0}
    verdict = verdict_of(shipped("displacement_formation", **short), tmp_path)
    assert not failed(verdict)
    # Robots that slip start late, and their mean drifts: the published law drifts with them.
    drift = check(verdict, "drift of w^T p")
    assert drift["passed"] and 0.02 < drift["measured"] <= drift["tolerance"]


@pytest.mark.parametrize(
    "team, wanted",
    [
        ({"model": "heron"}, "engine 'planar': no robot stands on wheels; wanted it left out"),
        ({"model": "husky_xarm6"}, "engine 'planar': robots with arms.*wanted engine pybullet"),
    ],
)
def test_robots_that_it_cannot_move_are_refused(team, wanted):
    content = {"robots": 1, "poses": [[0.0, 0.0, 0.0]], "fidelity": "dynamic", "engine": "planar"}
    with pytest.raises(ValueError, match=wanted):
        World.from_scenario(scenario_from_dict({**content, **team}))


def test_the_key_is_read_written_and_refused_where_it_says_nothing():
    plain = {"poses": [[0.0, 0.0, 0.0]], "fidelity": "dynamic", "engine": "planar"}
    scenario = scenario_from_dict(plain)
    assert scenario.to_dict()["engine"] == "planar"
    assert scenario.overridden(engine="pybullet").engine == "pybullet"
    assert scenario.overridden(fidelity="kinematic").to_dict()["engine"] == "pybullet"
    with pytest.raises(ScenarioError, match="engine: planar, but fidelity is kinematic; wanted"):
        scenario_from_dict({**plain, "fidelity": "kinematic"})
    with pytest.raises(ScenarioError, match="engine: 'bullet', wanted one of pybullet, planar"):
        scenario_from_dict({**plain, "engine": "bullet"})


def test_an_obstacle_on_a_track_pushes_a_robot_that_stands():
    track = {"to": [[0.2, 0.0]], "speed": 0.5}
    cart = {"type": "box", "name": "cart", "center": [2.0, 0.0], "size": [0.4, 0.6], "track": track}
    content = {
        "poses": [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
        "fidelity": "dynamic",
        "engine": "planar",
    }
    world = World.from_scenario(scenario_from_dict({**content, "obstacles": [cart]}))
    drive(world, np.zeros((2, 2)), 3.5)
    assert [each[1:3] for each in world.contacts.take()] == [("robot1", "cart")]
    assert world.pose[0, 0] < -0.1 and not world.pose[1, 0]
    world.close()
