"""Manoeuvres of flying robots: take off, land, and stay down."""

import numpy as np

NONE, RISING, LANDING, DOWN = range(4)
THERE, STILL = 0.01, 0.02  # [m, m/s] of the wanted height and of rest, within which a robot hovers
HOVER_HEIGHT = 1.0  # [m] of a take-off that names none
SLOW = 0.1  # [m/s, rad/s] of a command, below which a robot is said to hover


class Manoeuvres:
    """The robots of a team that take off or land, whatever their commands.

    One that has landed so stays down until it takes off.
    """

    def __init__(self, team):
        self._team, self._flies = team, team.airborne
        self._groups = [g for g in team.groups if hasattr(g.drive, "climbing")]
        self._doing = np.zeros(team.n, dtype=int)
        self._height = np.zeros(team.n)
        self.busy = False  # whether any robot does not obey its commands

    @property
    def rising(self):
        """Return which robots, (n,) bool, are taking off."""
        return self._doing == RISING

    def take_off(self, rows, height):
        """Let robots ``rows`` rise to ``height`` [m], and hover."""
        self._doing[rows], self._height[rows], self.busy = RISING, height, True

    def land(self, rows):
        """Let robots ``rows`` come down where they are, and stay there."""
        self._doing[rows] = np.where(self._doing[rows] == DOWN, DOWN, LANDING)
        self.busy = True

    def release(self, rows):
        """Let robots ``rows`` obey their commands again."""
        self._doing[rows] = NONE
        self.busy = bool(self._doing.any())

    def applied(self, command, z, climb, all_wait=False):
        """Return what robots at heights ``z`` (n,) [m] obey instead of ``command`` (n, a).

        ``climb`` (n,) [m/s]: how fast they rise; ``all_wait``: whether all others stand still meanwhile.
        """
        there = self.rising & (np.abs(self._height - z) < THERE) & (np.abs(climb) < STILL)
        self.release(there)
        self._doing[(self._doing == LANDING) & (z <= 0.0)] = DOWN
        result = np.array(command, order="F")
        result[slice(None) if all_wait else self._doing != NONE] = 0.0
        for group in self._groups:
            rows = np.arange(self._team.n)[group.rows]
            own, doing = group.of(result).copy(), self._doing[rows]
            rise = group.drive.climbing(z[rows], self._height[rows], group.numbers)
            land = group.drive.landing(len(rows), group.numbers)
            own[doing == RISING] = rise[doing == RISING]
            own[doing == LANDING] = land[doing == LANDING]
            group.put(result, own)
        return result

    def state(self, row, z, powered, upside_down, command):
        """Return what robot ``row`` does, in a word or two."""
        if upside_down:
            return "upside down"
        if not powered:
            return "motors off" if z <= 0.0 else "falling"
        if self._doing[row] in (RISING, LANDING):
            return "taking off" if self._doing[row] == RISING else "landing"
        if z <= 0.0:
            return "landed"
        return "flying" if np.abs(command).max() > SLOW else "hovering"
