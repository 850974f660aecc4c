"""What a controller said during a run, as the reader of its verdict is told."""

import pytest

from mrs_simulator.record.controller_log import EMERGENCY, Interruptions, failure


def told(*statuses):
    controller = Interruptions()
    for stamp, running, trouble in statuses:
        controller.note(stamp, running, trouble)
    return controller


@pytest.mark.parametrize(
    "statuses, said",
    [
        ([], []),
        ([(0.5, False, "not started"), (1.02, True, "")], []),
        ([(0.5, False, "not started"), (2.0, True, "")], ["1 time, 1.0 s in all: not started"]),
        ([(1.0, True, ""), (3.0, True, "no odometry"), (4.5, True, "")], ["1 time, 1.5 s"]),
        ([(1.0, True, ""), (8.0, False, "")], ["1 time, 3.0 s in all: stopped"]),
        ([(1.0, True, ""), (12.0, False, "late")], []),
        (
            [
                (2.0, True, "a"),
                (3.0, True, "b"),
                (4.0, True, ""),
                (5.0, True, "c"),
                (6.0, True, ""),
            ],
            ["2 times, 3.0 s in all: a; c"],
        ),
        (
            [(1.0, True, ""), (8.0, False, "asked to"), (9.0, False, EMERGENCY)],
            ["3.0 s in all: emer"],
        ),
    ],
)
def test_what_is_said_of_a_run_from_1_to_11_s(statuses, said):
    warnings = told(*statuses).warnings(1.0, 11.0)
    assert len(warnings) == len(said)
    assert all(part in warning for part, warning in zip(said, warnings)), warnings


@pytest.mark.parametrize(
    "later, said",
    [
        ([], "at 2.000 s emergency stop"),
        ([(8.0, False, "the emergency stop was released")], "at 2.000 s emergency stop"),
        ([(8.0, True, "")], ""),
        ([(8.0, True, ""), (9.0, False, "asked to"), (9.5, False, EMERGENCY)], "at 8.500 s emer"),
        ([(8.0, True, ""), (11.0, False, EMERGENCY)], ""),
    ],
)
def test_an_emergency_stop_ends_a_run_from_1_to_11_s_unless_it_goes_on(later, said):
    controller = told((1.0, True, ""), (3.0, False, EMERGENCY), *later)
    ended = controller.emergency(1.0, 11.0)
    assert ended.startswith(said) and bool(ended) is bool(said)


def test_a_failed_law_is_known_until_it_runs_again():
    broken = failure(ValueError("no"))
    assert broken == "the law failed: ValueError: no"
    assert told((1.0, True, ""), (2.0, False, broken)).failed() == (2.0, broken)
    assert told((2.0, False, broken), (3.0, True, "")).failed() is None
    assert told().failed() is None
