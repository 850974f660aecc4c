"""Services of robots that fly: take-off, landing, and the motors' cut-off."""

import rospy
from std_srvs.srv import SetBool, Trigger

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.node.node_parameters import TAKEOFF_HEIGHT
from mrs_simulator.ros.node.parameters import read


class FlightServices(StagePart):
    """``/robotN/takeoff``, ``/robotN/land``, ``/robotN/cut_motors`` of simulated robots that fly.

    ``cut_motors`` with ``data: false`` is refused in the air; with ``data: true`` its caller says that the
    robot may fall.
    """

    def __init__(self, world, requests, absent=()):
        """``requests`` runs what services ask for; ``absent``: rows of robots that are real."""
        self._world, self._requests, self._absent = world, requests, set(absent)
        self._height = read(TAKEOFF_HEIGHT)
        self._services = {}

    def follow_team(self, scenario):
        """Open or withdraw services, so that every simulated robot that flies has its own."""
        team = self._world.team
        flying = {row for row in range(team.n) if team.airborne[row]} - self._absent
        for row in set(self._services) - flying:
            for service in self._services.pop(row):
                service.shutdown("the robot was taken away")
        for row in flying.difference(self._services):
            self._services[row] = self._open(row)

    def _open(self, row):
        name = "/robot{}/".format(row + 1)
        return [
            self._service(name + "takeoff", Trigger, lambda _: self._take_off(row)),
            self._service(name + "land", Trigger, lambda _: self._land(row)),
            self._service(name + "cut_motors", SetBool, lambda asked: self._cut(row, asked.data)),
        ]

    def _service(self, name, kind, handler):
        return rospy.Service(
            name, kind, lambda request: self._requests.ask(lambda: handler(request))
        )

    def _take_off(self, row):
        self._world.flights.take_off([row], self._height)
        return "robot{} takes off to {:g} m".format(row + 1, self._height)

    def _land(self, row):
        self._world.flights.land([row])
        return "robot{} lands".format(row + 1)

    def _cut(self, row, falls):
        self._world.flights.cut_motors([row], falls)
        return "robot{}: motors cut".format(row + 1)
