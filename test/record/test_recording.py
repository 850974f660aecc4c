"""Recording and reading back, and the verdict on what was recorded."""

import contextlib
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.spatial import upright
from mrs_simulator.protocols.formation import equations as formation
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record import recording
from mrs_simulator.record.recording import (
    Collision,
    Recorder,
    Run,
    RunError,
    closest_approach,
    facts_text,
    part_of,
    read_run_csv,
    write_facts,
)
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.state.columns import TWIST
from mrs_simulator.state.layout import basic_layout, layout_in
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.results.report import judged
from mrs_simulator.verdict import verdict

PRINTED = [[9.95, -5.0, 0.0], [4.95, -2.0, 0.0], [1.95, 8.0, 0.0], [-5.05, 12.3, 0.0]]


AXES = ("linear.x", "linear.y", "angular.z")
COLUMNS = basic_layout().names


def recorded(tmp_path, samples=3, n=2):
    path = str(tmp_path / "run.csv")
    draw = np.random.default_rng(0)
    poses, commands = draw.normal(size=(samples, n, 3)), draw.normal(size=(samples, n, 2))
    with Recorder(path, range(1, n + 1), 0.05) as recorder:
        for index in range(samples):
            recorder.sample(0.1 * index, StateTable(pose=poses[index], command=commands[index]))
    return path, poses, commands


def test_what_is_read_is_what_was_written_to_the_bit(tmp_path):
    path, poses, commands = recorded(tmp_path)
    run = read_run_csv(path)
    np.testing.assert_array_equal(run.pose, poses)
    np.testing.assert_array_equal(run.command, commands)
    np.testing.assert_array_equal(run.hand, hand_points(poses, 0.05))
    np.testing.assert_array_equal(run.time, [0.0, 0.1, 0.2])
    with open(path) as file:
        assert file.readline() == "time,robot,x,y,theta,alpha_x,alpha_y,v,omega\n"


@pytest.mark.parametrize("kept", [0, 2, 3])
def test_a_run_that_was_kept_is_the_one_that_is_read(tmp_path, kept):
    path, draw = str(tmp_path / "run.csv"), np.random.default_rng(0)
    layout = layout_in([*basic_layout(AXES).names, *TWIST.csv, "joint"])._replace(
        kinds=("a,b", "c  d")
    )
    with Recorder(path, (1, 5), layout=layout, kept=kept) as recorder:
        for index in range(3):
            pose, command, twist = (draw.normal(size=(2, 3)) for _ in range(3))
            columns = {"pose": pose, "command": command, "twist": twist, "joints": pose[:, 0]}
            recorder.sample(0.1 * index, StateTable(**columns, hand=pose[:, :2]))
    write_facts(path, [Collision(0.1, "robot1", "robot5", 0.0, 1.0)], {"deadlock": [(1, 0.2)]})
    kept_run, read = recorder.run(), read_run_csv(path)
    for name, value in vars(read).items():
        if isinstance(value, np.ndarray):  # sums depend on how arrays lie in memory
            assert getattr(kept_run, name).strides == value.strides
            np.testing.assert_array_equal(getattr(kept_run, name), value)
        else:
            assert getattr(kept_run, name) == value


def test_points_that_are_published_and_hand_points_may_take_turns(tmp_path):
    draw, told = np.random.default_rng(0), {1, 2, 4}
    poses, points = draw.normal(size=(6, 2, 3)), draw.normal(size=(6, 2, 2))
    with Recorder(str(tmp_path / "run.csv"), (1, 2), 0.3, kept=6) as recorder:
        for k in range(6):
            state = StateTable(pose=poses[k], command=points[k])
            recorder.sample(0.1 * k, state.replace(hand=points[k]) if k in told else state)
    for run in (recorder.run(), read_run_csv(str(tmp_path / "run.csv"))):
        for k in range(6):
            wanted = points[k] if k in told else hand_points(poses[k], 0.3)
            np.testing.assert_array_equal(run.hand[k], wanted)


def test_a_run_of_other_robots_keeps_all_axes_and_their_own_points(tmp_path):
    path = str(tmp_path / "run.csv")
    draw = np.random.default_rng(0)
    poses, commands, points = (draw.normal(size=(3, 2, width)) for width in (3, 3, 2))
    with Recorder(path, (1, 2), 0.05, layout=basic_layout(AXES)) as recorder:
        for index in range(3):
            columns = {"pose": poses[index], "command": commands[index], "hand": points[index]}
            recorder.sample(0.1 * index, StateTable(**columns))
    run = read_run_csv(path)
    assert run.axes == AXES
    np.testing.assert_array_equal(run.command, commands)
    np.testing.assert_array_equal(run.hand, points)
    np.testing.assert_array_equal(run.pose, poses)
    with open(path) as file:
        assert file.readline() == (
            "time,robot,x,y,theta,alpha_x,alpha_y,linear.x,linear.y,angular.z\n"
        )


@pytest.mark.parametrize(
    "columns",
    ["", ",linear.y,linear.x", ",linear.x,linear.x", ",speed", ",linear.x,angular.z", ",v"],
)
def test_columns_that_are_no_axes_are_refused(tmp_path, columns):
    path = tmp_path / "run.csv"
    header = "time,robot,x,y,theta,alpha_x,alpha_y" + columns
    path.write_text(header + "\n" + ",".join(["0.0", "1"] + ["0.0"] * header.count(",")) + "\n")
    with pytest.raises(RunError, match="line 1: .*wanted the columns"):
        read_run_csv(str(path))


def test_a_run_cut_off_anywhere_keeps_its_whole_samples(tmp_path):
    path, poses, _ = recorded(tmp_path)
    with open(path, "rb") as file:
        content = file.read()
    one = content.index(b"\n0.1,") + 1
    for end in range(one, len(content)):
        with open(path, "wb") as file:
            file.write(content[:end])
        run = read_run_csv(path)
        np.testing.assert_array_equal(run.pose[0], poses[0])


@pytest.mark.parametrize(
    "text, said",
    [
        ("a,b\n1,2\n", "line 1: .*wanted the columns"),
        ("", "line 1: '', wanted the columns"),
        (",".join(COLUMNS) + "\n", "holds no sample"),
        (",".join(COLUMNS) + "\n0,1,x,0,0,0,0,0,0\n0,2,0,0,0,0,0,0,0\n", "line 2: 0,1,x"),
        (",".join(COLUMNS) + "\n0,1,nan,0,0,0,0,0,0\n0,2,0,0,0,0,0,0,0\n", "finite numbers"),
        (",".join(COLUMNS) + "\n0,1,0,0,0,0,0,0,0\n0,1,0,0,0,0,0,0,0\n", "wanted each number once"),
        (",".join(COLUMNS) + "\n0,1,0,0,0,0,0,0,0\n1,2,0,0,0,0,0,0,0\n", "each time once"),
    ],
)
def test_files_that_are_no_recording(tmp_path, text, said):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(RunError, match=said):
        read_run_csv(str(path))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_collisions_are_indented_as_json_indents_them(count):
    strange = 'a],\n      ["\u00e9'
    collisions = [
        Collision(1.0, "robot1", "crate", 0.5, -1e-7),
        Collision(2.5, strange, strange, 0.0, 1e22, 0.25),
        Collision(3, "robot2", "robot3", -0.0, 1 / 3),
    ][:count]
    rows = [[c.time, c.first, c.second, *c.place] for c in collisions]
    facts = {"ended": "complete", "warnings": [], "collisions": rows}
    text = facts_text(collisions, {"ended": "complete", "warnings": []})
    assert text == json.dumps(facts, indent=2) + "\n"
    with pytest.raises(ValueError):
        facts_text([Collision(math.nan, "robot1", "robot2", 0.0, 0.0)])


def test_what_is_written_of_a_run_is_read_back(tmp_path):
    path, _, _ = recorded(tmp_path)
    assert read_run_csv(path).meta == {"collisions_unknown": True}
    collisions = [Collision(1.0, "robot1", "crate", 0.5, 0.0)]
    meta = {"ended": "interrupted", "warnings": ["slow"], "closest_approach": 0.25}
    write_facts(path, collisions, dict(meta, real_time_factor=np.inf))
    run = read_run_csv(path)
    assert (run.collisions, run.meta) == (collisions, meta)
    recorded(tmp_path)  # another run in the same place
    assert read_run_csv(path).meta == {"collisions_unknown": True}


@pytest.mark.parametrize(
    "text, said",
    [
        ("{", "run.json: not the facts of a run: JSONDecodeError"),
        ("[]", "run.json: not the facts of a run"),
        ('{"ended": "complete"}', "KeyError: 'collisions'"),
        ('{"collisions": [[1.0, "robot1"]]}', "run.json: not the facts of a run: ValueError"),
        ('{"collisions": [], "colour": 1}', "run.json: unknown 'colour' \\(known"),
        ('{"collisions": [], "warnings": "slow"}', "run.json: warnings = 'slow', wanted a list"),
    ],
)
def test_files_that_tell_of_no_run(tmp_path, text, said):
    path, _, _ = recorded(tmp_path)
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(RunError, match=said):
        read_run_csv(path)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=120))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("fuzz") / "run.csv"
    path.write_bytes(",".join(COLUMNS).encode() + b"\n" + content)
    with contextlib.suppress(RunError):
        read_run_csv(str(path))


def theory_run(duration=90.0, k=0.02, collisions=(), change=None):
    """The paper's four robots as the closed recursion moves them, one sample per step."""
    scenario = scenario_from_dict(
        {
            "poses": PRINTED,
            "fidelity": "point_mass",
            "limits": "none",
            "duration": duration,
            "control": {"rate": 10, "parameters": {"k": 0.02}},
        }
    )
    steps = int(round(duration * 10))
    offsets = formation.line_offsets(4, 2.0)
    hand = formation.predict(
        hand_points(scenario.poses, 0.05), offsets, formation.closure_topology("chain", 4), k, steps
    )
    if change is not None:
        hand = change(hand)
    pose = np.concatenate([hand, np.zeros_like(hand[:, :, :1])], axis=2)
    time = 0.1 * np.arange(steps + 1)
    return Run(time, np.arange(1, 5), pose, hand, np.zeros_like(hand), list(collisions), scenario)


def judge(run):
    return judged(run, make_control(run.scenario))[0]


def test_a_run_as_predicted_passes_with_typed_out_measures():
    result = judge(theory_run())
    assert result["passed"], verdict.verdict_text(result)
    assert result["settle_time"] == pytest.approx(34.8)
    assert result["min_distance"] == pytest.approx(2.0, abs=1e-3)
    np.testing.assert_allclose(result["final_gaps"], 2.0, atol=1e-3)
    wanted = {
        "name",
        "question",
        "predicted",
        "measured",
        "tolerance",
        "passed",
        "difference",
        "note",
    }
    assert set(result["checks"][0]) == wanted


@pytest.mark.parametrize(
    "run, failed",
    [
        (theory_run(duration=30.0), None),
        (theory_run(k=0.01), "settling time [s]"),
        (theory_run(collisions=[Collision(1.0, "robot1", "robot2", 0.0, 0.0)]), "collisions"),
        (theory_run(change=lambda hand: hand + [0.0, 1.0]), None),
        (
            theory_run(change=lambda hand: hand * [1.0, 1.0 + 0.001 * np.arange(4)][1][:, None]),
            "y spread [m]",
        ),
        (theory_run()._replace(meta={"ended": "interrupted"}), "ended"),
    ],
)
def test_a_run_that_is_not_as_predicted_fails(run, failed):
    result = judge(run)
    names = [check["name"] for check in result["checks"] if check["passed"] is False]
    if failed is None:
        assert not names
    else:
        assert failed in names and not result["passed"]


def test_a_verdict_is_valid_json(tmp_path):
    path = str(tmp_path / "verdict.json")
    alone = scenario_from_dict({"poses": [[0, 0, 0]], "duration": 1.0})
    run = Run(
        np.array([0.0, 1.0]),
        np.array([1]),
        np.zeros((2, 1, 3)),
        np.zeros((2, 1, 2)),
        np.zeros((2, 1, 2)),
        [],
        alone,
    )
    verdict.write_verdict(judge(run), path)
    with open(path) as file:
        read = json.load(file)
    assert read["min_distance"] is None and read["final_gaps"] == [] and read["passed"]


def test_closest_approach():
    pose = np.zeros((2, 3, 3))
    pose[0, :, 0] = [0.0, 3.0, 7.0]
    pose[1, :, 0] = [0.0, 2.5, 7.0]
    assert closest_approach(pose) == 2.5
    assert closest_approach(pose[:, :1]) == math.inf


def test_a_part_of_a_run_has_all_of_its_samples():
    ones, rows = np.arange(4.0)[:, np.newaxis], slice(1, 3)
    many = ones[..., np.newaxis] * np.ones(3)
    run = Run(
        ones[:, 0], np.array([1]), many, many[..., :2], many[..., :2], twist=many, joints=ones,
        spatial=upright(ones, ones), point_z=ones,
    )  # fmt: skip
    part = part_of(run, rows)
    assert (
        part.joints.tolist() == part.point_z.tolist() == part.spatial.z.tolist() == [[1.0], [2.0]]
    )
    assert {len(each) for each in (part.time, part.pose, part.twist, *part.spatial)} == {2}
    assert part_of(run._replace(joints=None, spatial=None), rows).spatial is None


def test_a_file_of_many_blocks_is_read_as_one(tmp_path, monkeypatch):
    path, poses, _ = recorded(tmp_path, samples=40, n=5)
    monkeypatch.setattr(recording, "BLOCK", 500)
    np.testing.assert_array_equal(read_run_csv(path).pose, poses)
    with open(path, "a") as file:
        file.write("9.0,1,0.5,0.")  # killed while it wrote
    np.testing.assert_array_equal(read_run_csv(path).pose, poses)
    with open(path, "a") as file:
        file.write("\n9.1,1,0,0,0,0,0,0,0\n")
    with pytest.raises(RunError, match="line 202: 9.0,1,0.5"):
        read_run_csv(path)
