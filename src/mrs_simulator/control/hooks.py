"""What a researcher's law overrides: ``LawHooks``, of which ``PioneerControl`` is made."""

import numpy as np

from mrs_simulator.control.twists import twists_of
from mrs_simulator.core.kinematics import HAND_LENGTH


class LawHooks:
    """What a law is made of; a researcher writes a subclass of ``PioneerControl``.

    Override ONE of

    - ``calculateControlLaw(pos_map)``: positions by robot number in, ``Twist`` by number out;
    - ``pointMassLaw(hand)``: hand points (n, d) in, their wanted velocities (n, d) out; the mapping
      (7) turns them into the unicycles' ``(v, omega)``.  d is 2, also for robots that fly, at the
      height at which they begin; it is 3 for a team that flies where ``DIMENSIONS``, which says for
      which d the law is written, and the scenario's ``control.dimension`` have it so;
    - ``neighbourLaw(robot, theta, neighbours)``: the same for one robot at a time, from the relative
      positions of its neighbours alone.

    ``PARAMETERS`` describes the law's own parameters; each is an attribute of that name (``self.k``).
    ``self.numbers`` are the robots' numbers, ``self.topology`` the interaction graph, ``self.time``
    [s] the time since the control began and ``self.period`` [s] that between two commands.  These and
    other names of its own are to be read; assigning them is an error that says so.

    ``SENSORS`` names the sensors that the law asks of every robot; ``self.readings[number]`` then has
    the newest of each as an attribute, such as ``.sonar``, None until one has come.  ``self.obstacles``
    are the scene's, in the common frame.
    """

    PARAMETERS = (HAND_LENGTH,)
    # of the points that the law is written for: (2, 3) for laws of points anywhere
    DIMENSIONS = (2,)
    SENSORS = ()  # names of the sensors that every robot must have
    LOCAL_FRAMES = False
    MEMORYLESS = False  # the law knows positions alone: its claims hold from any moment of a run on
    KEEPS_CONNECTED = False  # theory says that the graph of ``graph_at`` never falls apart
    TAKES_EDGES = True  # the law looks up ``self.topology`` at each command: edges may come and go
    JUMPS = False  # commands jump from one to the next, by events or by chance, not only at a start
    IN_CURRENT = False  # the claims hold where a current carries robots, by ``self.carried``
    obstacles = ()  # ``scenario.surroundings.obstacles``

    def calculateControlLaw(self, pos_map):
        """Return each robot's ``Twist``: by robot number, or a sequence in the order of ``numbers``.

        ``pos_map`` maps each robot's number to its :class:`Position`.  This default maps
        :meth:`pointMassLaw` to unicycles by (7).
        """
        pose = np.array([pos_map[number] for number in self.numbers])
        if self.dimension == 3:
            pose = np.column_stack([pose, [pos_map[number].z for number in self.numbers]])
        return dict(zip(self.numbers, twists_of(self.runner.array_law(pose), self.team.axes)))

    def pointMassLaw(self, hand):
        """Return the points' wanted velocities, shape (n, d) [m/s], from ``hand`` (n, d) [m]."""
        text = "{} has no law: wanted calculateControlLaw, pointMassLaw or neighbourLaw"
        raise NotImplementedError(text.format(type(self).__name__))

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the wanted velocity ``(ux, uy)`` [m/s] of one hand point from what its robot sees.

        ``robot``: its number; ``theta`` [rad] its heading; ``neighbours``: a tuple of
        :class:`Neighbour`.  Of points in space these have a height ``z`` of
        theirs, and ``(ux, uy, uz)`` is wanted.  A law written so is distributed by construction.  With
        ``LOCAL_FRAMES = True`` there is no common compass: relative positions come, and the velocity
        goes, in the robot's own frame, and ``theta`` is 0.
        """
        raise NotImplementedError

    def start(self):
        """Begin anew: what a law remembers of the past belongs here."""

    def claims(self, start):
        """Return what theory says of a run from hand points ``start`` (n, d): a list of
        ``core.claims.Claim`` and ``Condition``."""
        return []

    def claims_over_links(self, start):
        """Return what theory says, as :meth:`claims` does, where ``self.links`` have faults; None where it
        says nothing: then those of :meth:`claims` are measured, without a theorem."""
        return None

    def prediction(self, start, time):
        """Return the hand points that theory predicts at ``time`` (m,) [s], (m, n, d), or None."""
        return None

    def prediction_over_links(self, start, time):
        """Return the prediction, as :meth:`prediction` does, where ``self.links`` have faults."""
        return None

    def stability(self, start):
        """Return the ``core.stability.Stability`` of a run from ``start`` (n, d): how far its threshold is,
        or None where no theorem names one."""
        return None

    def published(self):
        """Return the law as ``protocols.published.laws.Published``, written independently, or None.

        With it a verdict compares each recorded command, and the motion, with the law's equation.
        """
        return None

    def resumed(self, time, memory):
        """Return the control that a run's rest from ``time`` [s] after its start on is judged by, or None.

        ``memory``: that of the published law then.  A law that knows positions alone is the same at any
        time; another one says here what its claims say of the rest: its copy, or None for nothing.
        """
        return self if self.MEMORYLESS else None

    def energy(self, start):
        """Return the ``protocols.curves.Energy`` that decreases from ``start`` (n, d), or None."""
        return None

    def graph_at(self, start, hand):
        """Return the graph that the places ``hand`` (n, d) make in a run from ``start``, or None where it
        does not depend on them.  With ``KEEPS_CONNECTED`` theory says that it never falls apart."""
        return None

    def curves(self, run):
        """Return a list of ``protocols.curves.Curve`` to draw of ``run`` beside theory."""
        return []

    def targets(self, hand):
        """Return where the hand points ``hand`` (n, d) are wanted now, (n, d) [m], or None."""
        return None

    def warnings(self, pose):
        """Return warnings, a list of texts, about running from ``pose`` (n, 3), with heights (n, 4)."""
        return []

    def measures(self, run):
        """Return further values of ``run`` for its verdict, plain values by name."""
        return {}
