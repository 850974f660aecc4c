"""Who is what in a scenario: groups, kinds of its own, and the keys that were there before."""

import os

import numpy as np
import pytest

from mrs_simulator.scenario.scenario import (
    ScenarioError,
    load_scenario,
    scenario_from_dict,
    scenario_from_yaml,
)
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import World

GROUPS = """
groups:
  - {number: 3, kind: robotino3, layout: line, spacing: 1.5, center: [0.0, 5.0]}
  - {kind: slow, poses: [[1.0, 2.0, 0.5], [3.0, 2.0, 0.0]]}
  - {number: 4, poses: {layout: circle, radius: 2.5}, center: [0.0, -5.0]}
kinds:
  slow: {base: pioneer3dx, limits: {firmware: {linear.x: {max: 0.3 m/s}}}}
"""


def test_groups_say_who_is_what():
    scenario = scenario_from_yaml(GROUPS)
    assert scenario.kinds == ("robotino3",) * 3 + ("slow",) * 2 + ("pioneer3dx",) * 4
    np.testing.assert_allclose(scenario.poses[:3, 0], [1.5, 0.0, -1.5])
    np.testing.assert_allclose(scenario.poses[:3, 1], 5.0)
    np.testing.assert_allclose(scenario.poses[3:5], [[1.0, 2.0, 0.5], [3.0, 2.0, 0.0]])
    np.testing.assert_allclose(np.hypot(*(scenario.poses[5:, :2] - [0.0, -5.0]).T), 2.5)
    team = Team.from_scenario(scenario)
    assert team.axes == ("linear.x", "linear.y", "angular.z")
    assert team.limits.top[3, 0] == 0.3 and team.limits.top[5, 0] == 0.75


def test_a_team_of_groups_is_written_and_read_back():
    scenario = scenario_from_yaml(GROUPS)
    again = scenario_from_yaml(scenario.to_yaml())
    assert again.kinds == scenario.kinds and again.own_kinds == scenario.own_kinds
    np.testing.assert_array_equal(again.poses, scenario.poses)
    assert again.to_yaml() == scenario.to_yaml()
    assert World.from_scenario(again).n == 9


def test_more_robots_are_of_the_last_kind_and_fewer_the_first():
    scenario = scenario_from_yaml(GROUPS)
    assert scenario.with_robots(12).kinds[9:] == ("pioneer3dx",) * 3
    assert scenario.with_robots(4).kinds == ("robotino3",) * 3 + ("slow",)
    assert World.from_scenario(scenario.with_robots(12)).n == 12


def test_kind_means_model():
    poses = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
    one = scenario_from_dict({"poses": poses, "kind": "husky"})
    assert one.kinds == ("husky", "husky") and one.to_dict()["model"] == "husky"
    each = scenario_from_dict({"poses": poses, "kind": ["husky", "epuck"]})
    assert each.kinds == ("husky", "epuck")


def test_kinds_of_a_file_mean_the_same_from_anywhere(tmp_path, monkeypatch):
    (tmp_path / "mine.yaml").write_text("{base: pioneer3dx, mass: 12 kg}")
    (tmp_path / "run.yaml").write_text(
        "groups: [{number: 2, kind: heavy, layout: line}]\nkinds: {heavy: {base: mine.yaml}}\n"
    )
    scenario = load_scenario(str(tmp_path / "run.yaml"))
    assert scenario.own_kinds["heavy"]["base"] == str(tmp_path / "mine.yaml")
    monkeypatch.chdir(os.path.dirname(str(tmp_path)))
    assert Team.from_scenario(scenario_from_yaml(scenario.to_yaml())).kinds[0].mass == 12.0


@pytest.mark.parametrize(
    "content, said",
    [
        ({"groups": []}, "groups: .*, wanted a list of"),
        ({"groups": [{"kind": "husky"}]}, r"groups\[0\].poses: nothing given"),
        ({"groups": [{"layout": "line"}]}, r"groups\[0\].number: nothing given, wanted a whole"),
        ({"groups": [{"number": 2, "layout": "lien"}]}, r"layout: 'lien', wanted one of circle"),
        ({"groups": [{"number": 2, "layout": "line", "radius": 1}]}, "unknown 'radius'"),
        ({"robots": 2, "poses": {"layout": "random", "seed": 1}}, "poses.seed: 1, wanted none"),
        ({"groups": [{"number": 2, "layout": "line", "poses": [[0, 0, 0]]}]}, "poses: given beside layout"),
        ({"groups": [{"number": 2, "layout": "line"}], "robots": 3}, "robots: 3, but groups have 2"),
        ({"groups": [{"number": 2, "layout": "line"}], "model": "husky"}, "model: given beside groups"),
        ({"groups": [{"number": 2, "layout": "line", "kind": 3}]}, r"groups\[0\].kind: 3"),
        ({"groups": [{"number": 20001, "layout": "line"}]}, "number: 20001, wanted"),
        ({"poses": [[0, 0, 0]], "kinds": {"a": 3}}, "kinds.a: 3, wanted a name, and a mapping"),
        ({"poses": [[0, 0, 0]], "kinds": [1]}, "kinds: .*wanted a mapping"),
        ({"poses": [[0, 0, 0]], "kind": "a", "model": "b"}, "model: given beside kind"),
    ],
)  # fmt: skip
def test_a_team_that_cannot_be_is_refused(content, said):
    with pytest.raises(ScenarioError, match=said):
        scenario_from_dict(content)


def test_a_kind_that_is_not_known_is_named_with_its_file(tmp_path):
    path = tmp_path / "run.yaml"
    path.write_text(
        "groups: [{number: 1, kind: huski, layout: line}]\nkinds: {own: {base: epuck}}\n"
    )
    with pytest.raises(ValueError, match="run.yaml: .*unknown 'huski'; did you mean 'husky'"):
        World.from_scenario(load_scenario(str(path)))
