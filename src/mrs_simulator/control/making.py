"""Making the control of a scenario's robots."""

from mrs_simulator.control.loading import ProtocolError, choose_protocol
from mrs_simulator.control.user_code import UserCodeError, call
from mrs_simulator.vehicles import Team


def make_control(scenario, protocol=None):
    """Return the control of the scenario's robots, by ``protocol`` or the one it names."""
    scenario, protocol = choose_protocol(scenario, protocol)
    try:
        return call(protocol, **_construction(scenario))
    except UserCodeError as error:
        raise ProtocolError("{}: {}".format(protocol.__name__, error)) from error
    except ValueError as error:
        if not scenario.path:
            raise
        raise ProtocolError("{}: {}".format(scenario.path, error)) from error


def _construction(scenario):
    """Return what the control of the scenario's robots is made with, by name."""
    limits = None if scenario.fidelity == "point_mass" else scenario.limits
    team = Team.from_scenario(scenario, limits)
    return dict(
        numbers=range(1, scenario.n + 1),
        topology=scenario.topology,
        links=scenario.links,
        seed=scenario.seed,
        team=team,
        saturation=scenario.control.saturation,
        parameters=scenario.control.parameters,
        period=1.0 / scenario.control.rate,
        # Wheel odometry drifts by centimetres, as wheels that slip in the dynamics do.
        fidelity="dynamic" if scenario.odometry == "wheel" else scenario.fidelity,
        safety=team.reach if scenario.control.safety else 0.0,
    )
