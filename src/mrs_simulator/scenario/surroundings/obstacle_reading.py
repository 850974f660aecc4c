"""The ``obstacles`` of a scenario: boxes, cylinders, walls and land."""

import re

from mrs_simulator.core.doc_links import explained_by
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
    shape = section.text("type", choices=("box", "cylinder", "wall", "land"))
    name = section.text("name", "{}{}".format(shape, index + 1))
    height = 0.0 if shape == "land" else section.number("height", 0.5, above=0.0)
    if shape == "wall":
        start, end = section.numbers("from", 2), section.numbers("to", 2)
        thickness = section.number("thickness", 0.1, above=0.0)
        try:
            obstacle = wall(name, start, end, thickness, height)
        except ValueError as error:
            raise ScenarioError("{}: {}".format(where, error)) from None
    elif shape == "cylinder":
        x, y = section.numbers("center", 2)
        obstacle = Cylinder(name, x, y, section.number("radius", above=0.0), height)
    else:
        x, y = section.numbers("center", 2)
        length, width = section.numbers("size", 2)
        if length <= 0.0 or width <= 0.0:
            raise ScenarioError("{}.size: {}, wanted above 0".format(where, [length, width]))
        obstacle = Box(name, x, y, section.number("yaw", 0.0), length, width, height)
    if shape != "land":
        obstacle = obstacle._replace(track=read_track(section, (obstacle.x, obstacle.y)))
    section.done()
    return obstacle


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
