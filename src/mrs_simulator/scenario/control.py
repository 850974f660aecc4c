"""The ``control`` of a scenario: protocol, parameters, rate, saturation, safety."""

from typing import Any, Dict, NamedTuple, Optional, Union

from mrs_simulator.scenario.reading import ScenarioError, Section, shown
from mrs_simulator.scenario.safety import Safety, read_safety

SATURATIONS = ("robot", "team", "none")
DEFAULT_PROTOCOL = "formation"
RATES = (0.1, 1000.0)  # [Hz] of commands, least and most


class Control(NamedTuple):
    """How the team is controlled: the protocol, its parameters and the rate of commands."""

    protocol: str = DEFAULT_PROTOCOL
    rate: float = 50.0  # [Hz]
    parameters: Dict[str, Any] = {}
    saturation: str = "robot"
    safety: Union[bool, Safety] = False
    deadband: float = 0.0  # [m/s, rad/s] up to which commands are sent as zero
    dimension: Optional[int] = None  # of the controlled points, None: the least of the protocol's

    def with_robots(self, n):
        """Return the control of n robots."""
        return self._replace(safety=self.safety.with_robots(n)) if self._is_safety_given else self

    def to_plain(self):
        """Return plain values, as a scenario has them."""
        safety = self.safety.to_plain() if self._is_safety_given else self.safety
        plain = {**self._asdict(), "parameters": dict(self.parameters), "safety": safety}
        if self.dimension is None:
            del plain["dimension"]
        if not self.deadband:
            del plain["deadband"]
        return plain

    @property
    def _is_safety_given(self):
        return isinstance(self.safety, Safety)


def read_control(top, n):
    """Return the ``Control`` under ``control`` of the section ``top``, of n robots."""
    section = Section(top.take("control", {}), top.at("control"))
    parameters = section.take("parameters", {})
    if not isinstance(parameters, dict):
        raise ScenarioError(
            "{}: {}, wanted a mapping".format(section.at("parameters"), shown(parameters))
        )
    for name, value in parameters.items():
        if not isinstance(name, str) or not isinstance(value, (int, float, str, bool)):
            place = section.at("parameters.{}".format(shown(name).strip("'")))
            raise ScenarioError(
                "{}: {}, wanted a number, a text, true or false".format(place, shown(value))
            )
    if "l" in parameters:
        Section(parameters, section.at("parameters")).number("l", above=0.0)
    control = Control(
        protocol=section.text("protocol", DEFAULT_PROTOCOL),
        rate=section.number("rate", 50.0, low=RATES[0], high=RATES[1]),
        parameters=parameters,
        saturation=section.text("saturation", "robot", SATURATIONS),
        safety=read_safety(section, n),
        deadband=section.number("deadband", 0.0, low=0.0),
        dimension=section.whole("dimension", low=2, high=3) if section.has("dimension") else None,
    )
    section.take("dimension")
    section.done()
    return control
