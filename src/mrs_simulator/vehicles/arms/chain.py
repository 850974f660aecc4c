"""Kinematics of serial arms, for many arms of one model at once.

The tool of m arms with joint positions ``q`` (m, k) is at ``p(q)`` (m, 3) [m] in the frame of the arm's
root link, and moves by ``p' = J(q) q'``.  Column i of J is ``z_i x (p - o_i)`` for a revolute joint with
axis ``z_i`` through ``o_i``, and ``z_i`` for a prismatic one (Siciliano et al., Robotics, 2009, 3.1.3).
"""

from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.scenario.reading import ScenarioError, shown

MOVING = ("revolute", "continuous", "prismatic")


class Chain(NamedTuple):
    """The k joints between an arm's root and its tool, in order."""

    joints: Tuple[str, ...]
    links: Tuple[str, ...]  # those that the joints move
    before: Any  # (k, 4, 4): each joint's frame at 0, seen from the one before it
    axes: Any  # (k, 3), unit vectors in the joints' frames
    slides: Any  # (k,) bool: prismatic
    tool: Any  # (4, 4): the tool, seen from the last joint's frame
    lower: Any  # (k,) [rad or m]
    upper: Any  # (k,) [rad or m]
    speed: Any  # (k,) [rad/s or m/s] the greatest
    effort: Any  # (k,) [N m or N] the greatest
    mass: float  # [kg] of the whole arm


def read_chain(path, joints, tool):
    """Return the ``Chain`` of the URDF at ``path`` that moves the link ``tool`` by ``joints``.

    Raises ``ScenarioError`` that names the file and the joint or link that does not fit.
    """
    # A team without arms reads no description.
    from mrs_simulator.vehicles.importing.description import read_description
    from mrs_simulator.vehicles.importing.xml_reading import read_text

    description = read_description(read_text(path), path)
    if tool not in description.links:
        raise ScenarioError(unknown_name(path + ": link", tool, description.links))
    above = {each.child: each for each in description.joints.values()}
    way, link = [], tool
    while link in above:
        way.insert(0, above[link])
        link = above[link].parent
    moving = tuple(each.name for each in way if each.type in MOVING)
    if moving != tuple(joints):
        text = "{}: joints {} move the link {}, wanted {}"
        raise ScenarioError(text.format(path, ", ".join(moving), shown(tool), ", ".join(joints)))
    before, transform = [], np.eye(4)
    for each in way:
        transform = transform @ each.transform
        if each.type in MOVING:
            before.append(transform)
            transform = np.eye(4)
    own = [each for each in way if each.type in MOVING]
    columns = {
        key: np.array([getattr(each, key) for each in own])
        for key in ("lower", "upper", "effort", "axis")
    }
    return Chain(
        joints=moving,
        links=tuple(each.child for each in own),
        before=np.array(before),
        axes=columns["axis"],
        slides=np.array([each.type == "prismatic" for each in own]),
        tool=transform,
        lower=columns["lower"],
        upper=columns["upper"],
        speed=np.array([each.velocity for each in own]),
        effort=columns["effort"],
        mass=sum(link.mass for link in description.links.values()),
    )


def frames(chain, q):
    """Return the joints' frames, moved to ``q`` (m, k), and the tool's: (m, k + 1, 4, 4)."""
    q = np.asarray(q, dtype=float)
    result = np.empty((len(q), len(chain.axes) + 1, 4, 4))
    now = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for i, before in enumerate(chain.before):
        now = now @ before @ _moved(chain, i, q[:, i])
        result[:, i] = now
    result[:, -1] = now @ chain.tool
    return result


def _moved(chain, i, q):
    """Return what joint ``i`` does at ``q`` (m,), (m, 4, 4): Rodrigues' formula, or a shift."""
    result, axis = np.zeros((len(q), 4, 4)), chain.axes[i]
    result[:, [0, 1, 2, 3], [0, 1, 2, 3]] = 1.0
    if chain.slides[i]:
        result[:, :3, 3] = np.multiply.outer(q, axis)
        return result
    x, y, z = axis
    cross = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    cos, sin = (each[:, np.newaxis, np.newaxis] for each in cos_sin(q))
    result[:, :3, :3] = np.eye(3) + sin * cross + (1.0 - cos) * (cross @ cross)
    return result


def jacobian(chain, found):
    """Return the Jacobians (m, 3, k) [m or -] of the tool's place, of ``found``, what ``frames`` gave."""
    axes = np.einsum("mkij,kj->mki", found[:, :-1, :3, :3], chain.axes)
    ahead = found[:, -1:, :3, 3] - found[:, :-1, :3, 3]
    columns = np.where(chain.slides[:, np.newaxis], axes, np.cross(axes, ahead))
    return np.swapaxes(columns, 1, 2)
