"""The way of the commands to the robots: what passes, and what does not."""

import numpy as np
import pytest

from mrs_simulator.nodes.control import command_gate as module
from mrs_simulator.nodes.control.command_gate import AGAIN, INSISTING, CommandGate, RobotCommands

FORWARD, STAND = np.array([[0.2, 0.0], [0.1, 0.3]]), np.zeros((2, 2))


class Topics:
    """Keeps what is published."""

    def __init__(self):
        self.published = []

    def publish(self, command, answered=None):
        self.published.append(np.array(getattr(command, "command", command)).tolist())


@pytest.fixture
def topics():
    return Topics()


@pytest.fixture
def outlet(topics):
    return CommandGate(topics, 2)


def test_nothing_but_zeros_passes_until_it_is_opened_and_after_it_is_shut(outlet, topics):
    outlet.send(FORWARD)
    outlet.open()
    outlet.send(FORWARD)
    outlet.shut()
    outlet.send(FORWARD)  # of a law that was at work meanwhile
    stand = STAND.tolist()
    assert topics.published == [stand, FORWARD.tolist(), stand, stand]
    assert outlet.command.tolist() == stand


def test_in_an_emergency_it_cannot_be_opened(outlet, topics):
    outlet.open()
    outlet.alarm(True)
    outlet.open()
    outlet.send(FORWARD)
    outlet.alarm(False)
    outlet.send(FORWARD)
    assert not np.any(topics.published)
    outlet.open()
    outlet.send(FORWARD)
    assert topics.published[-1] == FORWARD.tolist()


def test_a_dry_run_publishes_nothing_and_tells_the_command():
    outlet = CommandGate(None, 2)
    outlet.open()
    outlet.send(FORWARD)
    assert outlet.command.tolist() == FORWARD.tolist()


@pytest.mark.parametrize("insists", [True, False])
def test_a_stop_is_said_again_and_again_for_a_while(topics, insists):
    now = [100.0]
    outlet = CommandGate(topics, 2, insists, clock=lambda: now[0])
    outlet.open()
    outlet.insist()  # nobody has moved yet
    outlet.send(FORWARD)
    outlet.insist()
    now[0] += 10.0 * AGAIN
    outlet.insist()  # those that move are not stopped by it
    assert topics.published == [FORWARD.tolist()]
    outlet.send(FORWARD)
    outlet.shut()
    outlet.insist()
    assert len(topics.published) == 3
    now[0] += 1.5 * AGAIN
    outlet.insist()
    assert topics.published[3:] == [STAND.tolist()] * insists
    now[0] += INSISTING
    outlet.insist()
    assert len(topics.published) == 3 + insists


def test_a_new_connection_to_a_real_robot_that_was_driven_begins_with_zeros(monkeypatch):
    firsts = []

    def publisher(_name, _kind, first):
        firsts.append(first)
        return Topics()

    monkeypatch.setattr(module, "prompt_publisher", publisher)
    commands = RobotCommands(["/robot1/cmd_vel", "/robot2/cmd_vel"], real=[1])
    assert firsts[0] is None and firsts[1]() is None
    commands.publish(FORWARD)
    assert firsts[1]().values == (0.0,) * 6


def test_it_shuts_itself_when_a_moving_robot_gets_no_command(topics):
    now = [0.0]
    outlet = CommandGate(topics, 2, clock=lambda: now[0])
    outlet.open()
    outlet.send(FORWARD)
    now[0] = 0.9
    assert not outlet.shut_if_stalled(1.0) and not outlet.stalled
    now[0] = 1.1
    assert outlet.shut_if_stalled(1.0) and not outlet.shut_if_stalled(1.0)
    outlet.send(FORWARD)  # which the law has brought at last
    assert outlet.stalled and topics.published[1:] == [STAND.tolist()] * 2
    outlet.open()
    now[0] = 9.0
    assert not outlet.stalled and not outlet.shut_if_stalled(1.0)  # they stand
