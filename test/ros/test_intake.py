"""Which messages are believed to tell where a robot is now."""

import itertools
import math

import pytest

from mrs_simulator.ros.receive.intake import LEARNING, Intake


def simulated(timeout=0.5):
    return Intake([False], timeout)


def heard(intake, stamps, arrivals):
    """Return which messages of robot 0, stamped and arrived at these times [s], are believed."""
    return [intake.accepts_stamp(0, *each) for each in zip(stamps, itertools.repeat(0.0), arrivals)]


def steady(intake, clock=0.0, messages=10):
    """Hear a real robot at 10 Hz, whose clock is ahead by ``clock`` [s]; return when it ends."""
    times = [100.0 + 0.1 * k for k in range(messages)]
    assert heard(intake, [t + clock for t in times], times) == [False] + [True] * (messages - 1)
    assert intake.refused == [0]
    return times[-1]


@pytest.mark.parametrize(
    "stamp, said",
    [
        (5.0, "stamped 5 s before the simulated time"),
        (9.4, "stamped 0.6 s before"),
        (0.0, "stamped 10 s before"),
        (1e-9, "stamped 10 s before"),
        (3976214400.0, "after the simulated time"),
    ],
)
def test_stamps_are_compared_with_simulated_time(stamp, said):
    intake = simulated()
    assert not intake.accepts_stamp(0, stamp, 10.0, 1.0)
    assert intake.refused == [1] and said in intake.reasons[0]
    assert intake.accepts_stamp(0, 9.9, 10.0, 1.0) and intake.reasons == {}


def test_no_simulated_time_yet_refuses_nothing():
    assert simulated().accepts_stamp(0, 1.0, 0.0, 1.0)


def test_a_message_overtaken_by_another_is_refused_and_a_new_clock_is_not():
    intake = simulated()
    assert intake.accepts_stamp(0, 10.0, 10.0, 1.0)
    assert intake.accepts_stamp(0, 10.0, 10.0, 1.0)  # lockstep tells the same again
    assert not intake.accepts_stamp(0, 9.98, 10.0, 1.0)
    assert intake.accepts_stamp(0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize("clock", [0.0, 3600.0, -7.0])
def test_the_first_messages_show_how_a_real_robots_clock_is_set(clock):
    intake = Intake([True], 0.5)
    last = steady(intake, clock)
    at = last + 1.0
    assert heard(intake, [at + clock - 0.4], [at]) == [True]
    at += 1.0
    assert heard(intake, [at + clock - 0.61], [at]) == [False]
    assert "came 0.61 s late" in intake.reasons[0]
    assert heard(intake, [at + clock + 0.61], [at]) == [False]
    assert "its clock jumped 0.61 s ahead" in intake.reasons[0]
    assert heard(intake, [at + clock], [at]) == [True] and intake.refused == [2]


def test_a_late_first_message_does_not_spoil_the_others():
    intake = Intake([True], 0.5)
    times = [100.0 + 0.1 * k for k in range(LEARNING + 1)]
    assert heard(intake, [90.0] + times[1:], times) == [False] + [True] * LEARNING
    assert heard(intake, [times[-1] + 0.1], [times[-1] + 0.7]) == [False]


def test_clocks_may_drift_apart_but_a_growing_delay_is_seen():
    intake = Intake([True], 0.5)
    times = [100.0 + 10.0 * k for k in range(1000)]
    assert heard(intake, times, [t * (1.0 + 5e-5) for t in times]).count(False) == 1
    intake = Intake([True], 0.5)
    times = [100.0 + 0.1 * k for k in range(200)]
    assert heard(intake, times, [t + 0.05 * (t - 100.0) for t in times])[-1] is False
    assert "late" in intake.reasons[0]


@pytest.mark.parametrize(
    "stamps, said",
    [
        ([0.0, 0.0, 0.0], "its stamp is not set"),
        ([1e-9, 1e-9, 1e-9], "its stamp is not set"),
        ([5.0, 5.0, 5.0], "its stamp stands still"),
        ([5.0, 4.9, 4.8], "its stamp went back"),
        ([3976214400.0] * 3, "its stamp stands still"),
    ],
)
def test_a_real_robots_stamps_must_go_on(stamps, said):
    intake = Intake([True], 0.5)
    assert heard(intake, stamps, [100.0, 100.1, 100.2]) == [False] * 3
    assert said in intake.reasons[0] and intake.refused[0] >= 2


def test_a_person_may_say_that_a_clock_is_right():
    intake = Intake([True], 0.5)
    last = steady(intake)
    assert heard(intake, [5.0], [last + 1.0]) == [False]
    intake.forget()
    assert heard(intake, [5.1, 5.2], [last + 1.1, last + 1.2]) == [False, True]


@pytest.mark.parametrize(
    "x, y, length, said",
    [
        (0.0, 0.0, 0.0, "its quaternion has length 0"),
        (0.0, 0.0, 1.2, "its quaternion has length 1.2"),
        (0.0, 0.0, math.nan, "its quaternion has length nan"),
        (1e6, 0.0, 1.0, "at (1e+06, 0) m"),
        (0.0, -2e4, 1.0, "at (0, -2e+04) m"),
        (math.nan, 0.0, 1.0, "at (nan, 0) m"),
        (math.inf, 0.0, 1.0, "at (inf, 0) m"),
    ],
)
def test_places_and_rotations_that_cannot_be(x, y, length, said):
    intake = Intake([True], 0.5)
    assert not intake.accepts_place(0, x, y, length) and intake.reasons == {0: said}
    assert intake.accepts_place(0, 5.0, -5.0, 1.0)
    assert Intake([False], 0.5).accepts_place(0, 2e4, 0.0)  # a simulated robot may be far


@pytest.mark.parametrize("z", [math.nan, math.inf, -1e6])
def test_heights_that_cannot_be(z):
    intake = Intake([True], 0.5)
    assert not intake.accepts_place(0, 0.0, 0.0, z=z)
    assert intake.reasons == {0: "at a height of {:.4g} m".format(z)}
    assert intake.accepts_place(0, 0.0, 0.0, z=30.0)


def test_frames_are_asked_for_once():
    asked = []

    def wanted(row, frame):
        asked.append(frame)
        return "" if frame == "odom" else "odom"

    intake = Intake([True], 0.5, wanted)
    assert intake.accepts_frame(0, "odom") and intake.accepts_frame(0, "odom")
    assert not intake.accepts_frame(0, "map") and asked == ["odom", "map"]
    assert intake.reasons == {0: "in frame 'map', wanted odom"}
    assert not intake.accepts_frame(0, "x" * 10**6) and len(intake.reasons[0]) < 200
