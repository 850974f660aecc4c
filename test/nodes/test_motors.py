"""Motors are switched on for who is to move, and for nobody else."""

import threading

import pytest
from ros_fixtures import wait_until

from mrs_simulator.nodes.control import motors as module
from mrs_simulator.nodes.control.motors import Motors


@pytest.fixture
def services(monkeypatch):
    """Return what stands for the services: ``offered`` ends the wait for them; ``called`` names."""

    class Services:
        def __init__(self):
            self.offered, self.waited = threading.Event(), threading.Event()
            self.called = []

        def wait(self, _name, _seconds):
            self.waited.set()
            assert self.offered.wait(60.0)

        def proxy(self, name, _kind):
            return lambda: self.called.append(name)

    made = Services()
    given = {module.ENABLE_MOTORS: "/robot{}/on"}
    monkeypatch.setattr(module, "read", lambda parameter: given.get(parameter, ""))
    monkeypatch.setattr(module.rospy, "wait_for_service", made.wait)
    monkeypatch.setattr(module.rospy, "ServiceProxy", made.proxy)
    monkeypatch.setattr(module.rospy, "is_shutdown", lambda: False)
    return made


def ended(before):
    wait_until(lambda: not [each for each in threading.enumerate() if each not in before])


def test_every_robots_service_is_called(services):
    before, motors = threading.enumerate(), Motors([1, 2])
    motors.enable()
    assert "/robot1/on has not answered yet, /robot2/on" in motors.missing()
    services.offered.set()
    ended(before)
    assert sorted(services.called) == ["/robot1/on", "/robot2/on"] and motors.missing() == ""


def test_no_motor_is_switched_on_after_a_stop_though_its_service_was_awaited(services):
    before, motors = threading.enumerate(), Motors([1])
    motors.enable()
    assert services.waited.wait(60.0)
    motors.forget()
    services.offered.set()
    ended(before)
    assert services.called == [] and motors.missing() == ""
