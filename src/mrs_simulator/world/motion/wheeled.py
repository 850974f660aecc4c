"""The robots on wheels of a team whose others float or fly: with forces, in a solver of their own."""

import numpy as np

from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.arms.team import ArmedTeam, has_arms
from mrs_simulator.world.motion.dynamic import DynamicMotion
from mrs_simulator.world.motion.planar import PlanarMotion

MOTIONS = {"pybullet": DynamicMotion, "planar": PlanarMotion}  # by engine


def motion_of(engine):
    """Return the class of motion on wheels of an ``engine``; ``ValueError`` for an unknown one."""
    if engine not in MOTIONS:
        raise ValueError("engine {!r}: wanted one of {}".format(engine, ", ".join(MOTIONS)))
    return MOTIONS[engine]


class WheeledPart:
    """The motion of those robots of a team that stand on the ground, with their arms.

    ``arm_rates`` (m, k) [rad/s] are held by the arms' joints from the next step on.
    """

    def __init__(self, team, poses, obstacles, limits, step, mirrored, engine, errors=None):
        """``team``: all robots; ``poses`` (n, 3); ``mirrored``: rows of the team that ``place`` moves;
        ``engine``: as :func:`motion_of` takes it; ``errors``: of wheels, as ``UnevenWheels.of`` does."""
        on_wheels = [kind.module.MEDIUM == "ground" for kind in team.kinds]
        self.rows = np.flatnonzero(on_wheels)
        kinds = [team.kinds[row] for row in self.rows]
        place = self._places(np.array(mirrored, dtype=int))
        own = ArmedTeam(kinds, limits) if has_arms(kinds) else Team(kinds, limits)
        bases = own.bases if own.has_arms else own
        self._columns = [team.axes.index(axis) for axis in bases.axes]
        self.arm_rates = np.zeros((len(kinds), own.arm_joints if own.has_arms else 0))
        self._names = {
            "robot{}".format(member + 1): "robot{}".format(row + 1)
            for member, row in enumerate(self.rows)
        }
        self._others = {"robot{}".format(row + 1) for row in np.flatnonzero(~np.array(on_wheels))}
        given = own, np.asarray(poses)[self.rows], obstacles, limits, step
        self._motion = _motion_of(own, engine)(*given, mirrored=place[place >= 0], errors=errors)

    def _places(self, rows):
        """Return where ``rows`` (m,) of the team are among those on wheels, -1 for none."""
        found = np.searchsorted(self.rows, rows)
        found[found == len(self.rows)] = 0
        return np.where(self.rows[found] == rows, found, -1)

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) of the team at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        members = self._places(np.asarray(rows, dtype=int))
        known = members >= 0
        self._motion.place(members[known], np.asarray(poses)[known], np.asarray(twists)[known])

    def move_obstacles(self, obstacles):
        """Let the ``obstacles`` be where they are after the next step."""
        self._motion.move_obstacles(obstacles)

    def advance(self, command):
        """Return the poses (m, 3) after a step under the team's ``command`` (n, a)."""
        own = command[np.ix_(self.rows, self._columns)]
        self._motion.advance(np.column_stack([own, self.arm_rates]))
        return self._motion.pose

    @property
    def twist(self):
        """Return the body twists, (m, 3) [m/s, m/s, rad/s]."""
        return self._motion.twist

    def joints(self):
        """Return the drives' inner joints, (m,) [rad]."""
        joints = self._motion.joints()
        return joints if joints.ndim == 1 else joints[:, 0]

    @property
    def arms(self):
        """Return positions (m, k) [rad] of the arms' joints, and which are at an end, (m, k) bool."""
        return self._motion.q, self._motion.ended

    def count(self, team, travel):
        """Write into ``travel``, arrays of the groups of ``team``, how far wheels have rolled [m]."""
        on_wheels = (
            own for group, own in zip(team.groups, travel) if group.drive.MEDIUM == "ground"
        )
        for own, rolled in zip(on_wheels, self._motion.wheel_travel):
            own[:] = rolled

    def contacts(self):
        """Return the contacts after the last step, ``(first, second, x, y)`` each."""
        return [
            (*(self._names.get(name, name) for name in contact[:2]), *contact[2:])
            for contact in self._motion.contacts()
        ]

    def knows(self, contact):
        """Return whether a ``bodies.Contact`` is the solver's matter: a robot on wheels with another one or
        with an obstacle."""
        return self._others.isdisjoint(contact[:2])

    def close(self):
        """Disconnect from the solver."""
        self._motion.close()


def _motion_of(team, engine):
    """Return the class of motion of a ``team`` on wheels by its ``engine``."""
    if not team.has_arms:
        return motion_of(engine)
    from mrs_simulator.world.arms.dynamic_arms import ArmedDynamicMotion  # only where it is used

    return ArmedDynamicMotion
