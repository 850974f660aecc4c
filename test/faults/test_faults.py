"""The quick part of the fault matrix, and that its judgements can fail."""

import json

import bench
import motion
import pytest
import table


@pytest.mark.processes
@pytest.mark.parametrize("row", [row for row in table.ROWS if row.quick], ids=lambda row: row.name)
def test_robots_bear_the_fault(row):
    assert bench.run(row) == ""


def test_the_matrix_names_each_trial_once():
    names = [row.name for row in table.ROWS]
    assert len(set(names)) == len(names)
    assert {row.victim for row in table.ROWS} == {
        "stage", "control", "recorder", "GUI", "master", "driver",
    }  # fmt: skip
    assert 0.05 < sum(row.quick for row in table.ROWS) / len(names) < 0.2


def motion_of(tmp_path, samples):
    """Return the motion of two robots at ``samples`` of (stamp, x)."""
    path = tmp_path / "motion.jsonl"
    lines = [json.dumps([stamp + 7.0, stamp, [x, x], [0.0, 3.0]]) for stamp, x in samples]
    path.write_text("\n".join(lines) + "\n" + lines[0][:5])
    return motion.Motion(str(path))


def test_motion_is_judged_by_where_robots_are(tmp_path):
    driving = motion_of(tmp_path, [(0.1 * k, 0.02 * k) for k in range(50)])
    assert driving.moves() and driving.too_fast() == "" and driving.creep() > 0.9
    standing = motion_of(tmp_path, [(0.1 * k, 1.0) for k in range(50)])
    assert not standing.moves() and standing.creep() == 0.0
    assert not motion_of(tmp_path, [(1.0, 0.02 * k) for k in range(50)]).moves()
    jump = motion_of(tmp_path, [(0.1 * k, 0.02 * k + 0.1 * (k > 30)) for k in range(50)])
    assert jump.too_fast() == "0.120 m in 0.100 s at 3.00 s"
    again = motion_of(tmp_path, [(0.1 * (k % 25), 0.02 * (k % 25)) for k in range(50)])
    assert again.too_fast() == "" and len(again.lives()) == 2
    assert "not finite" in motion_of(tmp_path, [(0.0, 0.0), (0.1, float("nan"))]).too_fast()
