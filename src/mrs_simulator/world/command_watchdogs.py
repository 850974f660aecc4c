"""The commands in force of n robots, and the watchdogs that end them."""

import numpy as np

from mrs_simulator.core.arrays import read_only
from mrs_simulator.core.kinematics import are_within
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH, CommandMismatch
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.part import Part

EVERY = slice(None)  # the rows of all robots
LARGEST_COMMAND = 1e12  # [m/s, rad/s]: far beyond it poses would not be numbers for long
AT_REST = [0.0, 0.0, np.nan, np.nan]  # efforts of thrusters that a watchdog has stopped


class Commands(Part):
    """The commands in force of the robots of a ``team``; after its timeout each robot's is zero."""

    def __init__(self, team, motion, clock, settings):
        """``settings``: the ``WorldSettings``, with watchdogs, and how the motion differs from commands."""
        self._team, self._motion, self._clock = team, motion, clock
        self._fidelity, self._mirrored = settings.fidelity, settings.mirrored
        self._steps_per_watch, timeout = settings.steps_per_watch, settings.cmd_vel_timeout
        self.timeouts = team.timeouts if timeout is None else np.full(team.n, float(timeout))
        self.shortest_timeout = float(self.timeouts.min())
        self._patience = self.shortest_timeout / clock.step_size - 1.0  # [-] steps, at least
        # Drives with a behaviour of their own after the timeout, such as to land.
        self.silence_groups = [group for group in team.groups if hasattr(group.drive, "silent")]
        n = team.n
        self.refused = np.zeros(n, dtype=int)  # how many commands of each robot were refused
        self.target = np.zeros((n, len(team.axes)), order="F")
        self.efforts = None  # (n, 4) of thrusters commanded past their controllers, nan: not so
        self.commanded = np.zeros(n, dtype=bool)  # which robots obey a command
        self.received = np.full(n, -1)  # the step of the last accepted command, -1 for none
        self._longest_silent = clock.steps  # no commanded robot received its last command before it
        self.mismatch = None
        if settings.mismatch != NO_MISMATCH:
            fitting = settings.mismatch.with_robots(n)
            self.mismatch = CommandMismatch(fitting, team.axes, n, clock.step_size)

    def columns(self):
        """Return the commands in force, and of which robots there is one."""
        return {"command": read_only(self.target), "commanded": self.commanded}

    def reset(self):
        """Follow the clock back to 0."""
        self._longest_silent = 0

    def set(self, rows, commands):
        """Give robots ``rows`` (m,), or ``EVERY`` robot, the commands (m, a), as ``team.axes``.

        One that is not finite, or beyond ``LARGEST_COMMAND``, is refused and counted in ``refused``.
        Return whether none was.
        """
        rows = rows if rows is EVERY else np.asarray(rows, dtype=int)
        commands = np.asarray(commands, dtype=float)
        fit = are_within(commands, LARGEST_COMMAND)
        if not fit:
            finite = (np.abs(commands) <= LARGEST_COMMAND).all(axis=1)
            rows = np.arange(self._team.n)[rows]
            np.add.at(self.refused, rows[~finite], 1)
            rows, commands = rows[finite], commands[finite]
        self.target[rows] = commands
        self.received[rows] = self._clock.steps
        self.commanded[rows] = True
        if self.efforts is not None:
            self.efforts[rows] = np.nan
        return fit

    def set_efforts(self, rows, efforts):
        """Command the thrusters of vessels ``rows`` (m,) directly, past the vessels' controllers.

        ``efforts`` (m, 4): commands of the left and the right thruster, force ahead [N] and torque [N m];
        nan where the controllers act, by the command in force; infinite ones are refused and counted.
        :meth:`set` ends it, and so does the watchdog, with thrusters at rest.  Raises ``WorldError`` for
        other robots and without forces.
        """
        rows, efforts = np.asarray(rows, dtype=int), np.asarray(efforts, dtype=float)
        for row in rows.tolist():
            kind = self._team.kinds[row]
            if self._fidelity != "dynamic" or kind.module.MEDIUM != "water":
                raise WorldError(
                    "thrusters of robot{}, a {}, in fidelity {}: wanted a vessel in fidelity "
                    "dynamic".format(row + 1, kind.title, self._fidelity)
                )
        if self.efforts is None:
            self.efforts = self._motion.efforts = np.full((self._team.n, 4), np.nan)
        fits = ~np.isinf(efforts).any(axis=1)
        np.add.at(self.refused, rows[~fits], 1)
        self.efforts[rows[fits]] = efforts[fits]
        self.received[rows[fits]], self.commanded[rows[fits]] = self._clock.steps, True

    def set_arm_rates(self, row, rates):
        """Let the arm of robot ``row`` turn at ``rates`` (k,) [rad/s], whatever its base does."""
        rates = np.asarray(rates, dtype=float)
        if np.abs(rates).max() <= LARGEST_COMMAND:  # nor is nan
            self.target[row, -len(rates) :] = rates

    def stop(self, rows):
        """Make the commands of robots ``rows`` zero."""
        self.target[rows] = 0.0
        if self.efforts is not None:
            self.efforts[rows] = np.nan

    def forget(self, rows):
        """Reset robots ``rows``: they are at rest and have received no command."""
        self.target[rows], self.received[rows], self.commanded[rows] = 0.0, -1, False

    def note_received_by_all(self, step):
        """Record that all robots received a command at ``step``."""
        self.received[:] = step
        self.commanded[:] = True

    @property
    def timed_out(self):
        """Return the robots, (n,) bool, whose last command has timed out.

        Mirrored ones are never among them: they have watchdogs of their own.
        """
        late = (self.received >= 0) & ~self.commanded
        late[self._mirrored] = False
        return late

    @property
    def can_fuse(self):
        """Return whether robots follow their commands exactly; no fused steps are as long as a timeout."""
        return not self.mismatch and self.efforts is None

    def before_step(self, command):
        """Return the commands in force, (n, a), as robots obey them under the ``mismatch``."""
        self._watch()
        if self.silence_groups:
            self._stop_silent(self.timed_out)
        return self.mismatch.applied(self.target) if self.mismatch else self.target

    def _watch(self):
        """Stop robots whose last commands are older than their timeouts."""
        now = self._clock.steps
        if now - self._longest_silent <= self._patience or now % self._steps_per_watch:
            return
        if not self._too_long(self._longest_silent, self.shortest_timeout):
            return
        late = self._too_long(self.received, self.timeouts) & self.commanded
        if late.any():
            self.target[late] = 0.0
            self.commanded[late] = False
            if self.efforts is not None:
                driven = late & ~np.isnan(self.efforts).all(axis=1)
                self.efforts[driven] = AT_REST
        self._longest_silent = int(self.received[self.commanded].min(initial=self._clock.steps))

    def _stop_silent(self, late):
        """Give robots ``late``, (n,) bool, their drives' commands after a timeout, such as to land."""
        for group in self.silence_groups:
            rows = np.arange(self._team.n)[group.rows]
            out = late[rows]
            if out.any():
                seconds = self._clock.since(self.received[rows]) - self.timeouts[rows]
                command = group.of(self.target).copy()
                command[out] = group.drive.silent(seconds, group.numbers)[out]
                group.put(self.target, command)

    def _too_long(self, received, timeout):
        return self._clock.since(received) > timeout - 1e-9
