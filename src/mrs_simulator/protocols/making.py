"""Making the control of a scenario's robots."""

import numpy as np

from mrs_simulator.control.heading_swings import swings
from mrs_simulator.control.safety.bounds import Surroundings
from mrs_simulator.control.safety.distances import body_radii
from mrs_simulator.control.safety.filter_warnings import unkept
from mrs_simulator.control.user_code import UserCodeError, call
from mrs_simulator.protocols.loading import (
    OWN_INIT,
    ProtocolError,
    choose_protocol,
    has_own_init,
    refused_init,
)
from mrs_simulator.scenario.safety import Safety
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.obstacles import is_flat
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.suite import SensorError, check_fitted
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.team_in_space import team_of

FILTERS = ("sonar", "laser", "range_bearing")  # types of sensors by which the safety filter can act


def make_control(scenario, protocol=None):
    """Return the control of the scenario's robots, by ``protocol`` or the one it names."""
    scenario, protocol = choose_protocol(scenario, protocol)
    try:
        construction = _construction(scenario, protocol)
        check_sensors(protocol, scenario, construction["team"])
        control = _made(protocol, construction)
        control._keep(
            _environment=scenario.environment,
            _sensor_changes=scenario.sensors,
            obstacles=tuple(obstacles_of(scenario)),
        )
        control.safety_filter.warnings = unkept(scenario, control)
        control.runner.warnings = swings(control)
        if hasattr(control, "carry"):
            call(control.carry, scenario.load)
        return control
    except UserCodeError as error:
        raise ProtocolError("{}: {}".format(protocol.__name__, error)) from error
    except ValueError as error:
        if not scenario.path:
            raise
        raise ProtocolError("{}: {}".format(scenario.path, error)) from error


def _made(protocol, construction):
    """Return the control by ``protocol``; ``ProtocolError`` for a user's ``__init__`` that does not fit."""
    if not has_own_init(protocol):
        return call(protocol, **construction)
    try:
        control = call(protocol, **construction)
    except (ValueError, UserCodeError):
        raise
    except Exception as error:
        raise refused_init(protocol, error) from error
    if "team" not in vars(control):
        text = "{}.__init__ does not begin with super().__init__; wanted {}"
        raise ProtocolError(text.format(protocol.__name__, OWN_INIT))
    return control


def check_sensors(protocol, scenario, team):
    """Raise ``ProtocolError`` that names a sensor that ``protocol`` asks for and a robot lacks."""
    safety = scenario.control.safety
    filters = safety.sensed if isinstance(safety, Safety) else ()
    if not protocol.SENSORS and not filters:
        return
    mounts = fitted_mounts(team, scenario.sensors)
    for row, (own, kind) in enumerate(zip(mounts, team.kinds)):
        for who, names in ((protocol.__name__, protocol.SENSORS), ("control.safety", filters)):
            try:
                check_fitted(own, names, row + 1, kind)
            except SensorError as error:
                text = "{} asks for sensors {}: {}"
                raise ProtocolError(text.format(who, ", ".join(names), error)) from None
    _check_filters(filters, mounts[0])


def _check_filters(names, mounts):
    """Raise ``ProtocolError`` that names a sensor by which no safety filter can act."""
    types = {mount.name: mount.type for mount in mounts}
    for name in names:
        if types[name] not in FILTERS:
            text = "control.safety.sensed: {} is a {}, wanted one of {}"
            raise ProtocolError(text.format(name, types[name], ", ".join(FILTERS)))


def _construction(scenario, protocol):
    """Return what the control of the scenario's robots is made with, by name."""
    limits = None if scenario.fidelity == "point_mass" else scenario.limits
    team = team_of(scenario, limits, scenario.control.dimension or min(protocol.DIMENSIONS))
    safety = scenario.control.safety
    # Wheel odometry drifts by centimetres, as wheels that slip in the dynamics do.
    drifts = scenario.odometry == "wheel" or scenario.estimates
    fidelity = "dynamic" if drifts else scenario.fidelity
    # A class with a constructor of its own need not know of it.
    more = {"surroundings": _surroundings(scenario)} if isinstance(safety, Safety) else {}
    if scenario.control.deadband:
        more["deadband"] = scenario.control.deadband
    return dict(
        numbers=range(1, scenario.n + 1),
        topology=scenario.topology,
        links=scenario.links,
        seed=scenario.seed,
        team=team,
        saturation=scenario.control.saturation,
        parameters=scenario.control.parameters,
        period=1.0 / scenario.control.rate,
        fidelity=fidelity,
        safety=body_radii(team, fidelity) if safety else 0.0,
        **more,
    )


def _surroundings(scenario):
    """Return what ``control.safety`` keeps the robots from beside each other."""
    obstacles, arena, speed, sensed = scenario.control.safety
    caps = None if speed is None else np.broadcast_to(np.asarray(speed, dtype=float), scenario.n)
    kept = obstacles_of(scenario) if obstacles else ()
    team = Team.from_scenario(scenario)
    if not team.afloat.any():  # land is none to robots that stand on it
        kept = tuple(obstacle for obstacle in kept if not is_flat(obstacle))
    afloat = None if team.afloat.all() else team.afloat
    if not sensed:
        return Surroundings(kept, arena, caps, afloat=afloat)
    types = {mount.name: mount.type for mount in fitted_mounts(team, scenario.sensors)[0]}
    sees = any(types.get(name) == "range_bearing" for name in sensed)
    return Surroundings(kept, arena, caps, sensed, sees, afloat)
