"""Arms and their load in a picture: links as cylinders between the joints, the load as a box."""

import functools
import math

import numpy as np

from mrs_simulator.core.spatial import rotated
from mrs_simulator.pictures.solids import TILE, model_of
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.state.columns import JOINTS
from mrs_simulator.vehicles.arms.chain import frames
from mrs_simulator.vehicles.arms.models import chain_of
from mrs_simulator.vehicles.importing.placing import roll_pitch_yaw
from mrs_simulator.vehicles.shape import Part

THICK, THIN = 0.06, 0.04  # [m] radii of the first link and of the last
KNUCKLE = 1.2  # [-] of a link's radius
SHORT = 0.02  # [m], below which two joints are in one place
LIGHT, DARK = (0.86, 0.86, 0.84, 1.0), (0.35, 0.36, 0.38, 1.0)
WOOD = (0.76, 0.58, 0.36, 1.0)
ABOVE = 0.01  # [m] by which an arm is nearer to the eye than the base that it stands on
LOAD_TILE = 0.5 * TILE  # [m]
STRAIGHT = 1e-12  # [m^2] of a corner's triangle, below which it is none


class Placed:
    """Arms of one model on m robots, and where their links are."""

    def __init__(self, rows, model, links):
        """``rows`` (m,) of the robots with an ``ArmModel``; ``links`` (m, k + 1, 4, 4), common frame."""
        self.rows, self.model, self.links = rows, model, links

    @property
    def models(self):
        """Return the ``Model`` of each link, a tuple."""
        return arm_models(self.model)


def scene_arms(scene):
    """Return the arms of a scene's robots, a list of ``Placed``."""
    if all(kind.arm is None for kind in set(scene.kinds)):
        return []
    joints = scene.state.joints if scene.state.has(JOINTS) else None
    return placed_arms(scene.kinds, scene.place, scene.turn, joints)


def placed_arms(kinds, place, turn, joints):
    """Return the arms, a list of ``Placed``, of robots at ``place`` (n, 3), turned by ``turn`` (n, 3, 3).

    ``joints`` (n, 1 + k) [rad]; None, or fewer than an arm has: at home.  Arms without a description
    are left out.
    """
    rows_of = {}
    for row, kind in enumerate(kinds):
        if kind.arm is not None:
            rows_of.setdefault(kind.arm.model, []).append(row)
    found = []
    for model, rows in rows_of.items():
        arms = [kinds[row].arm for row in rows]
        try:
            chain = chain_of(model)
        except ScenarioError:
            continue
        q = np.array([arm.home for arm in arms])
        if np.ndim(joints) == 2 and joints.shape[1] > q.shape[1]:
            q = joints[rows, 1 : 1 + q.shape[1]]
        bases = np.tile(np.eye(4), (len(rows), 1, 1))
        bases[:, :3, :3], bases[:, :3, 3] = turn[rows], place[rows]
        roots = bases @ np.array([arm.placed for arm in arms])
        inner = roots[:, np.newaxis] @ frames(chain, q)
        links = np.concatenate([roots[:, np.newaxis], inner[:, :-1]], axis=1)
        found.append(Placed(np.array(rows), model, links))
    return found


@functools.lru_cache(maxsize=None)
def arm_models(model):
    """Return the ``Model``s of an ``ArmModel``'s root and links, each in its own frame, a tuple."""
    models = map(model_of, arm_parts(model))
    return tuple(each._replace(own=np.zeros(len(each.own))) for each in models)


def arm_parts(model):
    """Return the ``Part``s of an ``ArmModel``'s root and links, each a list in its own frame, a tuple."""
    chain = chain_of(model)
    ends = [each[:3, 3] for each in chain.before] + [chain.tool[:3, 3]]
    axes = [None, *chain.axes]
    radii = np.linspace(THICK, THIN, len(ends))
    return tuple(_link(*each) for each in zip(ends, axes, radii))


def _link(end, axis, radius):
    """Return the parts of a link to ``end`` (3,) [m], about whose begin the joint turns by ``axis``."""
    parts, length = [], float(np.linalg.norm(end))
    if length > SHORT:
        parts.append(_rod(0.5 * end, end / length, radius, length, LIGHT))
    if axis is not None:
        parts.append(_rod(np.zeros(3), axis, KNUCKLE * radius, 2.0 * KNUCKLE * radius, DARK))
    return parts or [_rod(np.zeros(3), np.array([0.0, 0.0, 1.0]), radius, radius, DARK)]


def _rod(middle, along, radius, length, colour):
    """Return a cylinder about ``middle`` (3,) [m] ``along`` a unit vector (3,)."""
    side = np.eye(3)[np.argmin(np.abs(along))]
    across = np.cross(along, side)
    across /= np.linalg.norm(across)
    turn = np.eye(4)
    turn[:3, :3] = np.column_stack([across, np.cross(along, across), along])
    return Part("cylinder", (radius, length), (*middle, *roll_pitch_yaw(turn)), colour)


@functools.lru_cache(maxsize=8)
def load_tile(size):
    """Return the ``Model`` of a tile of a box of ``size`` [m], and the tiles' middles (t, 3) [m]."""
    longest = int(np.argmax(size))
    count = max(1, math.ceil(size[longest] / LOAD_TILE))
    own = list(size)
    own[longest] /= count
    middles = np.zeros((count, 3))
    middles[:, longest] = (np.arange(count) + 0.5) * own[longest] - 0.5 * size[longest]
    model = model_of([Part("box", tuple(own), (0.0,) * 6, WOOD)])
    return model._replace(own=np.zeros(6), crisp=np.zeros(6, dtype=bool)), middles


def load_corners(load, carried):
    """Return the corners (8, 3) [m] of the ``load`` where it is ``carried``, a ``load.LoadState``."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    turn = np.broadcast_to(carried.orientation, (8, 4))
    return carried.place + rotated(turn, 0.5 * signs * load.size)


def load_outline(load, carried):
    """Return the outline (h, 2) [m] of the ``load``, seen from above, where it is ``carried``."""
    return convex_hull(load_corners(load, carried)[:, :2])


def arm_outlines(links):
    """Return rectangles (k, 4, 2) [m] around an arm's ``links`` (k + 1, 4, 4), seen from above."""
    joints = links[:, :2, 3]
    along = np.diff(joints, axis=0)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(length > SHORT, along / np.maximum(length, SHORT), (1.0, 0.0))
    ends = THIN * along, THIN * np.column_stack([-along[:, 1], along[:, 0]])
    begin, end = joints[:-1] - ends[0], joints[1:] + ends[0]
    corners = begin - ends[1], end - ends[1], end + ends[1], begin + ends[1]
    return np.stack(corners, axis=1)


def convex_hull(points):
    """Return the corners (h, 2) of the convex hull of ``points`` (k, 2), in order (Andrew's chains)."""
    order = sorted(map(tuple, points.tolist()))

    def chain(those):
        found = []
        for x, y in those:
            while len(found) > 1:
                (ax, ay), (bx, by) = found[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > STRAIGHT:
                    break
                found.pop()
            found.append((x, y))
        return found[:-1]

    return np.array(chain(order) + chain(order[::-1]))
