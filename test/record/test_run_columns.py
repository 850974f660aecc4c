"""The columns of run.csv: which ones a team needs, what is in them, and what is refused."""

import csv

import numpy as np
import pytest

from mrs_simulator.core.spatial import Spatial, headings, turned_about_z, upright
from mrs_simulator.record.recording import Collision, Recorder, RunError, read_run_csv, write_facts
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.state.layout import basic_layout, layout_in
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles import Team

COMMANDS = ("linear.x", "linear.y", "angular.z")
PLACE = ("time", "robot", "x", "y", "theta", "alpha_x", "alpha_y")
COLUMNS = PLACE + ("v", "omega")
TWIST = ("twist.linear.x", "twist.linear.y", "twist.angular.z")
SPACE = ("z", "orientation.x", "orientation.y", "orientation.z", "orientation.w", "alpha_z")
SPACE += ("twist.linear.z", "twist.angular.x", "twist.angular.y")
KINDS = "crazy, fly", 'a "b"'
FLYING = layout_in(PLACE + ("linear.x", "linear.z", *TWIST, "joint", *SPACE))._replace(kinds=KINDS)


def scenario_of(kinds):
    poses = [[2.0 * place, 0.0, 0.0] for place in range(len(kinds))]
    return scenario_from_dict({"poses": poses, "kind": kinds})


@pytest.mark.parametrize(
    "kinds, names",
    [
        (["pioneer3dx"] * 2, COLUMNS),
        (["epuck"] * 2, COLUMNS + ("kind",)),
        (["pioneer3dx", "husky"], COLUMNS + ("kind",)),
        (["robotino3"] * 2, PLACE + COMMANDS + TWIST + ("kind",)),
        (["f1tenth", "pioneer3dx"], COLUMNS[:7] + ("v", "omega") + TWIST + ("joint", "kind")),
        (["f1tenth", "robotino3"], PLACE + COMMANDS + TWIST + ("joint", "kind")),
    ],
)
def test_a_team_has_the_columns_that_it_needs(kinds, names):
    layout = Team(kinds).layout(lambda column: column.given(scenario_of(kinds)))
    assert layout.names == names and layout.kinds in ((), tuple(kinds))
    assert layout_in(names).names == names


def test_the_columns_of_robots_that_leave_the_ground():
    assert FLYING.names[7:] == (
        *("linear.x", "linear.z", *TWIST, "joint"),
        *("z", "orientation.x", "orientation.y", "orientation.z", "orientation.w", "alpha_z"),
        *("twist.linear.z", "twist.angular.x", "twist.angular.y", "kind"),
    )
    assert layout_in(FLYING.names)._replace(kinds=FLYING.kinds) == FLYING


def flight(path, samples=3):
    """Write a run of two robots with all columns; return the blocks that were written."""
    draw = np.random.default_rng(1)
    blocks = [draw.normal(size=(samples, 2, width)) for width in (3, 2, 2, 3, 1, 1, 4, 3, 1)]
    pose, command, points, twist, joints, z, orientation, rest, point_z = blocks
    with Recorder(path, (1, 2), layout=FLYING) as recorder:
        for k in range(samples):
            columns = {"pose": pose[k], "command": command[k], "hand": points[k], "twist": twist[k]}
            columns["spatial"] = Spatial(z[k, :, 0], orientation[k], rest[k])
            columns.update(joints=joints[k, :, 0], point_z=point_z[k, :, 0])
            recorder.sample(0.1 * k, StateTable(**columns))
    return blocks


def test_all_columns_there_and_back_to_the_bit(tmp_path):
    path = str(tmp_path / "run.csv")
    pose, command, points, twist, joints, z, orientation, rest, point_z = flight(path)
    collision = Collision(0.1, "robot1", "robot2", 1.0, 2.0, 3.0)
    write_facts(path, [collision])
    run = read_run_csv(path)
    assert run.axes == FLYING.axes and run.kinds == FLYING.kinds and run.collisions == [collision]
    for came, wrote in (
        (run.pose, pose),
        (run.command, command),
        (run.hand, points),
        (run.twist, twist),
        (run.joints, joints[:, :, 0]),
        (run.spatial.z, z[:, :, 0]),
        (run.spatial.orientation, orientation),
        (run.spatial.twist, rest),
        (run.points, np.concatenate([points, point_z], axis=2)),
    ):
        np.testing.assert_array_equal(came, wrote)


def test_joints_of_arms_there_and_back_to_the_bit(tmp_path):
    path, joints = str(tmp_path / "run.csv"), np.random.default_rng(2).normal(size=(3, 2, 6))
    layout = layout_in([*COLUMNS, "joint", *map("joint.{}".format, range(2, 7)), "kind"])
    layout, zeros = layout._replace(kinds=("husky", "husky")), np.zeros((2, 3))
    with Recorder(path, (1, 2), layout=layout) as recorder:
        for k in range(3):
            state = StateTable(pose=zeros, command=zeros[:, :2], joints=joints[k])
            recorder.sample(0.1 * k, state)
    assert layout.names[-8:] == ("omega", "joint", *map("joint.{}".format, range(2, 7)), "kind")
    np.testing.assert_array_equal(read_run_csv(path).joints, joints)
    assert layout_in(("time", *layout.names[1:-2], "joint.7", "kind")) is None


def test_other_programs_read_names_with_commas_and_quotes(tmp_path):
    path = str(tmp_path / "run.csv")
    flight(path)
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows[:2]] == list(FLYING.kinds)


def test_a_kind_may_be_called_anything(tmp_path):
    path = str(tmp_path / "run.csv")
    layout = basic_layout()._replace(kinds=("Mein Röbi", "two\nlines\t of it"))
    with Recorder(path, (1, 2), layout=layout) as recorder:
        recorder.sample(0.0, StateTable(pose=np.zeros((2, 3)), command=np.zeros((2, 2))))
    assert read_run_csv(path).kinds == ("Mein Röbi", "two lines of it")


def test_a_file_cut_off_anywhere_keeps_its_whole_samples(tmp_path):
    path = tmp_path / "run.csv"
    pose = flight(str(path), samples=2)[0]
    content = path.read_bytes()
    for end in range(content.index(b"\n0.1,") + 1, len(content)):
        path.write_bytes(content[:end])
        run = read_run_csv(str(path))
        assert len(run.time) == 1 and run.kinds == FLYING.kinds
        np.testing.assert_array_equal(run.pose[0], pose[0])


def test_half_a_number_at_the_end_is_not_believed(tmp_path):
    path = tmp_path / "run.csv"
    text = ",".join(COLUMNS) + "\n0.0,1,0,0,0,0,0,0.5,0.25\n0.1,1,0,0,0,0,0,0.5,0.25"
    path.write_text(text)
    assert len(read_run_csv(str(path)).time) == 1
    path.write_text(text + "\n")
    assert len(read_run_csv(str(path)).time) == 2


@pytest.mark.parametrize(
    "lines, said",
    [
        ("0,1,0,0,0,0,0,0,0,a\n0,2,0,0,0,0,0,0,0,b\n1,1,0,0,0,0,0,0,0,b\n1,2,0,0,0,0,0,0,0,b\n",
         "one kind for each robot"),
        ("0,1,0,0,0,0,0,0,0\n0,2,0,0,0,0,0,0,0,b\n", "line 2: .*wanted 9 finite numbers and a kind"),
        ('0,1,0,0,0,0,0,0,0,"a\n0,2,x,0,0,0,0,0,0,b\n1,1,\n', "line 3: .*wanted 9 finite numbers"),
    ],
)  # fmt: skip
def test_kinds_that_do_not_fit_are_refused(tmp_path, lines, said):
    path = tmp_path / "run.csv"
    path.write_text(",".join(COLUMNS) + ",kind\n" + lines)
    with pytest.raises(RunError, match=said):
        read_run_csv(str(path))


@pytest.mark.parametrize(
    "names",
    [
        COLUMNS + ("kind", "kind"),
        COLUMNS + ("kind", "joint"),
        COLUMNS + ("twist.linear.x",),
        PLACE + ("linear.x", "linear.z", "z"),
        COLUMNS + ("colour",),
    ],
)
def test_columns_that_are_not_written_are_refused(names):
    assert layout_in(names) is None


def test_a_mixed_run_tells_kinds_twists_and_steering(tmp_path):
    scenario = scenario_from_dict(
        {
            "poses": [[0, 0, 0], [3, 0, 1], [6, 0, 2]],
            "kind": ["f1tenth", "robotino3", "pioneer3dx"],
            "duration": 2.0,
            "control": {"protocol": "consensus"},
            "topology": {"preset": "complete"},
        }
    )
    run_experiment(scenario, str(tmp_path), formats=())
    run = read_run(str(tmp_path / "run.csv"))
    assert run.kinds == scenario.kinds and run.spatial is None
    assert run.twist.shape == run.pose.shape and run.joints.shape == run.pose.shape[:2]
    assert np.abs(run.twist[-1, :, 0]).min() > 0.0 and np.abs(run.twist[:, 2, 1]).max() == 0.0
    assert np.abs(run.joints[:, 0]).max() > 0.0 and np.abs(run.joints[:, 1:]).max() == 0.0
    assert run.points[..., 2].max() == 0.0


def test_quaternions_of_headings():
    angle = np.array([0.0, np.pi / 2, -2.0])
    half = np.sqrt(0.5)
    np.testing.assert_allclose(turned_about_z(angle)[1], [0.0, 0.0, half, half], atol=1e-15)
    np.testing.assert_allclose(headings(turned_about_z(angle)), angle, atol=1e-15)
    # Tilted by 0.3 rad about its own x axis the body still heads to the left.
    c, s = np.cos(0.15), np.sin(0.15)
    tilted = np.array([half * s, half * s, half * c, half * c])
    np.testing.assert_allclose(headings(tilted), np.pi / 2, atol=1e-15)
    state = upright(angle, 2.0)
    assert state.z.tolist() == [2.0] * 3 and not state.twist.any()
    assert state.of(slice(1, 2)).orientation.shape == (1, 4)
