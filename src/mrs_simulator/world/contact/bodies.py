"""Footprints of the robots among obstacles: contacts, and how overlapping bodies are separated."""

import math

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import least_distance, squared, squared_apart
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, is_flat
from mrs_simulator.vehicles import Team
from mrs_simulator.world.contact.collisions import (
    SKIN,
    Footprints,
    Pairs,
    Rectangles,
    VerletList,
    circle_overlap,
    outline_overlap,
    rectangle_overlap,
)
from mrs_simulator.world.contact.compiled_contacts import APART, STALE, compiled_push
from mrs_simulator.world.contact.contact_arrays import Contact, Touches, robot_name
from mrs_simulator.world.contact.heights import Heights

PASSES = 4  # [-] rounds of pushing apart in one step
LOOSE = 0.3  # [m] beyond reach, for which pairs are looked at again and again within a step
CLOSE = 0.05  # [m] beyond reach, for which pairs are looked at again as bodies are pushed apart
ROUNDING = 1e-6  # [m] by which positions may be rounded, generously


class Bodies:
    """Robots, each with its own footprint, among fixed obstacles."""

    def __init__(self, kinds, obstacles=(), mirrored=()):
        """``kinds``: the robots' ``Team``, or their kinds; ``obstacles``: ``Box`` and ``Cylinder``.

        ``mirrored``: rows of robots that are where they are and give way to nothing.
        """
        team = Team.of(kinds)
        self.footprints = Footprints([kind.body for kind in team.kinds])
        self._moves = any(map(moves, obstacles))
        self._stand(tuple(obstacles))
        self._halves = np.array([_halves(each) for each in self.obstacles])
        self.mirrored = np.zeros(team.n, dtype=bool)
        self.mirrored[list(mirrored)] = True
        self._are_mirrored = self.mirrored.any()
        # Robots that a solver keeps apart from each other and from obstacles.
        self.solved = np.zeros(team.n, dtype=bool)
        # (n,) bool of those that a solver cannot move, since they stand; None: no robot
        self.resting = None
        self._is_plain = self.footprints.round is None and not (self._are_mirrored or obstacles)
        self._outlines = self.footprints.of_all(team.n)[::-1]
        self._list = VerletList(2.0 * self.footprints.farthest)
        self._bounds = np.square([  # of ``push_all``
            0.5 * SKIN, self._list.reach + LOOSE, 0.5 * LOOSE, self._list.reach,
            0.5 * CLOSE, self._list.reach + CLOSE,
        ])  # fmt: skip
        self._kept_of = self._known = None  # listed pairs, and what it takes of them
        self.moved_elsewhere()
        self.heights = Heights(team)
        self._afloat = team.afloat  # what floats draws water, and runs aground

    def _stand(self, obstacles):
        self.obstacles, self._still = obstacles, None  # of them and the bodies, for ``around``
        self._middles = np.array([[each.x, each.y] for each in obstacles])
        yaw = np.array([getattr(each, "yaw", 0.0) for each in obstacles])
        self._turned = np.cos(yaw), np.sin(yaw)

    @property
    def moves(self):
        """Return whether obstacles move."""
        return self._moves

    def move_obstacles(self, obstacles):
        """Let the ``obstacles``, of the same number and sizes, be where they are now."""
        self._stand(obstacles)
        self._free = self.room = 0.0  # what was known of the room is so no more

    def moved_elsewhere(self):
        """To be called when robots were put to new places."""
        self._list.clear()
        self._looked = None  # where robots were (n, 2) when they were last looked at
        self._free = 0.0  # [m] that each may be from there before any two bodies can touch
        self.room = 0.0  # [m] that each may still move, by what is known without looking
        self._headed = None  # a pose, and cosine and sine of its headings
        self._measured = None  # a pose, and of its pairs what ``push_all`` measures [m]

    def list_by(self, loop):
        """Let pairs be listed by the compiled ``near_pairs``, of as many robots as it is for; None: not."""
        self._list.loop = loop

    def list_anew(self):
        """Let pairs be listed anew when they are asked for again."""
        self._list.clear()

    def around(self, pose):
        """Return what ``stretch_parts.room_around`` takes, of robots now at ``pose`` (n, 3)."""
        first, second, origin = self._list.listed(pose[:, :2])
        if self._still is None:
            n, k = len(pose), len(self.obstacles)
            reach = np.broadcast_to(self.footprints.reach, n).copy()
            bounds = np.array([self._list.reach, 0.5 * SKIN, ROUNDING])
            posts = np.empty((6, k))
            posts[:2], posts[2:4] = self._middles.reshape(k, 2).T, self._turned
            posts[4:] = self._halves.reshape(k, 2).T
            self._still = bounds, reach, posts
        return first, second, origin, *self._still

    def near_pairs(self, pose):
        """Return the rows of all pairs of robots that may touch soon."""
        return self._list.pairs(pose[:, :2])

    def overlaps(self, pose, z=None):
        """Return the robot pairs that overlap: rows (m,), (m,), depth (m,), direction (m, 2).

        ``z`` (n,) [m]: the heights on which they are, None for a team on the ground.
        """
        return self._overlaps(self._pairs_at(pose), pose, z)

    def _pairs_at(self, pose):
        """Return the ``Pairs`` of robots that overlap, or would if each moved by half of ``LOOSE``."""
        first, second = self.near_pairs(pose)
        near = squared_apart(pose[:, :2], first, second) < (self._list.reach + LOOSE) ** 2
        if self.solved.any():
            near &= ~(self.solved[first] & self.solved[second])
        near = np.flatnonzero(near)
        return Pairs(self.footprints, pose, first.take(near), second.take(near))

    def _overlaps(self, pairs, pose, z):
        hit, depth, direction = pairs.overlaps(pose)
        first, second = pairs.first[hit], pairs.second[hit]
        if z is None:
            return first, second, depth, direction
        hit = self.heights.shared(z, first, second) > 0.0
        return first[hit], second[hit], depth[hit], direction[hit]

    def closest(self, pose, z=None):
        """Return the least distance [m] between two centres; quick where two bodies are in contact."""
        if z is not None:
            return least_distance(np.column_stack([pose[:, :2], z]))
        nearest = self._nearest(pose)
        # Every pair within reach is listed.
        if nearest < self._list.reach**2:
            return math.sqrt(nearest)
        return least_distance(pose[:, :2])

    def _nearest(self, pose):
        """Return the square of the least distance [m^2] of the pairs listed, inf of none."""
        if self._measured is not None and self._measured[0] is pose:
            return self._measured[1]
        first, second = self.near_pairs(pose)
        return squared_apart(pose[:, :2], first, second).min() if len(first) else np.inf

    def headings(self, pose):
        """Return cosine and sine (n,) of the headings of ``pose`` (n, 3), which are not to be changed."""
        if self._headed is None or self._headed[0] is not pose:
            self._headed = pose, cos_sin(pose[:, 2])
        return self._headed[1]

    def obstacle_overlaps(self, pose, z=None):
        """Yield, for each obstacle touched, ``(obstacle, rows, depth, direction to it)``."""
        if not self.obstacles:
            return
        near = self._obstacle_gaps(pose) < ROUNDING
        for k in np.flatnonzero(near.any(axis=0)).tolist():
            obstacle, within = self.obstacles[k], near[:, k]
            if is_flat(obstacle):
                within &= self._afloat
            elif z is not None:
                within &= z < obstacle.height
            free = ~self.solved if self.resting is None else ~self.solved | self.resting
            rows = np.flatnonzero(within & free)
            if not len(rows):
                continue
            depth, direction = self._overlap_with(obstacle, pose, rows)
            hit = depth > 0.0
            if hit.any():
                yield obstacle, rows[hit], depth[hit], direction[hit]

    def _obstacle_gaps(self, pose):
        """Return how far robots are from reaching obstacles, (n, obstacles) [m], or less.

        Along the obstacles' own axes, so that a robot beside a long wall is as far from it as it is.
        """
        away = pose[:, np.newaxis, :2] - self._middles
        (cos, sin), x, y = self._turned, away[..., 0], away[..., 1]
        along = np.abs(cos * x + sin * y) - self._halves[:, 0]
        across = np.abs(cos * y - sin * x) - self._halves[:, 1]
        reach = np.broadcast_to(self.footprints.reach, len(pose))
        return np.maximum(along, across) - reach[:, np.newaxis]

    def _overlap_with(self, obstacle, pose, rows):
        own = self.footprints.at(pose[rows], rows)
        middle = np.broadcast_to(np.array([obstacle.x, obstacle.y]), (len(rows), 2))
        yaw, half = getattr(obstacle, "yaw", 0.0), _halves(obstacle)
        axis = np.broadcast_to(np.array([np.cos(yaw), np.sin(yaw)]), middle.shape)
        other, circle = Rectangles(middle, axis, half), isinstance(obstacle, Cylinder)
        if self.footprints.round is None:
            if circle:
                return circle_overlap(own, middle, obstacle.radius)
            return rectangle_overlap(own, other)
        return outline_overlap(own, other, self.footprints.round[rows], np.full(len(rows), circle))

    def separate(self, pose, travel=np.inf, z=None):
        """Push overlapping bodies of ``pose`` (n, 3) apart, in place; return the contacts found.

        ``z`` (n,) [m]: the heights on which they are, also changed in place; None on the ground.  Bodies
        above each other, of which one can fly, part upwards and downwards where that is the shorter way.

        Robots give way by half of the depth each, to a mirrored robot by all of it; an obstacle and
        a mirrored robot not at all.  Headings stay.  ``travel`` [m]: no robot moved farther since
        the last call, ``inf`` where that is not known; while no two bodies can have come together since
        they were last looked at, none is looked at.
        """
        self._measured = None
        self.room -= travel
        if self.room <= 0.0 < self._free:
            moved = float(squared(pose[:, :2] - self._looked).max())
            self.room = self._free - math.sqrt(moved)
        if self.room > 0.0:
            return []
        contacts, room = [], self._room_to_move(pose) if self._free > 0.0 else 0.0
        if not room > 0.0:
            contacts = self._pushed_apart(pose, z)
            if self._moves:
                return contacts
            room = 0.0 if contacts else self._room_to_move(pose)
        self._free = self.room = room
        self._looked = pose[:, :2].copy(order="F")
        return contacts

    def _room_to_move(self, pose):
        """Return how far [m] all robots may move from ``pose`` before any two bodies can touch."""
        if self._measured is None:
            room = self._list.room(pose[:, :2])
        else:
            nearest, moved = map(math.sqrt, self._measured[1:])
            room = min(0.5 * SKIN - moved, 0.5 * (nearest - self._list.reach))
        if self.obstacles:
            room = min(room, float(self._obstacle_gaps(pose).min()))
        return float(room) - ROUNDING  # a number of Python's, which each step counts down

    def _pushed_apart(self, pose, z=None):
        if z is None and self.is_plain:
            contacts = self._pushed_by_loop(pose)
            if contacts is not None:
                return contacts
        contacts, pairs = Touches(), self._pairs_at(pose)
        for turn in range(PASSES):
            if turn and pairs.left(pose, 0.5 * LOOSE):
                pairs = self._pairs_at(pose)
            first, second, depth, direction = self._overlaps(pairs, pose, z)
            touched = len(first) > 0
            if touched:
                if turn == 0:
                    contacts = self._robot_contacts(pose, first, second, depth, direction, z)
                if z is not None:
                    across = self.heights.part(z, first, second, depth, self.mirrored)
                    first, second = first[across], second[across]
                    depth, direction = depth[across], direction[across]
                back, on = self._shares(first, second)
                _push(pose, first, second, back * depth, on * depth, direction)
            for obstacle, rows, deep, toward in self.obstacle_overlaps(pose, z):
                if turn == 0:
                    found = self._obstacle_contacts(obstacle, pose, rows, deep, toward, z)
                    contacts.others.extend(found)
                free = ~self.mirrored[rows]
                if z is not None:
                    free &= self.heights.part_from_obstacle(z, rows, deep, obstacle, free)
                pose[rows[free], :2] -= (deep[:, np.newaxis] * toward)[free]
                touched = True
            if not touched:
                break
        return contacts

    def _pushed_by_loop(self, pose):
        """As ``_pushed_apart``, compiled, once that pays; None where it cannot be."""
        push = same_bits(compiled_push)
        if push is None:
            return None
        hits, listed = STALE, self._list.listed_last()
        if listed is not None:
            hits, *measured = self._push(push, pose, listed)
        if hits == STALE:
            hits, *measured = self._push(push, pose, self._list.listed(pose[:, :2]))
            if hits == STALE:
                return None
        if measured[1] <= self._bounds[0]:
            self._measured = (pose, *measured)
        return self.touches(hits)

    def step_by_loop(self, step, given, pose, after):
        """Let the compiled ``crowd_steps.step_all`` move robots; return the contacts.

        ``given``: its arguments up to ``reach``; ``pose`` (n, 3), which it fills, and what it fills
        ``after`` it.  None where it cannot be, with nothing done.
        """
        room = self.room, self._free, (pose if self._looked is None else self._looked)[:, :2].T
        known = self.looked_up(given[0][0].T)
        for _ in range(2):
            hits, nearest, moved, left = step(*given, (pose.T, *after), room, *known)
            if hits != STALE:
                break
            known = self._looked_up(self._list.listed(pose[:, :2]))
        else:
            return None
        self.room, self._measured = left, None
        if hits == APART:
            return []
        self._headed = pose, after[1]
        if moved <= self._bounds[0]:
            self._measured = pose, nearest, moved
        self._free = self.room = 0.0 if hits else self._room_to_move(pose)
        self._looked = pose[:, :2]
        return self.touches(hits)

    @property
    def looked(self):
        """Return where robots were (n, 2) when they were last looked at, None before; and how far [m] each
        may be from there, and may still move, before any two bodies can touch."""
        return self._looked, self._free, self.room

    def looked_up(self, pose):
        """Return what ``crowd_steps.step_all`` takes as ``pairs`` of robots at ``pose`` (n, 3)."""
        return self._looked_up(self._list.listed_last() or self._list.listed(pose[:, :2]))

    def go_on_from(self, pose, headings, looked, hits):
        """Go on from where a loop has moved robots to; return the contacts, of so many pairs.

        ``headings``: cosine and sine of those of ``pose`` (n, 3), or None; ``looked`` as above.
        """
        self._looked, self._free, self.room = looked
        self._headed, self._measured = headings and (pose, headings), None
        return self.touches(hits)

    @property
    def is_plain(self):
        """Return whether all are rectangles that give way alike, and there is nothing else."""
        return self._is_plain and not np.count_nonzero(self.solved)

    def _looked_up(self, listed):
        """Return what ``push_all`` takes after the headings, with the pairs ``listed``.

        No passes where it cannot push these bodies apart.
        """
        if self._kept_of is not listed:
            m, n = len(listed[0]), listed[2].shape[1]
            kept = np.empty((2, m + 1), int), np.empty((2, n)), np.array([-1])
            self._kept_of, self._room_for = listed, (np.empty((2, m), int), np.empty((3, m)))
            passes = PASSES if self.is_plain else 0
            self._known = self._outlines, listed, kept, self._bounds, passes, *self._room_for
        return self._known

    def touches(self, hits):
        """Return the ``Touches`` of so many pairs, as ``push_all`` has filled them in."""
        if not hits:
            return Touches()
        rows, found = (each[:, :hits].copy() for each in self._room_for)
        return Touches(*rows, found[:2].T, found[2], np.zeros(hits))

    def _push(self, push, pose, listed):
        """Return what ``push_all`` does of robots at ``pose`` (n, 3), which it moves."""
        columns = np.ascontiguousarray(pose.T)  # as it is, mostly
        result = push(columns, *self.headings(pose), *self._looked_up(listed))
        if not pose.flags.f_contiguous:
            pose[:, :2] = columns[:2].T
        return result

    def _shares(self, first, second):
        """Return which part of the depth the robots of each pair give way by, (m,) or one for all, each."""
        if not self._are_mirrored:
            return 0.5, 0.5
        firm, other_firm = self.mirrored[first], self.mirrored[second]
        back = np.where(firm, 0.0, np.where(other_firm, 1.0, 0.5))
        on = np.where(other_firm, 0.0, np.where(firm, 1.0, 0.5))
        return back, on

    def firm_contacts(self, pose):
        """Return the contacts of mirrored robots with each other and with obstacles."""
        pair = self.overlaps(pose)
        firm = self.mirrored[pair[0]] & self.mirrored[pair[1]]
        contacts = list(self._robot_contacts(pose, *(each[firm] for each in pair)))
        for obstacle, *touch in self.obstacle_overlaps(pose):
            firm = self.mirrored[touch[0]]
            contacts += self._obstacle_contacts(obstacle, pose, *(each[firm] for each in touch))
        return contacts

    def _robot_contacts(self, pose, first, second, depth, direction, z=None):
        middle = 0.5 * (pose[first, :2] + pose[second, :2])
        height = np.zeros(len(first)) if z is None else self.heights.middle(z, first, second)
        return Touches(first, second, middle, depth, height)

    def _obstacle_contacts(self, obstacle, pose, rows, depth, direction, z=None):
        half = (
            self.footprints.half if self.footprints.half.ndim == 1 else self.footprints.half[rows]
        )
        where = pose[rows, :2] + half[..., 1:] * direction
        height = np.zeros(len(rows)) if z is None else z[rows]
        return [
            Contact(robot_name(i), obstacle.name, x, y, deep, high)
            for i, (x, y), deep, high in zip(
                rows.tolist(), where.tolist(), depth.tolist(), height.tolist()
            )
        ]


def _push(pose, first, second, back, on, direction):
    """Move robots ``first`` by ``back`` against ``direction`` (m, 2), ``second`` by ``on`` along it, [m].

    In place.  A robot in several pairs is moved pair by pair: ``np.bincount`` adds in this order, and takes
    a tenth of the time of ``np.add.at`` before numpy 1.25.
    """
    n = len(pose)
    rows = np.concatenate([np.arange(n), first, second])
    for place, toward in zip(pose[:, :2].T, direction.T):
        place[:] = np.bincount(rows, np.concatenate([place, -back * toward, on * toward]), n)


def _halves(obstacle):
    """Return half of the length and the width (2,) [m] along the obstacle's own axes."""
    if isinstance(obstacle, Cylinder):
        return np.full(2, obstacle.radius)
    return np.array([0.5 * obstacle.length, 0.5 * obstacle.width])
