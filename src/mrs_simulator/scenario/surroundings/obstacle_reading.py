"""The ``obstacles`` of a scenario: boxes, cylinders, walls and land."""

import re

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBER, NUMBERS, POSITIVE, REQUIRED, TEXT, Field
from mrs_simulator.scenario.reading import ScenarioError, Section, shown
from mrs_simulator.scenario.surroundings.moving_obstacles import moves, read_track
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder, is_flat, wall

ROBOT = re.compile(r"robot\d+")  # names that obstacles cannot have


@explained_by("docs/scenarios.md#obstacles")
def read_obstacles(top):
    """Return the obstacles under ``obstacles`` of the section ``top``, a tuple."""
    obstacles, names = [], set()
    for index, (where, item) in enumerate(top.items("obstacles", "a list")):
        obstacle = _read_obstacle(item, where, index)
        name = shown(obstacle.name)
        if obstacle.name in names:
            raise ScenarioError("{}: the name {} is taken".format(where, name))
        if ROBOT.fullmatch(obstacle.name):
            text = "{}.name: {} is a robot's, wanted another one"
            raise ScenarioError(text.format(where, name))
        names.add(obstacle.name)
        obstacles.append(obstacle)
    return tuple(obstacles)


def _read_obstacle(item, where, index):
    section = Section(item, where)
    make, fields = SHAPES[section.field(TYPE)]
    values = section.values((TYPE, NAME, *fields), {"count": index + 1})
    try:
        return make(values)
    except ValueError as error:
        raise ScenarioError("{}: {}".format(where, error)) from None


def _read_name(section, others):
    default = "{}{}".format(others["type"], others["count"])
    return section.field(Field("name", default, type=TEXT))


def _read_track(section, others):
    ends = (others["from"], others["to"]) if "from" in others else (others["center"],)
    return read_track(section, [sum(each) / len(ends) for each in zip(*ends)])


def _box(values):
    (x, y), (length, width) = values["center"], values["size"]
    place = x, y, values["yaw"], length, width, values.get("height", 0.0)
    return Box(values["name"], *place, values.get("track"))


def _cylinder(values):
    name, (x, y) = values["name"], values["center"]
    return Cylinder(name, x, y, values["radius"], values["height"], values["track"])


def _wall(values):
    keys = "name", "from", "to", "thickness", "height"
    return wall(*map(values.get, keys))._replace(track=values["track"])


POINT = dict(unit="m", type=NUMBERS, sizes=(2,), rule=REQUIRED)
LENGTH = dict(unit="m", **POSITIVE)
NAME = Field(
    "name",
    read=_read_name,
    rule="its type and place in the list",
    meaning="unlike those of other obstacles and of robots",
)
CENTER = Field("center", **POINT, meaning="of a box, cylinder or land: `[x, y]`")
SIZE = Field("size", **POINT, **POSITIVE, meaning="of a box or land: length and width")
YAW = Field("yaw", 0.0, "rad", meaning="of a box or land: direction of its length")
RADIUS = Field("radius", **LENGTH, type=NUMBER, rule=REQUIRED, meaning="of a cylinder")
FROM = Field("from", **POINT, meaning="of a wall: `[x, y]` of one end")
TO = Field("to", **POINT, meaning="of a wall: `[x, y]` of the other end")
THICKNESS = Field("thickness", 0.1, **LENGTH, meaning="of a wall")
HEIGHT = Field("height", 0.5, **LENGTH, meaning="of all but land, which is level with the ground")
ON_TRACK = Field("track", read=_read_track, meaning="of all but land: its path")
BOX, ROUND, WALL = (CENTER, SIZE, YAW), (CENTER, RADIUS), (FROM, TO, THICKNESS)
ABOVE = (HEIGHT, ON_TRACK)
SHAPES = {  # what makes it of the values of which fields
    "box": (_box, BOX + ABOVE),
    "cylinder": (_cylinder, ROUND + ABOVE),
    "wall": (_wall, WALL + ABOVE),
    "land": (_box, BOX),
}
TYPE = Field(
    "type",
    choices=tuple(SHAPES),
    type=TEXT,
    rule=REQUIRED,
    meaning="`box`, `cylinder`, `wall`, or `land`, which only boats touch",
)
OBSTACLE = (TYPE, NAME, *BOX, RADIUS, *WALL, *ABOVE)


def checked_obstacles(obstacles):
    """Return ``obstacles`` as they are read from a file; ``ScenarioError`` says what is wrong with them."""
    plain = [obstacle_to_plain(obstacle) for obstacle in obstacles]
    return read_obstacles(Section({"obstacles": plain}, "scenario"))


def obstacle_to_plain(obstacle):
    """Return ``obstacle`` as plain values, as a file has it; walls as boxes."""
    plain = {"name": obstacle.name, "center": [obstacle.x, obstacle.y], "height": obstacle.height}
    if is_flat(obstacle):
        plain.pop("height")
    if moves(obstacle):
        plain["track"] = obstacle.track.to_plain()
    if isinstance(obstacle, Cylinder):
        return {"type": "cylinder", "radius": obstacle.radius, **plain}
    size = [obstacle.length, obstacle.width]
    shape = "land" if is_flat(obstacle) else "box"
    return {"type": shape, "size": size, "yaw": obstacle.yaw, **plain}
