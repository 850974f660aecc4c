"""The world: n robots, their commands and watchdogs, moved step by step.

>>> import numpy as np
>>> from mrs_simulator.scenario.team.robots import DEFAULT_KIND
>>> world = World((DEFAULT_KIND,), [[0.0, 0.0, 0.0]], limits=None)
>>> world.set_commands([0], np.array([[0.5, 0.0]]))
>>> for _ in range(25): world.step()
>>> bool(abs(world.pose[0, 0] - 0.25) < 1e-12)
True
"""

import numpy as np

from mrs_simulator.core.arrays import read_only
from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.core.snapshots import Snapshot
from mrs_simulator.scenario.surroundings.moving_obstacles import moves, obstacles_at
from mrs_simulator.sensors.state import State
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles.odometry_rates import odometry_notes
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.world import checks
from mrs_simulator.world.arms.grasp_state import GraspState, refuse_load
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.clock import Clock
from mrs_simulator.world.command_watchdogs import EVERY, Commands
from mrs_simulator.world.contact.contacts import Contacts
from mrs_simulator.world.contact.obstacle_tracks import ObstacleTracks
from mrs_simulator.world.contact.shores import Shore, has_shore, refuse_wheels_in_water
from mrs_simulator.world.flight.flights import Flights
from mrs_simulator.world.incidents.faults import Faults
from mrs_simulator.world.motion.motions import new_motion
from mrs_simulator.world.rendering.camera_renderer import CameraRenderer
from mrs_simulator.world.settings import WorldSettings, settings_of
from mrs_simulator.world.wheel_odometry.estimates import Estimates

__all__ = ["EVERY", "World", "WorldError"]

LONGEST_RISE = 120.0  # [s] of a take-off before the run


class World:
    """Robots in the plane.  All arrays hold one robot per row."""

    def __init__(self, kinds, poses, z=None, settings=None, **changes):
        """``kinds``: one name per robot, or a ``Team``; ``poses`` (n, 3); ``z`` (n,) [m]: heights at which
        robots begin, by default 0.

        ``settings``: the :class:`WorldSettings`, by default as these are declared, but for ``changes``,
        by their names.  Raises ``WorldError``.
        """
        settings = WorldSettings() if settings is None else settings
        self.settings = settings = settings._replace(**changes).checked()
        self.mirrored, self.fidelity = settings.mirrored, settings.fidelity
        self.obstacles = settings.obstacles
        self.clock = Clock(settings.step)
        self._takeoff = settings.takeoff
        self.motion = None
        self.set_team(kinds, poses, z)

    @classmethod
    def from_scenario(cls, scenario, **changes):
        """Return the world that ``scenario`` describes, with these ``changes`` of its settings."""
        try:
            team = _team_of(scenario)
            given = scenario.poses, scenario.altitude, settings_of(scenario, team)
            return cls(team, *given, **changes)
        except WorldError as error:
            if not scenario.path:
                raise
            raise WorldError("{}: {}".format(scenario.path, error)) from None

    def set_team(self, kinds, poses, z=None):
        """Replace all robots by new ones at rest; all or, with a ``WorldError``, none.

        ``z`` (n,) [m]: their heights, by default 0.
        """
        team, poses = checks.checked_team(kinds, poses, self.settings.limits)
        z = checks.checked_heights(team, z)
        checks.refuse_mirrored(self.mirrored, team.n)
        if self.fidelity != "point_mass":
            checks.refuse_overlaps(team, poses, obstacles_at(self.obstacles, self.time), z=z)
            refuse_wheels_in_water(team, poses, self.obstacles, self.mirrored)
        checks.refuse_events(team, self.settings.events, self.fidelity)
        checks.refuse_uneven_wheels(team, self.settings.odometry_errors)
        refuse_load(self.settings.load, team, poses, self.settings.hand_length)
        rises = self._takeoff and z is not None
        takeoff, z = (z, np.zeros(team.n)) if rises else (None, z)
        motion = new_motion(team, poses, z, self.settings)
        if self.motion is not None:
            self.motion.close()
        self._takeoff = self._takeoff and not rises
        self.motion, self.team, self._start, self._start_z = motion, motion.team, poses, z
        self._make_parts(takeoff)

    def _make_parts(self, takeoff):
        """Make what acts in a step; ``takeoff`` (n,) [m] as ``Flights`` has it."""
        team, motion, clock, given = self.team, self.motion, self.clock, self.settings
        self.commands = Commands(team, motion, clock, given)
        self.faults = faults = Faults(motion, clock, given.events)
        self.flights = Flights(team, motion, clock, given, self.commands, faults, takeoff)
        self.estimates = Estimates(team, motion, clock, given, self._start)
        self.contacts = Contacts(motion, clock)
        tracks = shore = self.grasps = None
        if any(map(moves, self.obstacles)):
            tracks = ObstacleTracks(motion, clock, self.obstacles)
        if self.fidelity != "point_mass" and has_shore(team, self.obstacles):
            shore = Shore(team, motion, faults, given)
        if team.has_arms:
            self.grasps = GraspState(team, motion, faults, given.hand_length, given.load)
        parts = (self.commands, faults, tracks, self.flights, shore, self.grasps, self.estimates)
        self.parts = [part for part in (*parts, self.contacts) if part is not None]
        self._list_hooks()
        clock.begun = clock.steps

    def _list_hooks(self):
        self._before = [part.before_step for part in self.parts if part.before_step]
        self._after = [part.after_step for part in self.parts if part.after_step]

    def reset(self):
        """Put the robots back to their initial poses, at rest; time goes on.

        From here on the world is a new one to the bit: a solver keeps contacts and the motors' impulses of
        its last step, so motion and what goes with it are made anew.  Mirrored robots stay where they are;
        ``WorldError`` if one of those is in another's place.
        """
        poses, z = self._start.copy(), self._start_z
        poses[self.mirrored] = self.pose[self.mirrored]
        if z is not None:
            z = z.copy()
            z[self.mirrored] = self.motion.z[self.mirrored]
        if len(self.mirrored) and self.fidelity != "point_mass":
            checks.refuse_overlaps(self.team, poses, (), self.mirrored, z)
        motion = new_motion(self.team, poses, z, self.settings)
        self.motion.close()
        self.motion, refused = motion, self.commands.refused
        self._make_parts(self.flights.takeoff)
        self.commands.refused = refused  # of all time

    @property
    def n(self):
        """Return the number of robots."""
        return self.team.n

    @property
    def time(self):
        """Return the simulated time [s]: whole steps, without drift."""
        return self.clock.time

    @property
    def steps(self):
        """Return how many steps were made."""
        return self.clock.steps

    @property
    def step_size(self):
        """Return the length [s] of a step."""
        return self.clock.step_size

    @property
    def pose(self):
        """Return the true poses in the common frame, (n, 3) [m, m, rad], read-only."""
        return read_only(self.motion.pose)

    @property
    def twist(self):
        """Return the true body twists, (n, 3): vx, vy [m/s], omega [rad/s], read-only."""
        return read_only(self.motion.twist)

    @property
    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad], read-only.

        Of robots with arms (n, 1 + k): the arms' joints come after the drives'.
        """
        return read_only(self.motion.joints())

    @property
    def spatial(self):
        """Return what pose and twist leave out, a ``Spatial``; None for a team on the ground."""
        return self.motion.spatial

    @property
    def z(self):
        """Return the heights (n,) [m] above the ground, None for a team on the ground; read-only."""
        return None if self.motion.z is None else read_only(self.motion.z)

    @property
    def command(self):
        """Return the commands in force, (n, a), a column for each of ``team.axes``, read-only."""
        return read_only(self.commands.target)

    @property
    def notes(self):
        """Return notes for users, texts: rates of odometry, robots that fly and begin on the ground."""
        notes = odometry_notes(self.team, self.settings.odometry_rate, self.step_size)
        return notes + self.flights.notes(self.z)

    @property
    def senses(self):
        """Return team, obstacles and the cameras' renderer, of which a ``sensors.suite.Suite`` is made."""
        return self.team, self.obstacles, CameraRenderer(self.team, self.obstacles)

    def state(self):
        """Return the ``StateTable`` of now; its arrays are the world's own."""
        team, numbers, columns = self.team, np.arange(1, self.n + 1), {}
        for part in self.parts:
            columns.update(part.columns())
        return StateTable(
            self.time,
            numbers.tolist(),
            [kind.name for kind in team.kinds],
            team.axes,
            pose=self.pose,
            twist=self.twist,
            real=np.isin(numbers - 1, self.mirrored),
            joints=self.joints if team.has_joints else None,
            spatial=self.spatial,
            **columns,
        )

    def sensed(self):
        """Return the ``sensors.state.State`` now, which sensors read."""
        motion = self.motion
        travel, contacts = tuple(motion.wheel_travel), tuple(motion.contacts())
        pose, twist = self.pose, self.twist
        return State(self.time, pose, twist, travel, contacts, spatial=motion.spatial)

    @property
    def load(self):
        """Return the carried load, such as a ``CarriedLoad``; None where there is none."""
        return self.grasps.load if self.grasps else None

    # Changes -------------------------------------------------------------------------------------

    def set_commands(self, rows, commands):
        """Give robots ``rows`` (m,), or ``EVERY`` robot, the commands (m, a), as ``team.axes``.

        One that is not finite, or beyond ``command_watchdogs.LARGEST_COMMAND``, is refused, and counted in
        ``refused``; that robot keeps its last command until its own watchdog stops it.  Return whether
        none was.
        """
        return self.commands.set(rows, commands)

    def place(self, rows, poses, twists=None, z=None):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) in the common frame.

        ``twists`` (m, 3): their body twists, none for at rest; ``z`` (m,) [m]: their heights, none for as
        they are.  Raises ``WorldError``.
        """
        rows, poses = np.asarray(rows, dtype=int), np.array(poses, dtype=float)
        others = np.setdiff1d(rows, self.mirrored)
        if len(others):
            raise WorldError("robot{} is simulated: wanted a mirrored one".format(others[0] + 1))
        twists = np.zeros_like(poses) if twists is None else np.asarray(twists, dtype=float)
        checks.refuse_places(rows, poses, twists)
        poses[:, 2] = wrap_angle(poses[:, 2])
        self.motion.place(rows, poses, twists, *(() if z is None else (z,)))

    def step(self):
        """Advance by one step: watchdogs, motion, odometry, collisions."""
        command = None
        for act in self._before:
            command = act(command)
        self.motion.advance(command)
        self.clock.steps += 1
        for act in self._after:
            act()

    def rise(self):
        """Let robots that begin on the ground take off before the run, whose time begins when all are up.

        Raises ``WorldError`` where one is not up after ``LONGEST_RISE``.
        """
        while self.flights.rising:
            self.step()
            if self.time > LONGEST_RISE:
                stuck = self.flights.next_rising()
                text = "takeoff: robot{} is {:.2f} m high after {:g} s, wanted {:g} m"
                raise WorldError(
                    text.format(stuck + 1, self.z[stuck], LONGEST_RISE, self.flights.takeoff[stuck])
                )
        self.clock.rewind()
        for part in self.parts:
            part.reset()

    def can_fuse(self, every):
        """Return whether :meth:`fuse_steps` can move these robots, which get a command ``every`` steps."""
        parts = self.motion, *self.parts
        fusing = all(getattr(part, "can_fuse", False) for part in parts)
        return fusing and every * self.step_size <= self.commands.shortest_timeout

    def fuse_steps(self, plan, function, kept, *given):
        """Advance by several steps in one compiled call, see ``fused_stepping.FusedStepping.advance``.

        ``plan``: ``(steps, every, ahead, between)`` of it.
        """
        steps, every, *sampling = plan
        until = every - self.clock.steps % every
        whole, target = (steps, until, every, *sampling), self.commands.target
        done, filled, why = self.motion.fuse_steps(whole, target, function, kept, *given)
        self.clock.steps += done
        if done >= until:
            self.commands.note_received_by_all(self.clock.steps - (done - until) % every)
        return done, filled, why

    @property
    def stateful(self):
        """Return what a ``Snapshot`` of this world keeps the state of."""
        return [self, self.clock, self.motion, *self.parts]

    def snapshot(self):
        """Return what :meth:`restore` needs to go on from now to the same bits; ``NotCopied`` says of what
        there is no copy."""
        return Snapshot(self.stateful)

    def restore(self, kept):
        """Go back to where :meth:`snapshot` returned ``kept``."""
        self.close()  # a solver that was opened since
        kept.restore()

    def close(self):
        """Release the motion's resources, such as a solver."""
        self.motion.close()


def _team_of(scenario):
    try:
        return team_of(scenario)
    except ValueError as error:
        raise WorldError(str(error)) from None
