"""Laws that use their robots' sensors, and the scene's obstacles."""

import copy
import pickle
import sys

import numpy as np
import pytest

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.control.twists import ControlError
from mrs_simulator.nodes.control.law_client import Law, where_to_run
from mrs_simulator.protocols.loading import ProtocolError
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.readings import Readings
from mrs_simulator.sensors.types.ranging import RangeReading
from mrs_simulator.study.run.experiment import Experiment, LawFailed

WALL = {"type": "box", "name": "wall", "center": [2.0, 0.0], "size": [0.2, 9.0]}


class StopsBefore(PioneerControl):
    """Drives on until the sonar's foremost echoes are near."""

    SENSORS = ("sonar",)

    def pointMassLaw(self, hand):
        found = [self.readings[number].sonar for number in self.numbers]
        self.stamps = [each.stamp for each in found]
        near = np.array([each.ranges[3:5].min() for each in found])
        return np.where(near[:, np.newaxis] > 0.5, [0.3, 0.0], [0.0, 0.0])


class KnowsItsMap(PioneerControl):
    """Drives towards the first obstacle."""

    def pointMassLaw(self, hand):
        return [self.obstacles[0].x, self.obstacles[0].y] - hand


def scenario(**more):
    content = {"poses": [[0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]], "obstacles": [WALL], "duration": 8.0}
    return scenario_from_dict(dict(content, **more))


def finished(law, **more):
    experiment = Experiment(scenario(**more), law)
    for _ in experiment.samples():
        pass
    return experiment


def test_a_law_stops_by_its_sonar():
    experiment = finished(StopsBefore)
    front = experiment.world.pose[:, 0] + 0.166  # the foremost transducers
    left = (1.9 - front) / np.cos(np.radians(5.0))
    # A reading is up to 0.1 s old, at 0.3 m/s, and the robot brakes at 0.3 m/s^2.
    assert np.all((left > 0.25) & (left < 0.52)), left
    assert experiment.control.stamps == pytest.approx([8.0, 8.0])
    assert not experiment.collisions


@pytest.mark.parametrize("field", ["ranges", "places"])
def test_a_law_cannot_change_a_reading_of_its_sonar(field):
    """The safety filter, and the sensor itself, go by the same arrays."""

    class Writes(StopsBefore):
        def pointMassLaw(self, hand):
            getattr(self.readings[1].sonar, field)[:] = 9.0
            return np.zeros_like(hand)

    with pytest.raises(LawFailed, match="read-only"):
        finished(Writes, duration=0.1)


def test_readings_over_edges_with_faults_are_ones_own():
    class Asks(StopsBefore):
        def pointMassLaw(self, hand):
            own = [n for n in self.numbers if self.readings[n].sonar is not None]
            assert len(own) == 1
            return np.zeros_like(hand)

    edges = {"topology": {"edges": [[1, 2], [2, 1]]}, "links": {"loss": 0.1}, "duration": 0.1}
    finished(Asks, **edges)


def test_a_law_knows_the_obstacles():
    control = make_control(scenario(), KnowsItsMap)
    assert [obstacle.name for obstacle in control.obstacles] == ["wall"]
    assert control.commands(np.array([[0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]]))[0, 0] > 0.0


def test_a_sensor_that_a_robot_lacks_is_refused_at_the_start():
    wanted = r"StopsBefore asks for sensors sonar: sensors of robot2 \(robotino3\): unknown 'sonar'"
    with pytest.raises(ProtocolError, match=wanted):
        make_control(scenario(model=["pioneer3dx", "robotino3"]), StopsBefore)
    taken = [{"robots": 1, "mounts": {"sonar": None}}]
    with pytest.raises(ProtocolError, match="robot1"):
        Experiment(scenario(sensors=taken), StopsBefore)


def test_a_sensor_that_the_law_does_not_ask_for_is_reported():
    class Forgets(StopsBefore):
        def pointMassLaw(self, hand):
            return self.readings[1].laser

    with pytest.raises(LawFailed, match="robot 1: no 'laser'; the law's SENSORS are sonar"):
        finished(Forgets)


def test_readings_are_none_before_one_has_come():
    class Waits(StopsBefore):
        def pointMassLaw(self, hand):
            assert (self.readings[1].sonar is None) == (self.time < 0.3 - 1e-9)
            return np.zeros_like(hand)

    late = [{"mounts": {"sonar": {"noise": {"latency": 0.3}}}}]
    finished(Waits, sensors=late, duration=0.5)
    assert make_control(scenario(), StopsBefore).readings[2].sonar is None


def test_readings_are_to_be_read():
    readings = Readings(3, ("sonar",))
    for each in (readings, copy.deepcopy(readings), pickle.loads(pickle.dumps(readings))):
        assert each.sonar is None
        with pytest.raises(AttributeError, match="robot 3: no 'lasr'"):
            each.lasr  # noqa: B018
        with pytest.raises(AttributeError, match="not to be changed: 'sonar'"):
            each.sonar = 1.0
    with pytest.raises(ControlError, match="self.readings is PioneerControl's own"):
        make_control(scenario(), StopsBefore).readings = {}
    with pytest.raises(TypeError, match="SENSORS = 'sonar': wanted a tuple"):
        type("Wrong", (StopsBefore,), {"SENSORS": "sonar"})


def test_runs_of_laws_without_sensors_are_those_of_teams_without():
    class Plain(KnowsItsMap):
        pass

    with_sonar, without = (
        finished(Plain, duration=1.0, sensors=changes)
        for changes in ([], [{"mounts": {"sonar": None}}])
    )
    assert with_sonar.sensors.is_idle
    assert np.array_equal(with_sonar.world.pose, without.world.pose)


def test_a_law_apart_is_sent_each_reading_once():
    law = Law(scenario(), StopsBefore, 10.0, where_to_run(StopsBefore))
    sent, ask = [], law._worker.ask

    def noted(request, *more):
        sent.append(len(request))
        return ask(request, *more)

    law._worker.ask = noted
    pose = np.array([[0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]])
    sonar = RangeReading(0.0, np.full(16, 2.0), np.zeros((16, 3)), 5.0)
    readings = {0: {"sonar": sonar}, 1: {"sonar": sonar}}
    assert law.state.sensors == ("sonar",)
    for known in (readings, readings, dict(readings)):
        command = law.commands(pose, 0.0, 10.0, readings=known)
        assert (command[:, 0] > 0.0).all()
    assert sent == [4, 3, 4]
    law.end()


def calls_of(changes):
    """Return how many functions a run of ten robots calls, Python's and C's."""
    poses = [[-3.0 * k, -1.0, 0.0] for k in range(10)]
    experiment = Experiment(scenario(poses=poses, sensors=changes, duration=1.0), KnowsItsMap)
    count, before = [0], sys.getprofile()
    sys.setprofile(lambda frame, event, given: count.__setitem__(0, count[0] + (event != "return")))
    try:
        for _ in experiment.samples():
            pass
    finally:
        sys.setprofile(before)
    return count[0]


def test_sensors_without_a_subscriber_add_no_call_to_a_run():
    """Their cost, under 2 % of a run, is too little to be told from noise by time."""
    calls_of([])  # what is loaded at first is loaded
    heard = [{"mounts": {"laser": {}, "gps": {"type": "gps"}, "imu": {"type": "imu"}}}]
    assert calls_of(heard) == calls_of([{"mounts": {"sonar": None}}])
    drains = [{"mounts": {"battery": {"type": "battery"}}}]
    assert calls_of(drains) > calls_of(heard)
