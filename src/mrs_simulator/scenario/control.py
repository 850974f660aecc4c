"""The ``control`` of a scenario: protocol, parameters, rate, saturation, safety."""

from mrs_simulator.core.fields import NUMBER, POSITIVE, WHOLE, Field
from mrs_simulator.scenario.reading import Section, fitting, record, shown, unwanted, written
from mrs_simulator.scenario.safety import Safety, read_safety

SATURATIONS = ("robot", "team", "none")
RATES = (0.1, 1000.0)  # [Hz] of commands, least and most
HAND_LENGTH = Field("l", unit="m", **POSITIVE, type=NUMBER)  # of all protocols


def read_parameters(section, others):
    """Return the ``parameters`` of the protocol, by name; what they may be its class knows."""
    parameters, where = section.take("parameters", {}), section.at("parameters")
    if not isinstance(parameters, dict):
        raise unwanted(where, parameters, "a mapping")
    for name, value in parameters.items():
        if not isinstance(name, str) or not isinstance(value, (int, float, str, bool)):
            place = section.at("parameters.{}".format(shown(name).strip("'")))
            raise unwanted(place, value, "a number, a text, true or false")
    if "l" in parameters:
        fitting(HAND_LENGTH, parameters["l"], section.at("parameters.l"))
    return parameters


CONTROL = (
    Field(
        "protocol",
        "formation",
        meaning="a [shipped protocol](shipped_protocols.md#shipped-protocols), or "
        "[one of your own](protocols.md#where-a-protocol-is-named)",
    ),
    Field("rate", 50.0, "Hz", low=RATES[0], high=RATES[1], meaning="commands per second"),
    Field(
        "parameters",
        {},
        read=read_parameters,
        plain=lambda value, n: dict(value),
        meaning="those of the protocol, by name",
    ),
    Field(
        "saturation",
        "robot",
        choices=SATURATIONS,
        meaning="what is scaled down where a command is beyond the limits: one `robot`, the whole `team`, "
        "or `none` ([limits](shipped_protocols.md#the-papers-law))",
    ),
    Field(
        "safety",
        False,
        read=read_safety,
        plain=lambda value, n: value.to_plain() if isinstance(value, Safety) else value,
        meaning="the [safety filter](safety_filter.md#safety-filter): `true`: no two robots ever touch; "
        "`{obstacles: true, arena: [x_min, y_min, x_max, y_max], speed: 0.4}`: nor do they touch "
        "obstacles, and they stay inside the arena and below that speed; `sensed: sonar`: by what that "
        "sensor measures",
    ),
    Field(
        "deadband",
        0.0,
        "m/s, rad/s",
        low=0.0,
        meaning="a command of which no component is larger is sent as zero, as "
        "[p2os](robots.md#p2os-instead-of-rosaria) needs it",
    ),
    Field(
        "dimension",
        low=2,
        high=3,
        type=WHOLE,
        rule="the least that the protocol is for",
        meaning="2 or 3: how many coordinates the law moves; 3 for teams that fly "
        "([in space](protocols.md#in-space))",
    ),
)


class Control(record("Control", CONTROL)):
    """How the team is controlled, the keys ``CONTROL``: protocol, its parameters, rate of commands."""

    __slots__ = ()

    def with_robots(self, n):
        """Return the control of n robots."""
        given = isinstance(self.safety, Safety)
        return self._replace(safety=self.safety.with_robots(n)) if given else self

    def to_plain(self):
        """Return plain values, as a scenario has them."""
        return written(self, CONTROL)


def read_control(top, others):
    """Return the ``Control`` under ``control`` of the section ``top``."""
    return Control(**Section(top.take("control", {}), top.at("control"), top.n).values(CONTROL))
