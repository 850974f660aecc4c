"""The state of a team: declared columns, absent ones, groups, samples, and rows of numbers."""

import numpy as np
import pytest

from mrs_simulator.core.spatial import upright
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.state.columns import COLUMNS, LOAD, POSE, RECORDED, SPATIAL, LoadState, Z
from mrs_simulator.state.layout import Layout, layout_in
from mrs_simulator.state.state_table import StateTable, stacked
from mrs_simulator.vehicles import Team


def test_a_column_that_robots_do_not_have_is_absent():
    pose = np.zeros((2, 3))
    state = StateTable(0.5, pose=pose, z=None, load=None)
    assert state.pose is pose and state[POSE] is pose and not state.has(Z) and not state.has(LOAD)
    with pytest.raises(AttributeError, match="no z in this state, which has time, .*pose"):
        assert state.z
    assert not state.replace(pose=None).has(POSE) and state.has(POSE)
    with pytest.raises(TypeError, match="unknown 'poses'; did you mean 'pose'"):
        state.replace(poses=pose)


def test_groups_are_given_and_read_as_their_named_tuples():
    spatial = upright([0.1, 0.2], 1.5)
    state = StateTable(spatial=spatial)
    assert state.has(SPATIAL) and state.z is spatial.z
    assert all(got is given for got, given in zip(state.spatial, spatial))
    assert not state.replace(z=None).has(SPATIAL) and not state.replace(spatial=None).has(Z)


def test_samples_of_states_that_were_stacked():
    states = [StateTable(t, pose=np.full((2, 3), t), z=np.full(2, 2 * t)) for t in (0.0, 1.0, 2.0)]
    table = stacked([*states, StateTable(3.0, pose=np.zeros((2, 3)))])
    assert table.pose.shape == (4, 2, 3) and not table.has(Z)
    table = stacked(states)
    assert table.at(1).time == 1.0 and table.at(slice(1, None)).z.tolist() == [[2.0] * 2, [4.0] * 2]


def test_columns_lie_in_rows_as_their_layout_says():
    draw = np.random.default_rng(0)
    force, place, turn = (draw.normal(size=shape) for shape in ((2, 3), 3, 4))
    state = StateTable(pose=draw.normal(size=(2, 3)), command=draw.normal(size=(2, 1)))
    state = state.replace(joints=draw.normal(size=2), load=LoadState(place, turn, force))
    layout, table = Layout.of_state(state, RECORDED), np.empty((1, 2, 15))
    assert layout.width == 15
    for name, at in layout.places().items():
        table[0, :, at] = getattr(state, name)
    columns = layout.columns_of(table)
    for name in columns:
        np.testing.assert_array_equal(columns[name][0], getattr(state, name))


def test_columns_of_one_rule_come_together():
    scenario = scenario_from_dict({"poses": [[0, 0, 0]]})
    layout = Team(["crazyflie2"]).layout(lambda column: column.given(scenario))
    assert layout_in(layout.names).names == layout.names
    gone = [name for name in layout.names if name != "alpha_z"]
    assert layout_in(gone) is None  # one of several that come together


def test_names_are_those_of_columns():
    assert all(name == column.name for name, column in COLUMNS.items())
    csv = [name for column in RECORDED for name in column.names(2, ("linear.x",))]
    assert len(set(csv)) == len(csv)


def test_the_page_has_the_declared_columns():
    import os
    import runpy

    docs = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(__file__))), "docs")
    made = runpy.run_path(os.path.join(docs, "make_columns.py"))
    with open(os.path.join(docs, "scenarios.md"), encoding="utf-8") as page:
        text = page.read()
    assert made["with_table"](text) == text, "python3 docs/make_columns.py brings it up to date"
