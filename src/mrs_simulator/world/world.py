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

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.scenario.scenario import DEFAULT_HAND_LENGTH, ENGINES
from mrs_simulator.scenario.surroundings.environment import CALM
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.moving_obstacles import moves, obstacles_at
from mrs_simulator.scenario.team.mismatch import NO_MISMATCH
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.state import State
from mrs_simulator.vehicles.odometry_rates import odometry_notes
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.world import checks
from mrs_simulator.world.arms.grasp_state import GraspState, refuse_load
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.clock import Clock
from mrs_simulator.world.commands import EVERY, Commands
from mrs_simulator.world.contact.contacts import Contacts
from mrs_simulator.world.contact.shores import Shore, refuse_wheels_in_water
from mrs_simulator.world.flight.flights import Flights
from mrs_simulator.world.flight.manoeuvres import HOVER_HEIGHT
from mrs_simulator.world.incidents.faults import Faults
from mrs_simulator.world.motion.motions import Surroundings, new_motion
from mrs_simulator.world.rendering.camera_renderer import CameraRenderer
from mrs_simulator.world.wheel_odometry.estimates import Estimates, wheel_odometry

__all__ = ["EVERY", "World", "WorldError"]

PASSIVE = (  # attributes that describe how a world was made, and do nothing in a step
    *("team", "mirrored", "fidelity", "obstacles", "_clock", "_around", "_watching", "_odometry"),
    *("_events", "_takeoff", "_given_load", "_start", "_start_z"),
)
LONGEST_RISE = 120.0  # [s] of a take-off before the run


class World:
    """Robots in the plane.  All arrays hold one robot per row."""

    def __init__(
        self,
        kinds,
        poses,
        obstacles=(),
        fidelity="kinematic",
        limits="firmware",
        step=0.02,
        cmd_vel_timeout=None,
        hand_length=DEFAULT_HAND_LENGTH,
        odometry_kind="world",
        seed=0,
        watch_period=0.0,
        mirrored=(),
        mismatch=NO_MISMATCH,
        command_period=0.0,
        environment=CALM,
        odometry_rate=None,
        z=None,
        counts_wheels=False,
        odometry_errors=None,
        events=(),
        takeoff=False,
        load=None,
        engine=ENGINES[0],
    ):
        """``kinds``: one name per robot; ``poses`` (n, 3); ``obstacles``: ``Box``, ``Cylinder``.

        ``z`` (n,) [m]: heights at which robots begin, by default 0.

        ``limits`` as in ``vehicles.limits.kind_limits``; ``step`` [s]; ``cmd_vel_timeout`` [s] of
        simulated time, by default that of each robot's kind, looked at every ``watch_period`` [s], 0:
        at each step.  ``mirrored``: rows of robots that obey no command and are only where ``place``
        puts them: bodies to the others, never pushed.  ``mismatch``: how they obey
        commands; ``command_period`` [s] for which one is held, by default ``step``; ``environment``:
        current, wind and waves; ``odometry_rate`` [Hz] at which ``estimate`` follows the odometry,
        "kinds" for that of each robot's kind, None for each step; ``counts_wheels``: whether encoders
        are read beside the odometry; ``odometry_errors``: ``OdometryErrors``, instead of those
        built in; ``events``: ``scenario.incidents.Event``s by their times; ``takeoff``: whether
        robots begin on the ground and rise to ``z`` before the run; ``load``: a ``scenario.team.load.Load``
        that the robots' tools carry; ``engine``: what moves robots on wheels in fidelity
        dynamic.  Raises ``WorldError``.
        """
        self.mirrored = np.array(sorted(set(mirrored)), dtype=int)
        self.fidelity = fidelity
        self.obstacles = tuple(obstacles)  # as they begin: ``moving_obstacles.obstacles_at``
        self._obstacles_move = any(map(moves, self.obstacles))
        self._clock = Clock(step)
        self._around = Surroundings(
            fidelity,
            self.obstacles,
            limits,
            step,
            self.mirrored,
            environment,
            counts_wheels or odometry_kind == "wheel",
            seed,
            hand_length,
            command_period,
            engine,
            odometry_errors,
        )
        self._watching = cmd_vel_timeout, max(1, int(round(watch_period / step))), mismatch
        self._odometry = odometry_kind == "wheel", odometry_rate, odometry_errors
        self._events, self._takeoff, self._given_load = tuple(events), takeoff, load
        self._motion = None
        self.set_team(kinds, poses, z)

    @classmethod
    def from_scenario(cls, scenario, **options):
        """Return the world that ``scenario`` describes; ``options``: others than a scenario has."""
        try:
            team = _team_of(scenario)
            mounts = fitted_mounts(team, scenario.sensors)
            return cls(
                team,
                scenario.poses,
                obstacles=obstacles_of(scenario),
                fidelity=scenario.fidelity,
                limits=scenario.limits,
                step=scenario.step,
                cmd_vel_timeout=scenario.cmd_vel_timeout,
                hand_length=scenario.hand_length,
                odometry_kind=scenario.odometry,
                seed=scenario.seed,
                mismatch=scenario.mismatch,
                command_period=1.0 / scenario.control.rate,
                environment=scenario.environment,
                odometry_rate=scenario.odometry_rate,
                z=scenario.altitude,
                odometry_errors=scenario.odometry_errors,
                events=scenario.events,
                takeoff=scenario.takeoff,
                load=scenario.load,
                engine=scenario.engine,
                counts_wheels=checks.count_wheels(mounts, scenario.fidelity),
                **options,
            )
        except WorldError as error:
            if not scenario.path:
                raise
            raise WorldError("{}: {}".format(scenario.path, error)) from None

    def set_team(self, kinds, poses, z=None):
        """Replace all robots by new ones at rest; all or, with a ``WorldError``, none.

        ``z`` (n,) [m]: their heights, by default 0.
        """
        team, poses = checks.checked_team(kinds, poses, self._around.limits)
        z = checks.checked_heights(team, z)
        checks.refuse_mirrored(self.mirrored, team.n)
        if self.fidelity != "point_mass":
            checks.refuse_overlaps(team, poses, obstacles_at(self.obstacles, self.time), z=z)
            refuse_wheels_in_water(team, poses, self.obstacles, self.mirrored)
        checks.refuse_events(team, self._events, self.fidelity)
        checks.refuse_uneven_wheels(team, self._around.errors)
        refuse_load(self._given_load, team, poses, self._around.hand_length)
        rises = self._takeoff and z is not None
        takeoff, z = (z, np.zeros(team.n)) if rises else (None, z)
        motion = new_motion(team, poses, z, self._around)
        if self._motion is not None:
            self._motion.close()
        self._takeoff = self._takeoff and not rises
        self._motion, self.team, self._start, self._start_z = motion, motion.team, poses, z
        self._make_parts(takeoff)

    def _make_parts(self, takeoff):
        """Make what goes with a team and its motion; ``takeoff`` (n,) [m] as ``Flights`` has it."""
        team, motion, clock, around = self.team, self._motion, self._clock, self._around
        by_wheels, rate, errors = self._odometry
        wheels = None
        if by_wheels or errors is not None:
            wheels = wheel_odometry(team, self.fidelity, around.seed, errors, clock.step_size)
        self._commands = Commands(team, clock, *self._watching)
        self._contacts = Contacts(motion, clock)
        self._estimates = Estimates(
            team, motion, clock, self._start, self.mirrored, wheels, by_wheels, rate
        )
        self._estimates.begin()
        self._faults = Faults(motion, clock, self._events)
        self._flights = Flights(team, motion, clock, self._faults, self.mirrored, takeoff)
        self._shore = None
        if self.fidelity != "point_mass":
            self._shore = Shore.of(team, motion, self._faults, self.obstacles, self.mirrored)
        self._grasps = None
        if team.has_arms:
            self._grasps = GraspState(
                team, motion, self._faults, around.hand_length, self._given_load
            )
        clock.begun = clock.steps

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
            z[self.mirrored] = self._motion.z[self.mirrored]
        if len(self.mirrored) and self.fidelity != "point_mass":
            checks.refuse_overlaps(self.team, poses, (), self.mirrored, z)
        motion = new_motion(self.team, poses, z, self._around)
        self._motion.close()
        self._motion, refused = motion, self._commands.refused
        self._make_parts(self._flights.takeoff)
        self._commands.refused = refused  # of all time

    # State ---------------------------------------------------------------------------------------

    @property
    def n(self):
        """Return the number of robots."""
        return self.team.n

    @property
    def kinds(self):
        """Return the robots' kinds."""
        return self.team.kinds

    @property
    def time(self):
        """Return the simulated time [s]: whole steps, without drift."""
        return self._clock.time

    @property
    def steps(self):
        """Return how many steps were made."""
        return self._clock.steps

    @property
    def step_size(self):
        """Return the length [s] of a step."""
        return self._clock.step_size

    @property
    def limits(self):
        """Return the ``AxisLimits`` in force."""
        return self.team.limits

    @property
    def pose(self):
        """Return the true poses in the common frame, (n, 3) [m, m, rad], read-only."""
        return _read_only(self._motion.pose)

    @property
    def twist(self):
        """Return the true body twists, (n, 3): vx, vy [m/s], omega [rad/s], read-only."""
        return _read_only(self._motion.twist)

    @property
    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad], read-only.

        Of robots with arms (n, 1 + k): the arms' joints come after the drives'.
        """
        return _read_only(self._motion.joints())

    @property
    def spatial(self):
        """Return what pose and twist leave out, a ``Spatial``; None for a team on the ground."""
        return self._motion.spatial

    @property
    def z(self):
        """Return the heights (n,) [m] above the ground, None for a team on the ground; read-only."""
        return None if self._motion.z is None else _read_only(self._motion.z)

    @property
    def command(self):
        """Return the commands in force, (n, a), a column for each of ``team.axes``, read-only."""
        return _read_only(self._commands.target)

    @property
    def commanded(self):
        """Return which robots, (n,) bool, obey a command that has not timed out."""
        return self._commands.commanded

    @property
    def refused(self):
        """Return how many commands of each robot were refused, (n,)."""
        return self._commands.refused

    @property
    def timeouts(self):
        """Return the robots' timeouts of commands, (n,) [s] of simulated time."""
        return self._commands.timeouts

    @property
    def timed_out(self):
        """Return the robots, (n,) bool, whose last command has timed out.

        Mirrored ones are never among them: they have watchdogs of their own.
        """
        late = self._commands.silent
        late[self.mirrored] = False
        return late

    def odometry(self):
        """Return the poses by odometry, (n, 3), each in its robot's odometry frame."""
        return _read_only(self._estimates.odometry())

    def odometry_spatial(self):
        """Return the ``Spatial`` that goes with ``odometry``, None for a team on the ground.

        Heights are above the ground, whatever the odometry.
        """
        return self._estimates.spatial()

    def odometry_origins(self):
        """Return the poses of the odometry frames in the common frame, (n, 3)."""
        return _read_only(self._estimates.origins())

    def estimate(self):
        """Return the newest poses by odometry in the common frame, (n, 3), read-only."""
        return _read_only(self._estimates.pose())

    def estimate_z(self):
        """Return the heights (n,) [m] that go with ``estimate``, None for a team on the ground."""
        z = self._estimates.z()
        return None if z is None else _read_only(z)

    @property
    def notes(self):
        """Return notes for users on the rates of this world's odometry, a list of texts."""
        return odometry_notes(self.team, self._odometry[1], self.step_size)

    @property
    def senses(self):
        """Return team, obstacles and the cameras' renderer, of which a ``sensors.suite.Suite`` is made."""
        return self.team, self.obstacles, CameraRenderer(self.team, self.obstacles)

    def sensed(self):
        """Return the ``sensors.state.State`` now, which sensors read."""
        motion = self._motion
        travel, contacts = tuple(motion.wheel_travel), tuple(motion.contacts())
        pose, twist = self.pose, self.twist
        return State(self.time, pose, twist, motion.z, motion.spatial, travel, contacts)

    def closest_distance(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._motion.closest()

    @property
    def closest_approach(self):
        """Return the least distance [m] between two centres that was measured so far."""
        return self._contacts.closest

    @property
    def load(self):
        """Return the carried load, such as a ``CarriedLoad``; None where there is none."""
        return self._grasps.load if self._grasps else None

    @property
    def rising(self):
        """Return whether robots still take off before the run, while all others wait."""
        return self._flights.rising

    def flight_states(self):
        """Return what each robot that flies does, ``{row: text}``: landed, taking off, hovering, flying,
        landing, falling, motors off, upside down."""
        return self._flights.states(self._commands.target)

    # Changes -------------------------------------------------------------------------------------

    def take_off(self, rows, height=HOVER_HEIGHT):
        """Let flying robots ``rows`` rise to ``height`` [m] and hover, whatever their commands.

        Motors that were cut turn again.  ``WorldError`` names a robot that cannot.
        """
        rows = self._flights.take_off(rows, height, self._commands.target)
        self._commands.forget(rows)  # they hover until they are commanded anew

    def power(self, rows):
        """Switch the motors of robots ``rows``, which stand upright on the ground, on again."""
        self._flights.power(rows, self._commands.target)

    def land(self, rows):
        """Land flying robots ``rows`` where they are; they stay down until they take off.

        A second call changes nothing.  ``WorldError`` names a robot that does not fly.
        """
        self._flights.land(rows)

    def cut_motors(self, rows, falls=False):
        """Cut the motors of flying robots ``rows``; in the air only with ``falls``.

        ``WorldError`` names a robot that would fall, or has no motors; then nothing is cut.
        """
        self._flights.cut_motors(rows, falls, have_motors=self.fidelity != "point_mass")

    def set_commands(self, rows, commands):
        """Give robots ``rows`` (m,), or ``EVERY`` robot, the commands (m, a), as ``team.axes``.

        One that is not finite, or beyond ``commands.FASTEST``, is refused and counted in ``refused``;
        that robot keeps its last command until its own watchdog stops it.
        """
        self._commands.set(rows, commands)

    def set_efforts(self, rows, efforts):
        """Command the thrusters of vessels ``rows`` (m,) directly, past the vessels' controllers.

        ``efforts`` (m, 4): commands of the left and the right thruster, force ahead [N] and torque [N m];
        nan where the controllers act, by the command in force.  ``set_commands`` ends it, and so does the
        watchdog, with thrusters at rest.  Raises ``WorldError`` for other robots and without forces.
        """
        rows, efforts = np.asarray(rows, dtype=int), np.asarray(efforts, dtype=float)
        for row in rows.tolist():
            if self.fidelity != "dynamic" or self.kinds[row].module.MEDIUM != "water":
                raise WorldError(
                    "thrusters of robot{}, a {}, in fidelity {}: wanted a vessel in fidelity "
                    "dynamic".format(row + 1, self.kinds[row].title, self.fidelity)
                )
        if self._commands.efforts is None:
            self._commands.efforts = self._motion.efforts = np.full((self.n, 4), np.nan)
        self._commands.set_efforts(rows, efforts)

    def set_arm_rates(self, row, rates):
        """Let the arm of robot ``row`` turn at ``rates`` (k,) [rad/s], whatever its base does."""
        self._commands.set_arm_rates(row, np.asarray(rates, dtype=float))

    def stop(self, rows):
        """Make the commands in force of robots ``rows`` zero."""
        self._commands.stop(rows)

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
        self._motion.place(rows, poses, twists, *(() if z is None else (z,)))

    def step(self):
        """Advance by one step: watchdogs, motion, odometry, collisions."""
        commands, faults, flights = self._commands, self._faults, self._flights
        commands.watch()
        if commands.silence_groups:
            commands.stop_silent(self.timed_out)
        if faults.due and not flights.rising:
            faults.inject_due()
        if self._obstacles_move:
            then = (self._clock.steps + 1) * self.step_size
            self._motion.move_obstacles(obstacles_at(self.obstacles, then))
        obeyed = commands.obeyed()
        if flights.busy:
            obeyed = flights.obeyed(obeyed)
        if self._shore:
            obeyed = self._shore.obeyed(obeyed)
        self._motion.advance(obeyed)
        self._clock.steps += 1
        faults.look()
        if self._shore:
            self._shore.look()
        if self._grasps:
            self._grasps.look()
        self._estimates.update()
        contacts = self._motion.contacts()
        if contacts:
            self._contacts.note(contacts)

    def rise(self):
        """Let robots that begin on the ground take off before the run, whose time begins when all are up.

        Raises ``WorldError`` where one is not up after ``LONGEST_RISE``.
        """
        while self.rising:
            self.step()
            if self.time > LONGEST_RISE:
                stuck = self._flights.next_rising()
                raise WorldError(
                    "takeoff: robot{} is {:.2f} m high after {:g} s, wanted {:g} m".format(
                        stuck + 1, self.z[stuck], LONGEST_RISE, self._flights.takeoff[stuck]
                    )
                )
        self._clock.rewind()
        self._commands.rewind()
        self._contacts.begin()
        self._faults.clear_reports()
        self._estimates.begin()

    def can_leap(self, every):
        """Return whether :meth:`leap` can move these robots, which get a command ``every`` steps.

        Each part of this world, except ``PASSIVE`` ones, must have a true ``can_leap`` of its own: without
        one, a part acts at each step.
        """
        parts = [part for name, part in vars(self).items() if name not in PASSIVE]
        there = [part for part in parts if part is not None and part is not False]
        leaping = all(getattr(part, "can_leap", False) for part in there)
        return leaping and every * self.step_size <= self._commands.shortest_timeout

    def leap(self, steps, every, function, *given):
        """Advance by up to ``steps`` steps in one compiled call, see ``fused_stepping.Leaps.advance``."""
        until = every - self._clock.steps % every
        target = self._commands.target
        done, why = self._motion.leap(steps, until, every, target, function, *given)
        self._clock.steps += done
        if done >= until:
            self._commands.note_received_by_all(self._clock.steps - (done - until) % every)
        return done, why

    def measure_closest_approach(self):
        """Return the least distance [m] between two centres seen so far, now included."""
        return self._contacts.measure()

    def take_collisions(self):
        """Return the collisions begun since the last call."""
        return self._contacts.take()

    def take_incidents(self):
        """Return the ``scenario.incidents.Incident``s since the last call."""
        return self._faults.take()

    def close(self):
        """Release the motion's resources, such as a solver."""
        self._motion.close()


def _read_only(array):
    """Return a view of ``array`` through which it cannot be changed."""
    view = array.view()
    view.flags.writeable = False
    return view


def _team_of(scenario):
    try:
        return team_of(scenario)
    except ValueError as error:
        raise WorldError(str(error)) from None
