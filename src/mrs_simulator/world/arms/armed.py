"""Robots with arms: bases move as they do without, and the arms' joints turn beside them."""

import numpy as np

AT_END = 1e-6  # [rad] from the end of a joint, at which it counts as reached


class ArmedMotion:
    """A motion of the bases, with arms on top whose joints follow their rates at once.

    All other attributes are those of the bases' motion.
    """

    def __init__(self, team, bases, mirrored=()):
        """``team``: the ``ArmedTeam``; ``bases``: the motion of ``team.bases``.

        ``mirrored``: rows of robots whose arms stay as they are.
        """
        self.team, self._bases = team, bases
        self._mirrored = np.array(mirrored, dtype=int)
        self.q = team.rest_joints[:, 1:].copy()
        self.ended = np.zeros(self.q.shape, dtype=bool)

    def __getattr__(self, name):
        return getattr(self._bases, name)

    @property
    def efforts(self):
        """Efforts of thrusters that are commanded past their controllers, as of the bases' motion."""
        return self._bases.efforts

    @efforts.setter
    def efforts(self, efforts):
        self._bases.efforts = efforts

    def joints(self):
        """Return the drives' inner joints and the arms', (n, 1 + k) [rad]."""
        return np.column_stack([self._bases.joints(), self.q])

    def advance(self, command):
        """Move for one step under ``command`` (n, a + k), a column for each axis of the team.

        ``ended`` (n, k) bool then says which joints are at an end.
        """
        base, rates = self.team.split(command)
        self._bases.advance(base)
        rates = rates.copy()
        rates[self._mirrored] = 0.0
        step, team = self._bases.step, self.team
        self.q = team.moved(self.q, rates, step)
        self.ended = (self.q > team.upper - AT_END) | (self.q < team.lower + AT_END)
        self.ended &= team.rates > 0.0


class ArmedForcedMotion(ArmedMotion):
    """``ArmedMotion`` with forces, of a team in which others float or fly.

    Arms are bodies with their bases, in the solver of the robots on wheels.
    """

    def advance(self, command):
        base, rates = self.team.split(command)
        wheeled = self._bases.wheeled
        wheeled.arm_rates[:] = rates[wheeled.rows]
        self._bases.advance(base)
        self.q[wheeled.rows], self.ended[wheeled.rows] = wheeled.arms
