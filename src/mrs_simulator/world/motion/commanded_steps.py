"""Unicycles that touch or do not, moved from command to command in one call that numba compiles.

What is wanted of them, or of their points, is mapped, limited and followed, bodies are pushed apart,
contacts and samples are noted, all to numpy's bits, by the loops of ``crowd_steps``.  The law is left to
Python.
"""

import functools
import math

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_neighbours import compiled_near
from mrs_simulator.core.compiled_terms import kept as kept_kernel
from mrs_simulator.core.compiling import entry_of, is_chosen, is_kept
from mrs_simulator.core.kinematics import FASTEST
from mrs_simulator.scenario.scenario import MOST_ROBOTS
from mrs_simulator.sensors.state import State
from mrs_simulator.world.contact.bodies import ROUNDING
from mrs_simulator.world.contact.collisions import SKIN
from mrs_simulator.world.contact.compiled_contacts import APART, note_all
from mrs_simulator.world.contact.compiled_contacts import STALE as LIST_IS_STALE
from mrs_simulator.world.contact.contact_arrays import PairsBegun
from mrs_simulator.world.contact.contacts import FORGET
from mrs_simulator.world.motion.crowd_steps import step_all
from mrs_simulator.world.motion.stretch_parts import copy, keep
from mrs_simulator.world.motion.stretches import SCOPES

FLOAT = np.dtype(float)
FEW = 5  # [-] steps for which it does not pay to begin
# Why steps ended: a command is due; no more samples, or steps, are wanted; pairs are to be listed anew; the
# next step is the world's own; no usable command; a robot is farther away than a sample may have it;
# there is no room for more contacts.
DUE, ENOUGH, STALE, BY_STEP, ODD, FAR, CROWDED = range(7)
# What is done before the first step.
NOTHING, SAMPLE, COMMAND = range(3)
# What ``counts`` has: which of two buffers holds the state, and whether its headings are known; which of
# two the pairs that have touched, and how many these are; pairs that touched in the last step; collisions
# begun; samples kept.
STATE, HEADED, NOTED, PAIRS, TOUCHES, BEGUN, FILLED = range(7)
# What ``numbers`` has [m]: how far each robot may still move before two may touch, how far it could have
# where robots were last looked at; the least distance of centres so far.
LEFT, FREE, CLOSEST = range(3)


def steps_between(plan, state, wanted, given, step, reach, pairs, noted, kept):
    """Make steps until a command is due; return ``(the step, why it ended)``, by the codes above.

    ``plan``: the step now, the last one wanted, after how many a command is due, and a sample, and what is
    done first.  ``state``: ``counts``, ``numbers``, poses (2, 3, n), inner velocities (2, 2, n) and
    headings' cosines and sines (2, 2, n), two buffers of each, where robots were last looked at (2, n), and
    the command in force (2, n).  ``wanted``: of the points velocities (2, n) and arms (n,) [m], or without
    arms (0,) commands; the limits of commands (2, n), their scope, a row of ``SCOPES``; arms (n,) [m] of
    the points that are wanted where a command is due, or (0,) for none, and these (2, n), filled.
    ``given`` to ``pairs`` as ``step_all`` has them; ``noted``: what :func:`note` fills; ``kept`` (m, 5, n):
    samples, filled.
    """
    now, end, every, between, first = plan
    counts, numbers, poses, inners, turns, looked, command = state
    if first == COMMAND and not is_mapped(counts, poses, turns, wanted, command):
        return now, ODD
    if first != NOTHING and now % between == 0:
        if not keep(poses[counts[STATE]], command, kept[counts[FILLED]]):
            return now, FAR
        counts[FILLED] += 1
    while now < end and counts[FILLED] < len(kept):
        here = counts[STATE]
        if not numbers[LEFT] > reach[0]:  # else nothing is looked at
            head(counts, poses, turns)
        before = poses[here], inners[here], turns[here]
        after = poses[1 - here], inners[1 - here], turns[1 - here]
        room = numbers[LEFT], numbers[FREE], looked
        hits, nearest, moved, left = step_all(
            before, (command, given), step, reach, after, room, *pairs
        )
        if hits == LIST_IS_STALE:
            return now, STALE if pairs[4] > 0 else BY_STEP
        if hits > 0:
            if moved > pairs[3][0] or nearest >= pairs[3][3]:
                return now, BY_STEP  # in which pairs that are not listed are looked at
            if not note(now + 1, step, hits, counts, noted, pairs[5], pairs[6]):
                return now, CROWDED
            numbers[CLOSEST] = min(numbers[CLOSEST], math.sqrt(nearest))
        counts[TOUCHES] = max(hits, 0)
        counts[STATE], counts[HEADED] = 1 - here, hits != APART
        numbers[LEFT] = left
        if hits != APART:
            numbers[LEFT] = numbers[FREE] = room_left(hits, nearest, moved, pairs[3])
            copy(after[0][0], looked[0])
            copy(after[0][1], looked[1])
        now += 1
        if now % every == 0:
            place(counts, poses, turns, wanted)
            return now, DUE
        if now % between == 0:
            if not keep(after[0], command, kept[counts[FILLED]]):
                return now, FAR
            counts[FILLED] += 1
    return now, ENOUGH


def is_mapped(counts, poses, turns, wanted, command):
    """Put what is ``wanted`` of the robots now into ``command``; return whether that can be."""
    if len(wanted[1]):
        head(counts, poses, turns)
    return map_wanted(wanted, turns[counts[STATE]], command)


def head(counts, poses, turns):
    """Fill in cosines and sines of the headings now, unless they are known."""
    if not counts[HEADED]:
        here = counts[STATE]
        cosines(poses[here, 2], turns[here, 0])
        sines(poses[here, 2], turns[here, 1])
        counts[HEADED] = 1


def place(counts, poses, turns, wanted):
    """Fill in the points, as ``Team.point`` does; none without arms."""
    here, arm, points = counts[STATE], wanted[4], wanted[5]
    if len(arm):
        head(counts, poses, turns)
    for axis in range(2):
        for row in range(len(arm)):
            points[axis, row] = poses[here, axis, row] + arm[row] * turns[here, axis, row]


def map_wanted(wanted, turned, command):
    """Put what is ``wanted`` as commands into ``command`` (2, n), within limits.

    As ``Team.command`` and ``Team.saturated`` do.  Return whether that can be: else nothing is changed.
    """
    u, arm, top, scope = wanted[:4]
    n, odd, worst = u.shape[1], 0, 1.0
    mapped, excess = u.copy(), np.empty(n)
    cos, sin = turned[0], turned[1]
    for row in range(len(arm)):
        mapped[0, row] = cos[row] * u[0, row] + sin[row] * u[1, row]
    for row in range(len(arm)):
        mapped[1, row] = (cos[row] * u[1, row] - sin[row] * u[0, row]) / arm[row]
    for row in range(n):
        factor = max(abs(mapped[0, row]) / top[0, row], abs(mapped[1, row]) / top[1, row])
        excess[row] = max(factor, 1.0)
    for row in range(n):  # nor is nan
        far = (not abs(mapped[0, row]) <= FASTEST) | (not abs(mapped[1, row]) <= FASTEST)
        odd |= far | (not excess[row] < np.inf)
    if odd:
        return False
    for row in range(n):
        worst = max(worst, excess[row])
    for axis in range(2):
        for row in range(n):
            factor = 1.0 if scope == 0 else worst if scope == 2 else excess[row]
            command[axis, row] = mapped[axis, row] / factor
    return True


def room_left(hits, nearest, moved, bounds):
    """Return how far [m] robots may move before two can touch, as ``Bodies`` does after a look at them."""
    if hits > 0 or moved > bounds[0]:
        return 0.0
    apart = math.sqrt(nearest) - math.sqrt(bounds[3])
    return min(0.5 * SKIN - math.sqrt(moved), 0.5 * apart) - ROUNDING


def note(now, step, hits, counts, noted, rows, found):
    """Note the touches of step ``now``, as ``Contacts`` does; return whether there is room for them.

    ``noted``: pairs and the steps of their last contacts, two buffers (2, 2, k); collisions begun: their
    steps and rows (3, k), and places (2, k) [m].  ``rows`` and ``found`` as ``push_all`` fills them.
    """
    buffers, begun, places = noted
    count, here = counts[PAIRS], counts[NOTED]
    if count + hits > buffers.shape[2] or counts[BEGUN] + hits > begun.shape[1]:
        return False
    known, to = buffers[here], buffers[1 - here]
    fresh, each = np.empty(hits, np.bool_), (rows[0, :hits], rows[1, :hits])
    given = known[0, :count], known[1, :count], now, step, FORGET
    counts[PAIRS] = note_all(each, MOST_ROBOTS, *given, fresh, to[0], to[1])
    counts[NOTED] = 1 - here
    for k in range(hits):
        if fresh[k]:
            at = counts[BEGUN]
            begun[0, at], begun[1, at], begun[2, at] = now, rows[0, k], rows[1, k]
            places[0, at], places[1, at] = found[0, k], found[1, k]
            counts[BEGUN] += 1
    return True


@functools.lru_cache(maxsize=None)
def compiled_steps():
    """Return the compiled ``steps_between``; ``ValueError`` without numba."""
    return kept_kernel(steps_between)


class CommandedSteps:
    """A ``World`` of unicycles that makes all steps from one command to the next in one call.

    Between :meth:`begin` and :meth:`end` the world is as it was when they began.
    """

    @staticmethod
    def fit(world, every):
        """Return whether robots of ``world`` can be moved so, which get a command ``every`` steps."""
        motion, n = world.motion, world.n
        alike = getattr(motion, "is_of_unicycles", False) and world.can_fuse(every) and n > 1
        return alike and bool((world.team.limits.of_all(n).top > 0.0).all())

    def __init__(self, world, step, l, by_points, saturation, rates):
        """``step``: the compiled :func:`steps_between`; ``l`` [m]: the hand length, None for no points;
        ``by_points``: whether velocities of these are given, not commands; ``saturation``: one of
        ``SCOPES``; ``rates``: after how many steps there is a command, and a sample."""
        n = world.n
        self._world, self._step, self._rates = world, step, rates
        self._step_size = world.step_size
        self._entry = None  # of ``step``, once its first arguments are there
        self._near = compiled_near()
        if not (is_chosen() or is_kept(self._near)):
            self._near = None  # which would take longer to compile than it saves
        self._counts, self._numbers = np.zeros(7, np.int64), np.empty(3)
        self._poses, self._looked = np.empty((2, 3, n)), np.empty((2, n))
        self._inners, self._turns = np.empty((2, 2, n)), np.empty((2, 2, n))
        self._command, self._wanted = np.empty((2, n)), np.empty((2, n))
        top = np.ascontiguousarray(world.team.limits.of_all(n).top.T)
        arms = np.empty(0) if l is None else np.full(n, float(l))
        self._columns = [each.T for each in self._poses]  # made once
        # ``state`` and ``wanted`` as ``steps_between`` has them
        self._state = (
            self._counts, self._numbers, self._poses, self._inners, self._turns, self._looked,
            self._command,
        )  # fmt: skip
        mapped = arms if by_points else np.empty(0)
        self._given = self._wanted, mapped, top, SCOPES.index(saturation), arms, np.empty((2, n))
        self._noted = np.empty((2, 2, n), np.int64), np.empty((3, n), np.int64), np.empty((2, n))
        self._commanded = None  # the step of the last command
        self.is_on = False  # whether the world waits for :meth:`end`

    @property
    def has_room(self):
        """Return whether more than a few steps can be made, where the world is its own."""
        motion = self._world.motion
        return motion.is_crowd or motion.room > FEW

    @property
    def time(self):
        """Return the time [s] of the step to which robots have come."""
        return self.now * self._step_size

    def begin(self, kept):
        """Begin at the world's state; ``kept`` (m, 5, n): to be filled with samples, pose and command."""
        world, motion = self._world, self._world.motion
        self.now, self._commanded, self._kept, self.is_on = world.steps, None, kept, True
        self._counts[:] = 0
        pose, inner, self._bodies = motion.lend()
        self._bodies.list_by(self._near)
        self._poses[0], self._inners[0], self._command[:] = pose.T, inner.T, world.command.T
        looked, free, left = self._bodies.looked
        self._numbers[:] = left, free, world.contacts.closest
        self._looked[:] = (pose[:, :2] if looked is None else looked).T
        pairs, steps = world.contacts.pairs
        self._make_room(max(len(pairs), self._noted[0].shape[2]))
        self._noted[0][0, 0, : len(pairs)], self._noted[0][0, 1, : len(pairs)] = pairs, steps
        self._counts[PAIRS] = len(pairs)
        self._moving = motion.crowd_given()
        self._pairs = self._bodies.looked_up(self._poses[0].T)

    def _make_room(self, size):
        """Let there be room for as many pairs that have touched, and collisions begun."""
        buffers, begun, places = self._noted
        more = np.empty((2, 2, size), np.int64), np.empty((3, size), np.int64), np.empty((2, size))
        count, fresh = self._counts[PAIRS], self._counts[BEGUN]
        more[0][:, :, :count] = buffers[:, :, :count]
        more[1][:, :fresh], more[2][:, :fresh] = begun[:, :fresh], places[:, :fresh]
        self._noted = more

    def advance(self, end, first, wanted=None):
        """Make steps up to ``end``, until something is due; return it, by the codes above.

        ``first``: what is done before, with ``COMMAND`` as ``wanted`` (n, 2): velocities of the points, or
        commands.
        """
        if first == COMMAND:
            wanted = wanted.T
            if not (wanted.dtype is FLOAT and wanted.flags.carray):  # as the compiled steps take it
                self._wanted[:] = wanted
                wanted = self._wanted
            self._given = (wanted, *self._given[1:])
        (every, between), (limits, size, reach), tried = self._rates, self._moving, -1
        while True:
            if len(self._given[4]):  # points are new each time: a law may keep them
                self._given = (*self._given[:-1], np.empty_like(self._wanted))
            now = self.now
            given = (
                (now, end, every, between, first), self._state, self._given, limits, size, reach,
                self._pairs, self._noted, self._kept,
            )  # fmt: skip
            if self._entry is None:
                self._entry = entry_of(self._step, given)
            self.now, why = self._entry(*given)
            if first == COMMAND and why != ODD:
                self._commanded = now
            if why == CROWDED:
                self._make_room(2 * self._noted[0].shape[2])
            elif why == STALE and self.now != tried:
                tried = self.now
                self._bodies.list_anew()
                self._pairs = self._bodies.looked_up(self._poses[self._counts[STATE]].T)
            else:
                return BY_STEP if why == STALE else why
            first = NOTHING

    def sensed(self):
        """Return the ``State`` that sensors read, as ``World.sensed`` does, where robots have come to."""
        here, hits = int(self._counts[STATE]), int(self._counts[TOUCHES])
        pose, twist = self._poses[here].T.copy("F"), np.zeros((3, self._world.n))
        twist[::2] = self._inners[here]
        travel = tuple(self._world.motion.wheel_travel)
        return State(self.time, pose, twist.T, travel, tuple(self._bodies.touches(hits)))

    @property
    def pose(self):
        """Return the poses (n, 3) to which robots have come, for now."""
        return self._columns[self._counts[STATE]]

    @property
    def points(self):
        """Return the points (n, 2) [m] of the robots, the caller's own, where a command is due."""
        return self._given[-1].T

    def end(self):
        """Let the world be where robots have come to; return how many samples there are."""
        world = self._world
        if self.now > world.steps:
            self._let_go()
        world.clock.steps, self.is_on = self.now, False
        world.commands.target[:] = self._command.T
        if self._commanded is not None:
            world.commands.note_received_by_all(self._commanded)
        return int(self._counts[FILLED])

    def _let_go(self):
        """Let the motion, and the contacts, go on from where robots have come to."""
        world, counts = self._world, self._counts
        here, hits, count = counts[[STATE, TOUCHES, PAIRS]].tolist()
        headings = tuple(self._turns[here].copy()) if counts[HEADED] else None
        left, free = self._numbers[:2].tolist()
        looked = self._looked.T.copy("F"), free, left
        state = self._poses[here].T.copy("F"), self._inners[here].T.copy("F")
        world.motion.go_on_from(*state, headings, looked, hits)
        pairs, steps = self._noted[0][counts[NOTED], :, :count].copy()
        world.contacts.go_on_from(pairs, steps, float(self._numbers[CLOSEST]), self._begun())

    def _begun(self):
        """Return the ``PairsBegun`` of these steps."""
        begun = self._counts[BEGUN]
        steps, *rows = self._noted[1][:, :begun].copy()
        return PairsBegun(steps * self._world.step_size, *rows, *self._noted[2][:, :begun].copy())
