"""Whose answers a stage in lockstep waits for."""

from mrs_simulator.nodes.stage.lockstep import LOOK, QUIET, Lockstep


def test_a_second_answer_to_odometry_that_was_said_again_is_none_to_the_next():
    now = [0.0]
    lockstep = Lockstep(1.0, clock=lambda: now[0])
    lockstep.expect([0, 1])
    lockstep.answered([0, 1])
    assert lockstep.may_go_on()
    lockstep.expect([0, 1])
    lockstep.answered([0])
    assert not lockstep.may_go_on() and not lockstep.overdue()
    now[0] = 1.5
    assert lockstep.overdue() and lockstep.waiting_for == [1]
    lockstep.answered([1])
    looks = int(QUIET / LOOK)
    for _ in range(3):  # as long as there are more of them
        now[0] += 9.0  # in which the stage itself was held up, and received nothing
        for _ in range(looks - 1):
            assert not lockstep.may_go_on()
            now[0] += LOOK
        lockstep.answered([0, 1])
    for _ in range(looks + 2):
        now[0] += LOOK
        settled = lockstep.may_go_on()
    assert settled
    lockstep.expect([0, 1])
    lockstep.answered([0, 1])
    assert lockstep.may_go_on()
