"""Making the control of a scenario's robots."""

import math

from mrs_simulator.control.loading import ProtocolError, choose_protocol
from mrs_simulator.vehicles import limits_of_team, robot_kind


def make_control(scenario, protocol=None):
    """Return the control of the scenario's robots, by ``protocol`` or the one it names."""
    scenario, protocol = choose_protocol(scenario, protocol)
    try:
        return protocol(**_construction(scenario))
    except ValueError as error:
        if not scenario.path:
            raise
        raise ProtocolError("{}: {}".format(scenario.path, error)) from error


def _construction(scenario):
    """Return what the control of the scenario's robots is made with, by name."""
    limits = None if scenario.fidelity == "point_mass" else scenario.limits
    return dict(
        numbers=range(1, scenario.n + 1),
        topology=scenario.topology,
        links=scenario.links,
        seed=scenario.seed,
        limits=limits_of_team(scenario.kinds, limits),
        saturation=scenario.control.saturation,
        parameters=scenario.control.parameters,
        period=1.0 / scenario.control.rate,
        # Wheel odometry drifts by centimetres, as wheels that slip in the dynamics do.
        fidelity="dynamic" if scenario.odometry == "wheel" else scenario.fidelity,
        safety=_radius(scenario) if scenario.control.safety else 0.0,
    )


def _radius(scenario):
    """Return the radius [m] about the axle centre of the largest robot of the team."""
    return max(
        math.hypot(max(kind.FRONT, kind.REAR), 0.5 * kind.WIDTH)
        for kind in map(robot_kind, set(scenario.kinds))
    )
