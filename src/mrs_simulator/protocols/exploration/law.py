"""Exploration: a team looks at all of a mapped floor with its lasers."""

import weakref

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Claim, Condition, TooShort
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.kinematics import cos_sin, direction_of, wrap_angle
from mrs_simulator.core.snapshots import Constant
from mrs_simulator.protocols.curves import Curve
from mrs_simulator.protocols.exploration import equations as floors
from mrs_simulator.protocols.exploration import published
from mrs_simulator.scenario.surroundings.obstacles import least_clearance
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State

AHEAD = 2  # [-] cells ahead on its way that a robot heads for
PATIENCE = 1.0  # [s] between two plans
ALL_ROUND = 6.2  # [rad] from the first to the last ray, from which on a laser looks everywhere
CLOSE = 0.7  # [-] of the distance kept from others, within which none heads for another
LOOKS = 2.0  # [1/s] looks at which the verdict sees the floor anew


class Shares(Constant):
    """What :meth:`Exploration.shares` ``found`` of a ``run``, to which it refers weakly."""

    def __init__(self, run, found):
        self.run, self.found = weakref.ref(run), found


class Exploration(PioneerControl):
    """Each robot goes to the nearest cell of the floor that no robot has seen and it is nearest to.

    Nearest by ways that are free for robots: the floor is shared as a Voronoi diagram of these.  What a
    laser shows is seen.  A cell that is still not seen from where its way ends is given up.  A robot that
    heads for a nearby one of a lower number waits, and makes room where one that is close heads for it;
    none heads for one that is close.  Unicycles do not back to where they could not turn.  The law knows
    all robots and the map.

    Theorem: nothing is left in the end, since each plan leads to a cell that is then seen or given up, and
    there are finitely many (greedy mapping: Koenig, Tovey, Smirnov, 2003).
    """

    _newest = None  # the ``Shares`` that :meth:`shares` found last

    SENSORS = ("laser",)
    TAKES_EDGES = False
    PARAMETERS = (
        Parameter("speed", 0.4, "m/s", **POSITIVE, high=5.0, meaning="of controlled points"),
        Parameter("cell", 0.25, "m", low=0.05, high=2.0, meaning="side of a cell of the floor"),
        Parameter("room", 0.45, "m", low=0.0, high=5.0, meaning="kept from obstacles by ways"),
        Parameter("apart", 1.2, "m", low=0.0, high=10.0, meaning="kept from other robots by ways"),
        Parameter("wanted", 0.99, low=0.0, high=1.0, meaning="share of the floor that is to be seen"),
    )  # fmt: skip

    def start(self):
        """Begin with nothing seen."""
        self._floor = self._seen = None
        self._planned, self._goals, self._stamps, self._next = -PATIENCE, {}, {}, {}

    def calculateControlLaw(self, pos_map):
        """Return each robot's ``Twist``."""
        self._pose = np.array([pos_map[number] for number in self.numbers])
        return super().calculateControlLaw(pos_map)

    def pointMassLaw(self, hand):
        if self._floor is None:
            self._floor = self.floor()
            self._seen = np.zeros(self._floor.free.shape, dtype=bool)
        self._look()
        if self.time - self._planned >= PATIENCE - 1e-9:
            self._plan(hand)
            self._planned = self.time
        u = np.array([self._towards(row, point) for row, point in enumerate(hand)])
        waits = self._waits(hand, u)
        u[waits] = 0.0
        self._make_room(hand, u, waits)
        u[self._heads(hand, u, CLOSE * self.apart).any(axis=1)] = 0.0
        self._turn_first(u)
        return u

    def floor(self):
        """Return the ``Floor`` among the scene's obstacles."""
        if not self.obstacles:
            raise ValueError(
                "exploration: nothing stands in the scene, wanted walls around a floor"
            )
        return floors.floor_of(self.obstacles, self.cell, self.room)

    def _look(self):
        (left,) = (self._floor.free & ~self._seen).ravel().nonzero()
        for row, number in enumerate(self.numbers):
            scan = self.readings[number].laser
            if scan is not None and self._stamps.get(row) != scan.stamp:
                self._stamps[row] = scan.stamp
                shown = floors.seen_by(self._floor, self._pose[row], scan, left)
                self._seen.ravel()[shown] = True

    def _plan(self, hand):
        """Choose each robot's cell and the ways to it."""
        floor, cells = self._floor, [self._floor.cell(point) for point in hand]
        ways = [floors.ways(floor.open, floor.size, cell) for cell in cells]
        ways = np.array([floors.beside(way, floor.free, floor.size) for way in ways])
        for row, (goal, _) in list(self._goals.items()):
            if cells[row] == self._end(row) and not self._seen[goal]:
                self._seen[goal] = True  # given up
        nearest = np.argmin(ways, axis=0)
        # Down these, which are no ways, leads away from each robot.
        self._away = np.where(floor.open & np.isfinite(ways), -ways, np.inf)
        self._goals, self._next = {}, {}
        for row in range(len(hand)):
            left = np.where(self._seen | ~floor.free, np.inf, ways[row])
            own = np.where(nearest == row, left, np.inf)
            left = own if np.isfinite(own).any() else left
            if np.isfinite(left).any():
                goal = np.unravel_index(np.argmin(left), left.shape)
                entry = self._entry(ways[row], goal)
                back = floors.ways(self._open_to(row, hand), floor.size, entry)
                if np.isinf(back[cells[row]]):  # others are in the way
                    back = floors.ways(floor.open, floor.size, entry)
                self._goals[row] = goal, back

    def _open_to(self, row, hand):
        """Return the cells (a, b) bool that are open and not next to another robot."""
        away = (
            self._floor.middles[np.newaxis]
            - np.delete(hand, row, axis=0)[:, np.newaxis, np.newaxis]
        )
        return self._floor.open & (np.hypot(away[..., 0], away[..., 1]) > self.apart).all(axis=0)

    def _entry(self, way, goal):
        """Return the open cell in which a robot's ``way`` to the cell ``goal`` ends."""
        while not self._floor.open[goal]:
            lower = floors.downhill(way, goal, 1)
            if lower == goal:
                break
            goal = lower
        return goal

    def _end(self, row):
        """Return the cell in which the way of a robot to its goal ends."""
        return np.unravel_index(np.argmin(self._goals[row][1]), self._seen.shape)

    def _waits(self, hand, u):
        """Return which robots wait, (n,) bool: those heading for a nearby robot of a lower number.

        Or for one that waits for a lower number than theirs: so none wait in a circle.
        """
        meets = self._heads(hand, u, self.apart + self.cell)
        if not meets.any():
            return np.zeros(len(hand), dtype=bool)
        each = np.arange(len(hand))
        own = each[:, np.newaxis]
        after = meets & (each < own)
        first = np.where(after, each, len(hand)).min(axis=1)  # the lowest it waits for
        behind = meets & (each > own) & (first < own)
        return (after | behind).any(axis=1)

    def _make_room(self, hand, u, waits):
        """Let robots that wait close before others go where the nearest of these has farther to go."""
        if waits.any():
            heads = self._heads(hand, u, CLOSE * self.apart)
            for row in waits.nonzero()[0]:
                (others,) = heads[:, row].nonzero()
                if len(others):
                    way = hand[others] - hand[row]
                    other = others[np.argmin(np.hypot(way[:, 0], way[:, 1]))]
                    u[row] = self._along(self._away[other], hand[row], (row, other))

    def _turn_first(self, u):
        """Let unicycles turn in place before they back to where they could touch something as they turn.

        A robot that backs turns round, since its hand point is ahead of its centre.
        """
        if self.fidelity == "point_mass":
            return
        ahead = np.column_stack(cos_sin(self._pose[:, 2]))
        speed = np.einsum("ij,ij->i", ahead, u)
        for row in (speed < 0.0).nonzero()[0]:
            kind, own = self.team.kinds[row], speed[row] * ahead[row]
            if kind.drive == "differential":
                places = self._pose[row, :2] + [np.zeros(2), self.period * own]
                if self._comes_too_near(row, places):
                    u[row] -= own

    def _comes_too_near(self, row, places):
        """Return whether a robot cannot turn at the second of ``places`` (2, 2) [m] of its centre.

        That is nearer than the first to an obstacle, and than its reach, or to another robot, and than the
        reach of both.
        """
        reach = np.array([kind.body.reach for kind in self.team.kinds])
        now, then = least_clearance(self.obstacles, places)
        if then < min(now, reach[row]):
            return True
        way = self._pose[:, :2] - places[:, np.newaxis]
        now, then = np.hypot(way[..., 0], way[..., 1])
        return bool((then < np.minimum(now, reach + reach[row])).any())

    @staticmethod
    def _heads(hand, u, distance):
        """Return which robots head for which others within a ``distance`` [m], (n, n) bool."""
        way = hand - hand[:, np.newaxis]
        near = np.hypot(way[..., 0], way[..., 1]) < distance
        if np.count_nonzero(near) == len(hand):  # each is near itself alone
            return np.zeros(near.shape, dtype=bool)
        return near & (np.einsum("ijk,ik->ij", way, u) > 0.0)

    def _towards(self, row, point):
        """Return the velocity (2,) of a robot on its way."""
        if row not in self._goals:
            return np.zeros(2)
        return self._along(self._goals[row][1], point, row)

    def _along(self, far, point, key):
        """Return the velocity (2,) from a ``point`` (2,) to where the ways ``far`` (a, b) [m] are shorter.

        ``key``: what these ways are of, as long as a plan holds.
        """
        floor, cell = self._floor, self._floor.cell(point)
        if (key, cell) not in self._next:
            then = np.array(floors.downhill(far, cell, AHEAD))
            self._next[key, cell] = floor.corner + floor.size * then
        way = self._next[key, cell] - point
        far = np.hypot(way[0], way[1])
        return min(self.speed, far / self.period) / max(far, 1e-9) * way

    def published(self):
        """Return the law by what each laser should have read."""
        if not self.obstacles:
            return None
        return published.Exploration(self.speed, self.cell, self.room, self.apart)

    # What the verdict measures -------------------------------------------------------------------

    def claims(self, start):
        """Return the claim that all floor that robots can reach is seen."""
        walls = Condition("a floor", bool(self.obstacles), "nothing stands in the scene")
        if not walls.holds:
            return [walls]
        views = [each.settings.last - each.settings.first for each in self._scanners()]
        turning = self.fidelity != "point_mass" and bool(np.all(self.team.lead(self.l)))
        looks = Condition(
            "lasers that look ahead",
            turning or min(views) >= ALL_ROUND,
            "points and bases that keep their headings look one way alone",
        )

        def share(run):
            least = self._seconds(run)
            if run.time[-1] - run.time[0] < least:
                raise TooShort("wanted a run of {:.3g} s".format(least))
            seen = float(self.shares(run)[1][-1])
            if seen < self.wanted and self._is_on_its_way(run):
                raise TooShort("{:.3g} is seen, and robots are still on their way".format(seen))
            return seen

        name = "share of the floor that is seen [-]"
        return [walls, looks, Claim(name, self.wanted, 0.0, share, "at least")]

    @staticmethod
    def _is_on_its_way(run):
        """Return whether a robot was commanded to move after the last plan but one of ``run``."""
        late = run.time >= run.time[-1] - PATIENCE
        return bool(run.command[late].any())

    def _seconds(self, run):
        """Return in what time [s] the team would sweep the floor, each robot half of what it reaches."""
        floor = self.floor()
        most = sum(mount.settings.most for mount in self._scanners())
        return np.count_nonzero(floor.free) * floor.size**2 / (self.speed * most)

    def shares(self, run):
        """Return times (k,) [s] and which share of the floor was seen until then, (k,).

        By lines of sight from the recorded poses, not by what the law saw: the floor are free cells to
        which, or beside which, ways lead from where the first robot begins.
        """
        if self._newest is None or self._newest.run() is not run:
            self._newest = Shares(run, self._shares_of(run))
        return self._newest.found

    def _shares_of(self, run):
        floor, scene = self.floor(), Scenery(self.team, self.obstacles)
        scanners = self._scanners()
        way = floors.ways(floor.open, floor.size, floor.cell(run.hand[0, 0]))
        left = floor.middles[np.isfinite(floors.beside(way, floor.free, floor.size))]
        total = max(1, len(left))
        steps = max(1, int(round(1.0 / (LOOKS * max(1e-9, run.time[1] - run.time[0])))))
        times, shares = run.time[::steps], []
        for time, pose in zip(times, run.pose[::steps]):
            if len(left):
                shapes = scene.at(State(time, pose, np.zeros_like(pose)))
                for row, mount in enumerate(scanners):
                    left = left[~_in_sight(shapes, row, pose[row], mount, left)]
            shares.append(1.0 - len(left) / total)
        return times, np.array(shares)

    def _scanners(self):
        mounts = fitted_mounts(self.team, self._sensor_changes)
        return [{mount.name: mount for mount in own}["laser"] for own in mounts]

    def measures(self, run):
        """Return when half and nine tenths of the floor were seen [s], and the ways driven [m]."""
        time, share = self.shares(run)
        steps = np.linalg.norm(np.diff(run.pose[:, :, :2], axis=0), axis=2)
        result = {"ways_driven": steps.sum(axis=0).tolist(), "floor_seen": float(share[-1])}
        for part in (0.5, 0.9):
            there = np.flatnonzero(share >= part)
            result["seconds_to_{:.0f}_percent".format(100 * part)] = (
                float(time[there[0]] - time[0]) if len(there) else None
            )
        return result

    def curves(self, run):
        """Return the share of the floor that is seen over time."""
        time, share = self.shares(run)
        return [Curve("floor seen [-]", time, share, bound=self.wanted)]


def _in_sight(shapes, row, pose, mount, points):
    """Return which ``points`` (k, 2) [m] the scanner ``mount`` of the robot ``row`` shows, (k,) bool."""
    turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
    origin, numbers = pose[:2] + turn @ mount.place[:2], mount.settings
    way = points - origin
    far = np.hypot(*way.T)
    shown = far < numbers.most
    way, far = way[shown], np.maximum(far[shown], 1e-9)
    bearing = wrap_angle(direction_of(way) - pose[2] - mount.place[3])
    ahead = (bearing >= numbers.first) & (bearing <= numbers.last)
    if ahead.any():
        along = (way[ahead] / far[ahead, np.newaxis])[np.newaxis]
        rays = Rays(
            origin[np.newaxis, np.newaxis], along, np.array([mount.place[2]]), np.array([row])
        )
        ahead[ahead] = cast(shapes, rays, numbers.most)[0] > far[ahead]
    shown[shown] = ahead
    return shown
