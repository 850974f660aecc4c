"""Where the bodies of a description are: meshes found or replaced, and the room that shapes take."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.vehicles.importing.description import Shape
from mrs_simulator.vehicles.importing.meshes import MeshError, mesh_points

LARGEST = 1e3  # [m] from the robot's centre: beyond it a mesh is in other units


class Part(NamedTuple):
    """Visuals and collisions of a rigid part of the robot, placed in its frame."""

    visuals: Tuple[Shape, ...]
    collisions: Tuple[Shape, ...]


def found_shapes(link, into, packages, notes, needed=True):
    """Return the ``Part`` of ``link`` with its meshes' files; ``into`` (4, 4): its place in the part.

    A collision mesh becomes the box around it.  A visual mesh that is not there is replaced by the
    link's collision shapes.  A collision mesh that is not there is an error if ``needed``, for the
    outline, else left out.  ``notes`` says what was done.  Raises ``ScenarioError``.
    """
    solids = [solid(shape, into, packages, notes, needed) for shape in link.collisions]
    collisions = [shape for shape in solids if shape is not None]
    visuals = []
    for shape in link.visuals:
        if shape.form != "mesh":
            visuals.append(_moved(shape, into))
            continue
        path, why = _mesh_file(shape, packages)
        if path is None:
            instead = [each._replace(colour=shape.colour) for each in collisions]
            visuals += [each for each in instead if each not in visuals]
            done = "its collision shape is drawn instead" if instead else "not drawn"
            notes.append("{}: mesh {}: {}; {}".format(shape.where, shape.mesh, why, done))
        else:
            visuals.append(_moved(shape, into)._replace(mesh=path))
    return Part(tuple(visuals), tuple(collisions))


def _moved(shape, into):
    return shape._replace(transform=into @ shape.transform)


def _mesh_file(shape, packages):
    """Return ``(path, "")`` of a mesh that can be read, or ``(None, why)``."""
    path, why = packages.file(shape.mesh, shape.where)
    if path is None:
        return None, why
    try:
        mesh_points(path)
    except MeshError as error:
        return None, str(error)
    return path, ""


def solid(shape, into, packages, notes, needed):
    """Return ``shape`` placed in its part, a mesh as the box around it; None for a mesh that is not there.

    Arguments as of :func:`found_shapes`.
    """
    if shape.form != "mesh":
        return _moved(shape, into)
    path, why = packages.file(shape.mesh, shape.where)
    try:
        points = mesh_points(path) if path else None
    except MeshError as error:
        points, why = None, str(error)
    if points is None and needed:
        raise ScenarioError(
            "{}: mesh {}: {}; wanted the file, or the key body, since it says how large the robot "
            "is".format(shape.where, shape.mesh, why)
        )
    if points is None:
        notes.append("{}: mesh {}: {}; left out".format(shape.where, shape.mesh, why))
        return None
    notes.append("{}: mesh {}: the box around it is used".format(shape.where, shape.mesh))
    transform = into @ shape.transform
    placed = (points * shape.size) @ transform[:3, :3].T + transform[:3, 3]
    low, high = placed.min(axis=0), placed.max(axis=0)
    box = np.eye(4)
    box[:3, 3] = 0.5 * (low + high)
    return shape._replace(form="box", size=np.maximum(high - low, 1e-6), transform=box, mesh="")


def extent(shapes):
    """Return the least and the greatest coordinates (3,), (3,) [m] of ``shapes``, none of them meshes."""
    spans = [_span(shape) for shape in shapes]
    return np.min([low for low, _ in spans], axis=0), np.max([high for _, high in spans], axis=0)


def _span(shape):
    turn, middle = shape.transform[:3, :3], shape.transform[:3, 3]
    if shape.form == "box":
        half = np.abs(turn) @ (0.5 * shape.size)
    elif shape.form == "cylinder":
        radius, length = shape.size
        along = np.abs(turn[:, 2])
        half = 0.5 * length * along + radius * np.sqrt(np.maximum(0.0, 1.0 - along**2))
    else:
        half = np.full(3, shape.size[0])
    low, high = middle - half, middle + half
    if max(np.abs(low).max(), np.abs(high).max()) > LARGEST:
        text = "{}: reaches {:.3g} m from the robot, wanted within {:g} m"
        raise ScenarioError(
            text.format(shape.where, max(np.abs(low).max(), np.abs(high).max()), LARGEST)
        )
    return low, high
