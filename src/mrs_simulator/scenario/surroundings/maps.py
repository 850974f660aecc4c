"""Maps as walls: map_server's images, Stage's bitmaps and MobileSim's lines, read as boxes."""

import functools
import math
import os

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBERS, POSITIVE, REQUIRED, TEXT, Field
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    load_yaml,
    number_list,
    reason,
    record,
    refuse_special,
    shown,
    unwanted,
)
from mrs_simulator.scenario.surroundings.obstacles import Box, wall

LINES, SERVED = ".map", (".yaml", ".yml")
IMAGES = (".png", ".pgm", ".jpg", ".jpeg", ".gif", ".bmp")
MOST_BOXES = 20000  # [-] of one map
LARGEST_FILE = 64 * 1024 * 1024  # [bytes]
MOST_PIXELS = 50_000_000  # [-]
FARTHEST = 1e6  # [m] from the middle of the map
THICKNESS = 0.02  # [m] of a wall that a line stands for
DARK = 0.5  # [-] share of black from which a pixel of a plain image is a wall
DEEP = 257.0  # [-] values of an image of 16 bits for one of 8
WALL, FLOOR, UNKNOWN = 100, 0, -1  # cells as nav_msgs/OccupancyGrid has them
OCCUPIED, FREE = 0.65, 0.196  # [-] where map_server's file says nothing else


def _read_file(section, others):
    file = section.field(FILE)
    if _ending(file) not in (LINES, *SERVED, *IMAGES):
        wanted = "a file that ends in {}".format(", ".join((LINES, *SERVED, *IMAGES)))
        raise unwanted(section.at("file"), file, wanted)
    return file


def _read_size(section, others):
    return section.field(SIZE) if _ending(others["file"]) in IMAGES else ()


def _ending(file):
    return os.path.splitext(file)[1].lower()


FILE = Field("file", type=TEXT, rule=REQUIRED, meaning="its name, beside the scenario")
SIZE = Field(
    "size",
    (),
    "m",
    **POSITIVE,
    type=NUMBERS,
    sizes=(2,),
    rule=REQUIRED,
    meaning="of a plain image: its width and height, about its middle",
)
MAP = (
    FILE._replace(read=_read_file),
    SIZE._replace(read=_read_size),
    Field(
        "pose",
        (0.0, 0.0, 0.0),
        "m, m, rad",
        type=NUMBERS,
        sizes=(3,),
        rule="0, 0, 0",
        meaning="`[x, y, yaw]` at which the map's own frame lies",
    ),
    Field("height", 0.5, "m", **POSITIVE, meaning="of its walls"),
)


class Map(record("Map", MAP)):
    """A map that a scenario names."""

    __slots__ = ()

    def located(self, directory):
        """Return the map with its file, relative to ``directory``, as an absolute path."""
        path = os.path.join(directory, os.path.expanduser(self.file))
        return self._replace(file=os.path.abspath(path))

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        plain = {"file": self.file, "pose": list(self.pose), "height": self.height}
        return dict(plain, size=list(self.size)) if self.size else plain


@explained_by("docs/scenarios.md#maps")
def read_map(top):
    """Return the ``Map`` under ``map`` of a scenario, None for none; no file is opened."""
    given = top.take("map")
    if given is None:
        return None
    section = Section({"file": given} if isinstance(given, str) else given, top.at("map"))
    return Map(**section.values(MAP))


@explained_by("docs/scenarios.md#maps")
def obstacles_of(scenario):
    """Return the obstacles of ``scenario`` and the walls of its map, which is read from its file.

    Raises ``ScenarioError`` that names the file and the line or key.
    """
    if scenario.map is None:
        return scenario.obstacles
    source = scenario.map.located(scenario.directory)
    found = walls(source, tuple(map(_changed, files_of_map(scenario))))
    taken = {obstacle.name for obstacle in scenario.obstacles} & {box.name for box in found}
    if taken:
        text = "{}: its walls are called {} as an obstacle is; wanted another name for that"
        raise ScenarioError(text.format(source.file, min(taken)))
    return scenario.obstacles + found


def files_of_map(scenario):
    """Return the paths of the map that ``scenario`` names, and of the image that it names, if it does."""
    path = scenario.map.located(scenario.directory).file
    if os.path.splitext(path)[1].lower() not in SERVED:
        return [path]
    return [path, _image_of(Section(load_yaml(path), path), path)]


def _changed(path):
    """Return when the file at ``path`` was changed [ns], None for one that is not there."""
    return os.stat(path).st_mtime_ns if os.path.exists(path) else None


@functools.lru_cache(maxsize=8)
def walls(source, changed=()):
    """Return the ``Box`` tuple of the ``Map`` ``source``; ``changed``: as of its files, for the cache."""
    ending = os.path.splitext(source.file)[1].lower()
    if ending == LINES:
        found = mobilesim_lines(source.file)
        boxes = [
            wall("map{}".format(k + 1), line[:2], line[2:], THICKNESS, source.height)
            for k, line in enumerate(found)
        ]
    else:
        boxes = _of_pixels(source, ending)
    if len(boxes) > MOST_BOXES:
        text = "{}: {} boxes of walls, wanted at most {}: a coarser map"
        raise ScenarioError(text.format(source.file, len(boxes), MOST_BOXES))
    return tuple(_placed(box, source.pose) for box in boxes)


def _placed(box, pose):
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x, y = pose[0] + cos * box.x - sin * box.y, pose[1] + sin * box.x + cos * box.y
    return box._replace(x=x, y=y, yaw=box.yaw + pose[2])


def _of_pixels(source, ending):
    """Return the boxes of the occupied cells of an image, in the map's frame."""
    if ending in SERVED:
        filled, cell, origin = occupied_cells(source.file)
    else:
        filled = (255.0 - read_grey_image(source.file)) / 255.0 > DARK
        cell = source.size[0] / filled.shape[1], source.size[1] / filled.shape[0]
        origin = -0.5 * source.size[0], -0.5 * source.size[1], 0.0  # Stage: about its middle
    boxes = []
    for low, high, left, right in rectangles(filled[::-1]):
        x, y = 0.5 * (left + right) * cell[0], 0.5 * (low + high) * cell[1]
        size = (right - left) * cell[0], (high - low) * cell[1]
        name = "map{}".format(len(boxes) + 1)
        boxes.append(_placed(Box(name, x, y, 0.0, *size, source.height), origin))
    return boxes


def rectangles(filled):
    """Return rectangles ``(low, high, left, right)``, rows and columns, that cover ``filled`` bool (r, c).

    Each covers a run of one row, and of the rows after it as long as they have the same run.
    """
    edges = np.diff(np.pad(filled.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    starts, ends = np.argwhere(edges == 1), np.argwhere(edges == -1)
    result, open_runs, last = [], {}, -1
    for (row, left), (_, right) in zip(starts.tolist(), ends.tolist()):
        if row != last:
            open_runs = {k: v for k, v in open_runs.items() if result[v][1] == row}
            last = row
        index = open_runs.get((left, right))
        if index is not None and result[index][1] == row:
            result[index][1] = row + 1
        else:
            open_runs[left, right] = len(result)
            result.append([row, row + 1, left, right])
    return result


def occupied_cells(path):
    """Return occupied cells (rows, columns) bool, a cell's sides [m] and the origin of a map_server file.

    The first row is the top of the map; the origin (x, y [m], yaw [rad]) is that of its lower left corner.
    """
    cells, resolution, origin = trinary_cells(path)
    return cells == WALL, (resolution, resolution), origin


def trinary_cells(path):
    """Return cells (rows, columns) of ``WALL``, ``FLOOR`` and ``UNKNOWN`` int8, their side [m] and origin.

    Of a map_server file, as :func:`occupied_cells` has them.
    """
    top = Section(load_yaml(path), path)
    image = _image_of(top, path)
    resolution = top.number("resolution", above=0.0)
    origin = number_list(top.take("origin"), 3, top.at("origin"))
    negate = top.take("negate", 0)
    if negate not in (0, 1):  # or false and true
        raise unwanted(top.at("negate"), negate, "0 or 1")
    occupied = top.number("occupied_thresh", OCCUPIED, low=0.0, high=1.0)
    free = top.number("free_thresh", FREE, low=0.0, high=1.0)
    mode = top.text("mode", "trinary", ("trinary", "scale", "raw"))
    top.done()
    value = read_grey_image(image)
    if mode == "raw":  # the cells' values themselves: 0 to 100, more is unknown
        filled, empty = (value >= 100.0 * occupied) & (value <= 100.0), value <= 100.0 * free
    else:
        share = (value if negate else 255.0 - value) / 255.0
        filled, empty = share > occupied, share < free
    cells = np.where(empty, FLOOR, UNKNOWN)
    cells[filled] = WALL
    return cells.astype(np.int8), resolution, origin


def _image_of(top, path):
    """Return the path of the image that the ``Section`` of the map_server file at ``path`` names."""
    return os.path.join(os.path.dirname(path), os.path.expanduser(top.text("image")))


def _refuse_large(path):
    """Raise ``OSError`` for a file larger than ``LARGEST_FILE``."""
    if os.path.getsize(path) > LARGEST_FILE:
        raise OSError("is larger than {} bytes".format(LARGEST_FILE))


def read_grey_image(path):
    """Return the image at ``path`` as greys from 0 to 255, (rows, columns), the top row first.

    Colours are averaged; what is transparent is white; of 16 bits the upper ones count.
    """
    try:
        from PIL import Image  # only where a map is an image
    except ImportError:
        raise ScenarioError("{}: an image needs the package python3-pil".format(path)) from None
    try:
        refuse_special(path)
        _refuse_large(path)
        with Image.open(path) as image:
            if image.width * image.height > MOST_PIXELS:
                raise OSError("has more than {} pixels".format(MOST_PIXELS))
            if image.mode.startswith("I"):  # of which the conversion would keep no more than 255
                return np.asarray(image, dtype=float) / DEEP
            pixels = np.asarray(image.convert("RGBA"), dtype=float)
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        raise ScenarioError(
            "{}: no image that can be read: {}".format(path, reason(error))
        ) from None
    seen = pixels[..., 3:] / 255.0
    return (seen * pixels[..., :3] + (1.0 - seen) * 255.0).mean(axis=2)


def mobilesim_lines(path):
    """Return the lines (m, 4) [m], from x, y to x, y, of MobileSim's map at ``path``."""
    try:
        refuse_special(path)
        _refuse_large(path)
        with open(path, encoding="utf-8", errors="replace") as file:
            rows = file.read().splitlines()
    except OSError as error:
        raise ScenarioError("{}: cannot be read: {}".format(path, reason(error))) from None
    if not rows or rows[0].strip() not in ("2D-Map", "2D-Map-Ex", "2D-Map-Ex2"):
        text = "{}, line 1: {}, wanted 2D-Map"
        raise ScenarioError(text.format(path, shown(rows[0] if rows else None)))
    lines, within, announced = [], False, None
    for index, row in enumerate(rows[1:], 2):
        words = row.split()
        if words and words[0] == "NumLines:":
            announced = _whole(words[1:], 1, path, index)[0]
        elif words in (["LINES"], ["DATA"]):
            within = words == ["LINES"]
        elif within and words:
            line = _whole(words, 4, path, index)
            if line[:2] != line[2:]:
                lines.append([0.001 * value for value in line])
            elif announced is not None:
                announced -= 1  # a point is no wall
    if announced is not None and announced != len(lines):
        raise ScenarioError(
            "{}: {} lines, but NumLines says {}".format(path, len(lines), announced)
        )
    return lines


def _whole(words, count, path, index):
    """Return ``count`` whole numbers, in mm, from ``words`` of line ``index``."""
    try:
        values = [int(word) for word in words]
    except ValueError:
        values = []
    if len(values) != count or any(abs(value) > 1000.0 * FARTHEST for value in values):
        text = "{}, line {}: {}, wanted {} whole numbers, of mm up to {:g}"
        raise ScenarioError(
            text.format(path, index, shown(" ".join(words)), count, 1000.0 * FARTHEST)
        )
    return values
