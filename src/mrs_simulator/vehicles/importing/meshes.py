"""The points of mesh files: enough for the room that a mesh takes."""

import os
import xml.etree.ElementTree as ElementTree

import numpy as np

from mrs_simulator.scenario.reading import reason

LARGEST_MESH = 256 * 1024 * 1024  # [bytes]
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class MeshError(ValueError):
    """A mesh that cannot be read: says why."""

    page = "docs/robots_of_your_own.md#from-a-urdf-or-xacro"


def mesh_points(path):
    """Return the points (k, 3) of the STL, OBJ or Collada file at ``path``; ``MeshError``."""
    reader = READERS.get(os.path.splitext(path)[1].lower())
    if reader is None:
        raise MeshError("neither {} file".format(" nor ".join(sorted(READERS))))
    try:
        if os.path.getsize(path) > LARGEST_MESH:
            raise MeshError("larger than {} bytes".format(LARGEST_MESH))
        with open(path, "rb") as file:
            points = reader(file.read())
    except MeshError:
        raise
    except OSError as error:
        raise MeshError(reason(error)) from None
    except (ValueError, LookupError, ElementTree.ParseError, RecursionError) as error:
        raise MeshError("not a mesh: {}".format(reason(error))) from None
    if not len(points) or not np.isfinite(points).all():
        raise MeshError("no finite points in it")
    return points


def _stl(data):
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + count * TRIANGLE.itemsize:
        triangles = np.frombuffer(data, TRIANGLE, count, 84)
        return triangles["corners"].reshape(-1, 3).astype(float)
    if not data.lstrip().startswith(b"solid"):
        raise MeshError("neither a binary nor a text STL file")
    lines = (line.split() for line in data.decode("ascii", "replace").splitlines())
    return np.array([line[1:4] for line in lines if line[:1] == ["vertex"]], dtype=float)


def _obj(data):
    lines = (line.split() for line in data.decode("utf-8", "replace").splitlines())
    return np.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=float)


def _collada(data):
    root = ElementTree.fromstring(data)
    space = root.tag[: root.tag.index("}") + 1] if root.tag.startswith("{") else ""
    unit = root.find("{0}asset/{0}unit".format(space))
    metre = float(unit.get("meter", 1.0)) if unit is not None else 1.0
    up = (root.findtext("{0}asset/{0}up_axis".format(space)) or "Y_UP").strip()
    sources = {"#" + source.get("id", ""): source for source in root.iter("{}source".format(space))}
    shapes = {}
    for geometry in root.iter("{}geometry".format(space)):
        points = [
            _floats(sources[given.get("source")].findtext("{}float_array".format(space))).reshape(
                -1, 3
            )
            for given in geometry.iter("{}input".format(space))
            if given.get("semantic") == "POSITION"
        ]
        if points:
            shapes["#" + geometry.get("id", "")] = np.concatenate(points)
    found = []
    for scene in root.iter("{}visual_scene".format(space)):
        for node in scene.findall("{}node".format(space)):
            found += _instances(node, np.eye(4), shapes, space)
    points = np.concatenate(found) if found else np.empty((0, 3))
    turn = {"Y_UP": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "X_UP": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}
    return metre * points @ np.array(turn.get(up, np.eye(3))).T


def _instances(node, transform, shapes, space):
    """Return the point sets of the meshes in a Collada ``node`` and below, in the scene's frame."""
    for step in node:
        values = _floats(step.text) if step.tag[len(space) :] in STEPS else ()
        if len(values):
            transform = transform @ STEPS[step.tag[len(space) :]](values)
    found = []
    for given in node.findall("{}instance_geometry".format(space)):
        if given.get("url") in shapes:
            points = shapes[given.get("url")]
            found.append(points @ transform[:3, :3].T + transform[:3, 3])
    for inner in node.findall("{}node".format(space)):
        found += _instances(inner, transform, shapes, space)
    return found


def _floats(text):
    return np.array((text or "").split(), dtype=float)


def _translation(values):
    result = np.eye(4)
    result[:3, 3] = values
    return result


def _scaling(values):
    return np.diag([*values, 1.0])


def _rotation(values):
    """Return the rotation about the axis ``values[:3]`` by ``values[3]`` [deg], after Rodrigues."""
    x, y, z = values[:3] / np.linalg.norm(values[:3])
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(values[3])
    result = np.eye(4)
    result[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return result


STEPS = {
    "matrix": lambda values: values.reshape(4, 4),
    "translate": _translation,
    "scale": _scaling,
    "rotate": _rotation,
}
READERS = {".stl": _stl, ".obj": _obj, ".dae": _collada}
