"""Take-offs, landings and motors of the robots of a world that fly."""

import numpy as np

from mrs_simulator.core.spatial import rotated
from mrs_simulator.scenario.incidents import OFF
from mrs_simulator.scenario.scenario import FARTHEST
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.flight.manoeuvres import HOVER_HEIGHT, Manoeuvres
from mrs_simulator.world.part import Part

ON_GROUND = (
    "{}: on the ground until a command climbs; to begin in the air give altitude, such as 1.0, "
    "and takeoff: true to rise to it before the run"
)
DOWNWARDS = ("falling", "upside down")


class Flights(Part):
    """Take-offs, landings and motors of the robots that fly."""

    def __init__(self, team, motion, clock, settings, commands, faults, takeoff):
        """``settings``: the ``WorldSettings``; ``takeoff`` (n,) [m]: heights to which robots rise before
        the run, None where they do not."""
        self._team, self._motion, self._clock = team, motion, clock
        self._commands, self._faults = commands, faults
        self._mirrored, self.takeoff = set(settings.mirrored.tolist()), takeoff
        self._have_motors = settings.fidelity != "point_mass"
        self._aloft = np.flatnonzero(team.airborne).tolist()
        if not self._aloft:
            self.before_step = None
        self._manoeuvres = Manoeuvres(team)
        clock.waits = takeoff is not None
        if clock.waits:
            rows = np.flatnonzero(takeoff > 0.0)
            self._manoeuvres.take_off(rows, takeoff[rows])

    @property
    def can_fuse(self):
        """Return whether all robots obey their commands."""
        return not self._manoeuvres.busy

    @property
    def rising(self):
        """Return whether robots still take off before the run, while all others wait."""
        return self._clock.waits

    def before_step(self, command):
        """Return what robots obey instead of ``command`` (n, a)."""
        if not self._manoeuvres.busy:
            return command
        z, climb = self._motion.z, self._climbing()
        obeyed = self._manoeuvres.applied(command, z, climb, self.rising)
        if self.rising and not self._manoeuvres.rising.any():
            self._clock.waits, self._clock.begun = False, self._clock.steps
        return obeyed

    def _climbing(self):
        """Return how fast robots rise, (n,) [m/s]."""
        spatial, twist = self._motion.spatial, self._motion.twist
        body = np.column_stack([twist[:, :2], spatial.twist[:, 0]])
        return rotated(spatial.orientation, body)[:, 2]

    def notes(self, z):
        """Return a note on robots that fly and begin on the ground, a list; ``z`` (n,) [m] or None."""
        low = self._aloft if z is None else [row for row in self._aloft if z[row] <= 0.0]
        low = [row for row in low if row not in self._mirrored]
        if not low or self.takeoff is not None:
            return []
        names = ", ".join("robot{}".format(row + 1) for row in low)
        return [ON_GROUND.format(names)]

    def next_rising(self):
        """Return the row of the first robot that is still rising."""
        return int(np.flatnonzero(self._manoeuvres.rising)[0])

    def states(self):
        """Return what each robot that flies does, ``{row: text}``: landed, taking off, hovering, flying,
        landing, falling, motors off, upside down."""
        if not self._aloft:
            return {}
        command = self._commands.target
        powered = getattr(self._motion, "powered", np.ones(self._team.n, dtype=bool))
        x, y = self._motion.spatial.orientation.T[:2]
        over = x * x + y * y > 0.5  # the body's axis points down
        z = self._motion.z
        return {
            row: self._manoeuvres.state(
                row, float(z[row]), bool(powered[row]), bool(over[row]), command[row]
            )
            for row in self._aloft
        }

    def take_off(self, rows, height=HOVER_HEIGHT):
        """Let flying robots ``rows`` rise to ``height`` [m] and hover, whatever their commands.

        Motors that were cut turn again.  ``WorldError`` names a robot that cannot.
        """
        rows = self._flyers(rows, "take off")
        if not 0.0 < height <= FARTHEST:
            raise WorldError("height {} m: wanted above 0, to {:g} m".format(height, FARTHEST))
        states = self.states()
        for row in rows.tolist():
            lost = self._faults.lost_rotor(row)
            if lost or states[row] in DOWNWARDS:
                state = "has lost a rotor" if lost else "is {}".format(states[row])
                raise WorldError("robot{} {}: wanted one that can take off".format(row + 1, state))
        for row in rows.tolist():
            if states[row] == "motors off":
                self._motion.power(row)
        self._manoeuvres.take_off(rows, height)
        self._commands.forget(rows)  # they hover until they are commanded anew

    def land(self, rows):
        """Land flying robots ``rows`` where they are; they stay down until they take off.

        A second call changes nothing.  ``WorldError`` names a robot that does not fly.
        """
        self._manoeuvres.land(self._flyers(rows, "land"))

    def power(self, rows):
        """Switch the motors of ``rows``, which stand upright on the ground, on again."""
        states = self.states()
        for row in self._flyers(rows, "power").tolist():
            if states[row] == "motors off" and not self._faults.lost_rotor(row):
                self._motion.power(row)

    def cut_motors(self, rows, falls=False):
        """Cut the motors of flying robots ``rows``; in the air only with ``falls``.

        ``WorldError`` names a robot that would fall, or has no motors; then nothing is cut.
        """
        rows = self._flyers(rows, "cut")
        if not self._have_motors:
            raise WorldError(
                "fidelity point_mass: robots have no motors; wanted kinematic or dynamic"
            )
        for row in rows.tolist():
            z = self._motion.z[row]
            if z > 0.0 and not falls:
                raise WorldError(
                    "robot{} is {:.2f} m high and would fall; wanted it landed, or its fall "
                    "confirmed".format(row + 1, z)
                )
        self._manoeuvres.release(rows)
        for row in rows.tolist():
            self._faults.inject(row, OFF)

    def _flyers(self, rows, what):
        every = np.arange(self._team.n)
        rows = every[rows] if isinstance(rows, slice) else np.atleast_1d(rows)
        for row in rows.tolist():
            able = self._team.airborne[row] and hasattr(self._team.kinds[row].module, "climbing")
            real = row in self._mirrored
            if not able or real:
                which = "real one" if real else self._team.kinds[row].title
                text = "{}: robot{} is a {}; wanted a simulated robot that flies"
                raise WorldError(text.format(what, row + 1, which))
        return rows
