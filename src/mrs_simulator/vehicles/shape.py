"""The shape of a robot, as data: boxes, cylinders and spheres in the frame of its base_link."""

import math
from typing import NamedTuple, Tuple

from mrs_simulator.scenario.reading import Section, number, unwanted

FORMS = {"box": 3, "cylinder": 2, "sphere": 1}  # numbers of the size
MOST_PARTS = 100  # [-] of one robot: pybullet's bodies have at most 128 links
LARGEST = 100.0  # [m] of a part, and from the centre
DARK = (0.15, 0.15, 0.15, 1.0)
GREY = (0.6, 0.6, 0.6, 1.0)  # [-] red, green, blue, opacity


class Part(NamedTuple):
    """A solid, placed in base_link."""

    form: str  # of ``FORMS``
    # [m] box: length, width, height; cylinder: radius, length; sphere: radius
    size: Tuple[float, ...]
    place: Tuple[float, ...] = (0.0,) * 6  # [m, rad] x, y, z of the middle, roll, pitch, yaw
    colour: Tuple[float, ...] = GREY

    def to_plain(self):
        """Return the part as a kind's file has it."""
        plain = {"form": self.form, "size": list(self.size), "place": list(self.place)}
        return dict(plain, colour=list(self.colour))


def read_shape(value, where):
    """Return the tuple of ``Part`` in a kind's list ``shape``; ``ScenarioError`` names what is wrong."""
    if not isinstance(value, list) or len(value) > MOST_PARTS:
        raise unwanted(where, value, "a list of at most {} parts".format(MOST_PARTS))
    return tuple(_read_part(each, "{}[{}]".format(where, k)) for k, each in enumerate(value))


def _read_part(content, where):
    section = Section(content, where)
    form = section.text("form", choices=tuple(FORMS))
    size = section.numbers("size", FORMS[form])
    place = (
        section.numbers("place", 6) if section.has("place") else section.take("place", [0.0] * 6)
    )
    colour = section.numbers("colour", 4) if section.has("colour") else section.take("colour", GREY)
    section.done()
    for value in size:
        number(value, section.at("size"), above=0.0)
    for value in (*size, *place[:3]):
        number(value, where, low=-LARGEST, high=LARGEST)
    for value in place[3:]:
        number(value, section.at("place"), low=-2.0 * math.pi, high=2.0 * math.pi)
    for value in colour:
        number(value, section.at("colour"), low=0.0, high=1.0)
    return Part(form, tuple(size), tuple(place), tuple(colour))


def ride_height(kind):
    """Return how high [m] the frame of the parts is above the ground; 0 where the drive has none."""
    height = getattr(kind.module, "ride_height", None)
    return height(kind.numbers) if height else 0.0


def outline_parts(kind):
    """Return the parts that stand for a ``kind`` without a shape: its outline and its nose."""
    body, lifted = kind.body, -ride_height(kind)
    middle = 0.5 * (body.front - body.rear)
    form, size = "box", (body.length, body.width, body.height)
    if body.round:
        form, size = "cylinder", (body.front, body.height)
    place = (middle, 0.0, lifted + 0.5 * body.height, 0.0, 0.0, 0.0)
    nose = (0.25 * body.length, 0.3 * body.width, 0.05 * body.height)
    above = (middle + 0.3 * body.length, 0.0, lifted + body.height, 0.0, 0.0, 0.0)
    return Part(form, size, place), Part("box", nose, above, DARK)
