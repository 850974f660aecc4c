"""The way of the commands to the robots: what passes, and what does not."""

import numpy as np
import pytest

from mrs_simulator.nodes.outlet import Outlet

FORWARD, STAND = np.array([[0.2, 0.0], [0.1, 0.3]]), np.zeros((2, 2))


class Topics:
    """Keeps what is published."""

    def __init__(self):
        self.published = []

    def publish(self, command):
        self.published.append(command.tolist())


@pytest.fixture
def topics():
    return Topics()


@pytest.fixture
def outlet(topics):
    return Outlet(topics, 2)


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
    outlet = Outlet(None, 2)
    outlet.open()
    outlet.send(FORWARD)
    assert outlet.command.tolist() == FORWARD.tolist()
