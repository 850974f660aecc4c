"""What the preflight says of measured poses, and of the paths predicted from them."""

import math

import numpy as np
import pytest

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run import preflight

LINE = {
    "poses": [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 4.0, 0.0]],
    "control": {"parameters": {"k": 0.05, "c": 1.5, "l": 0.2}},
    "duration": 20,
}


def scenario(**changes):
    return scenario_from_dict(dict(LINE, **changes))


def passed(checks):
    return [check.passed for check in checks]


def test_who_publishes_and_who_is_fresh():
    names = ["/robot{}/odom".format(n) for n in (1, 2, 3)]
    checks = preflight.reception_checks((1, 2, 3), (0.1, 0.9, math.inf), 0.5, names)
    assert passed(checks) == [True, True, True, False, False]
    assert "never received on /robot3/odom" in checks[-1].text
    assert checks[3].subject == "robot2 is fresh" and "0.90 s" in checks[3].text


def test_sensors_are_received_or_named():
    heard = preflight.sensor_check(("sonar", "laser"), "")
    assert heard == ("sensors heard", True, "sonar, laser")
    silent = "no fresh sonar of robot2 (never received)"
    assert preflight.sensor_check(("sonar",), silent) == ("sensors heard", False, silent)


def test_places():
    wanted = scenario().poses
    pose = wanted + [[0.1, 0.1, 0.1], [0.3, 0.1, 0.0], [0.0, 0.0, 0.4]]
    assert passed(preflight.place_checks((1, 2, 3), pose, wanted)) == [True, False, False]
    pose[1] = np.nan
    assert passed(preflight.place_checks((1, 2, 3), pose, wanted, 0.5)) == [True, True]
    turned = wanted + [0.0, 0.0, 2.0 * math.pi]
    assert all(passed(preflight.place_checks((1, 2, 3), turned, wanted)))


def test_distances_and_fence_name_the_robots():
    pose = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [np.nan] * 3])
    check = preflight.distance_check((1, 2, 3), pose)
    assert not check.passed and "robot1 and robot2 0.60 m apart, wanted 1 m" in check.text
    assert preflight.distance_check((1, 2), pose[:2], 0.5).passed
    check = preflight.fence_check((1, 2, 3), pose, (-1.0, -1.0, 0.5, 1.0))
    assert not check.passed and "robot2 at (0.60, 0.00, 0.00) outside" in check.text


def test_nothing_is_said_to_be_right_of_robots_whose_place_is_not_known():
    unknown, fence = np.full((3, 3), np.nan), (-1.0, -1.0, 1.0, 1.0)
    for pose in (unknown, np.vstack([np.zeros(3), unknown])):
        numbers = range(1, len(pose) + 1)
        for check in (
            preflight.distance_check(numbers, pose, 0.5),
            preflight.fence_check(numbers, pose, fence),
        ):
            assert not check.passed and "not checked: not all poses are known" in check.text
    assert preflight.distance_check((1,), unknown[:1]).passed


@pytest.mark.parametrize(
    "changes, speeds, ok",
    [
        ({}, (math.inf, math.inf), True),
        ({"limits": "none"}, (math.inf, math.inf), False),
        ({"limits": "none"}, (0.2, math.inf), False),
        ({"limits": "none"}, (0.2, 0.5), True),
        ({"fidelity": "point_mass"}, (math.inf, math.inf), False),
        ({"control": {"saturation": "none"}}, (math.inf, math.inf), False),
        ({"limits": {"v_max": 0.3, "omega_max": 1.0}}, (math.inf, math.inf), True),
    ],
)
def test_speeds_are_to_be_limited(changes, speeds, ok):
    assert preflight.speed_check(scenario(**changes), speeds).passed is ok


def test_predicted_paths_that_keep_to_the_bounds():
    fence = (-1.0, -1.0, 4.0, 5.0)
    checks = preflight.predicted_checks(scenario(), scenario().poses, 1.0, fence)
    assert passed(checks) == [True, True], checks


def test_predicted_paths_that_do_not():
    pose = scenario().poses
    fence, least = (-1.0, -1.0, 2.0, 5.0), 1.9
    checks = preflight.predicted_checks(scenario(), pose, least, fence)
    assert passed(checks) == [False, False]
    assert "wanted 1.9 m" in checks[0].text and "robot1 leaves it at (2.0" in checks[1].text


def test_what_cannot_be_predicted_is_said():
    pose = scenario().poses
    pose[1] = pose[0]
    (check,) = preflight.predicted_checks(scenario(), pose)
    assert not check.passed and "not predicted: " in check.text and "robot" in check.text
    pose[1] = np.nan
    (check,) = preflight.predicted_checks(scenario(), pose)
    assert not check.passed and "not all poses are known" in check.text


def test_the_table():
    checks = [preflight.Check("a", True, "x"), preflight.Check("bcd", False, "y")]
    assert preflight.table(checks) == "OK      a    x\nNOT OK  bcd  y"


def test_rows_for_other_programs():
    pose = scenario().poses + [[0.5, 0.0, 0.0], [0.0] * 3, [0.0] * 3]
    placed = preflight.place_checks((1, 2, 3), pose, scenario().poses)
    far, lost = preflight.as_rows([placed[0], preflight.Check("poses", False, "robot2 unknown")])
    assert (far["robot"], far["what"], far["passed"]) == ("robot1", "stands in place", False)
    assert far["wanted"] == "at most 0.3 m and rad" and far["value"].startswith(
        "at (0.50, 0.00, 0.00), 0.50 m"
    )
    assert (lost["robot"], lost["what"], lost["wanted"]) == ("", "poses", "")
    assert far["judged"] and not lost["judged"]
