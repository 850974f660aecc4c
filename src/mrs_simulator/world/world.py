"""The world: n robots, their commands and watchdogs, moved step by step.

>>> import numpy as np
>>> from mrs_simulator.core.robots import DEFAULT_KIND
>>> world = World((DEFAULT_KIND,), [[0.0, 0.0, 0.0]], limits=None)
>>> world.set_commands([0], np.array([[0.5, 0.0]]))
>>> for _ in range(25): world.step()
>>> bool(abs(world.pose[0, 0] - 0.25) < 1e-12)
True
"""

import numpy as np

from mrs_simulator.core.environment import CALM
from mrs_simulator.core.incidents import ARM_END, FELL, LET_GO, LOST, OFF, Incident
from mrs_simulator.core.kinematics import compose, relative, wrap_angle
from mrs_simulator.core.maps import obstacles_of
from mrs_simulator.core.mismatch import NO_MISMATCH, Obedience
from mrs_simulator.core.moving import moves, obstacles_at
from mrs_simulator.core.recording import Collision
from mrs_simulator.core.scenario import DEFAULT_HAND_LENGTH, FARTHEST, FIDELITIES
from mrs_simulator.core.spatial import rotated, turned
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.state import State
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.arms.team import ArmedTeam, has_arms
from mrs_simulator.vehicles.odometry_rates import Schedule, odometry_notes, odometry_steps
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.world import odometry
from mrs_simulator.world.airborne import AirborneMotion, ForcedAirborneMotion
from mrs_simulator.world.armed import ArmedMotion
from mrs_simulator.world.bodies import Bodies
from mrs_simulator.world.carrying import CarriedLoad, LoadError
from mrs_simulator.world.eyes import Eyes
from mrs_simulator.world.forced import ForcedMotion
from mrs_simulator.world.kinematic import KinematicMotion, PointMassMotion
from mrs_simulator.world.manoeuvres import HOVER_HEIGHT, Manoeuvres
from mrs_simulator.world.touching import is_available

EVERY = slice(None)  # the rows of all robots
FASTEST = 1e12  # [m/s, rad/s] of any command: far beyond it poses would not be numbers for long
FORGET = 0.1  # [s] without contact after which touching again is a new collision
LONGEST_RISE = 120.0  # [s] of a take-off before the run
FEW = 100  # [-] past contacts that may be kept in memory whatever their age


NO_SOLVER = (
    "fidelity 'dynamic': the Python package pybullet is missing; wanted it installed "
    "(pip install pybullet), or fidelity kinematic"
)


class WorldError(ValueError):
    """Something the world cannot be; the message names it, what came and what was wanted."""

    page = "docs/scenarios.md#where-robots-begin"


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
        are read beside the odometry; ``odometry_errors``: ``core.odometry_errors``, instead of those
        built in; ``events``: ``core.incidents.Event``s in the order of their times; ``takeoff``: whether
        robots begin on the ground and rise to ``z`` before anybody obeys; ``load``: a ``core.load.Load``
        that the robots' tools carry.  Raises ``WorldError``.
        """
        self.step_size = step
        self._given_load, self.load = load, None
        self.fidelity = fidelity
        self.obstacles = tuple(obstacles)  # as they begin: ``core.moving.obstacles_at``
        self._obstacles_move = any(map(moves, self.obstacles))
        self._limits = limits
        self._cmd_vel_timeout = cmd_vel_timeout
        self._hand_length = hand_length
        self._odometry_kind = odometry_kind
        self._odometry_errors = odometry_errors
        self._counts_wheels = counts_wheels or odometry_kind == "wheel"
        self._seed = seed
        self._mismatch = mismatch
        self._command_period = command_period
        self._environment = environment
        self._odometry_rate, self._schedule = odometry_rate, None
        self._events, self._takeoff, self._to = tuple(events), takeoff, None
        self.mirrored = np.array(sorted(set(mirrored)), dtype=int)
        self._steps_per_watch = max(1, int(round(watch_period / step)))
        self._step = 0
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
                counts_wheels=any(mount.type == "encoders" for own in mounts for mount in own),
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
        team, poses = checked_team(kinds, poses, self._limits)
        z = checked_heights(team, z)
        if len(self.mirrored) and not 0 <= self.mirrored[0] <= self.mirrored[-1] < team.n:
            raise WorldError(
                "real robots {}: wanted numbers from 1 to {}, the size of the team".format(
                    (self.mirrored + 1).tolist(), team.n
                )
            )
        if self.fidelity != "point_mass":
            refuse_overlaps(team, poses, obstacles_at(self.obstacles, self.time), z=z)
        refuse_events(team, self._events, self.fidelity)
        if self._takeoff and z is not None:
            self._to, z, self._takeoff = z, np.zeros(team.n), False
        else:
            self._to = None
        self._check_load(team, poses)
        motion = self._new_motion(team, poses, z)
        if self._motion is not None:
            self._motion.close()
        self.load = None  # its body has gone with the motion
        self._motion, self.team, self._start, self._start_z = motion, motion.team, poses, z
        self._aloft = np.flatnonzero(self.team.airborne)
        self._mishaps = getattr(motion, "mishaps", None)
        self._own_stops = [g for g in self.team.groups if hasattr(g.drive, "silent")]
        self._odometry = self._new_odometry()
        self._odometry.begin_at(poses[:, 2])
        if self._odometry_rate is not None:
            steps = odometry_steps(self.team, self._odometry_rate, self.step_size)
            self._schedule = Schedule(steps)
        given = self._cmd_vel_timeout
        self.timeouts = self.team.timeouts if given is None else np.full(self.n, float(given))
        self._shortest_timeout = float(self.timeouts.min())
        self.refused = np.zeros(len(poses), dtype=int)
        self._fresh_start()

    def _new_motion(self, team, poses, z):
        mirrored = {"mirrored": self.mirrored}
        if self._obstacles_move and (team.has_arms or self.fidelity == "dynamic"):
            raise WorldError(
                "obstacle {} moves: wanted fidelity kinematic, and robots without arms".format(
                    next(each.name for each in self.obstacles if moves(each))
                )
            )
        if team.has_arms:
            refuse_armed(team, self.fidelity)
            if self.fidelity == "dynamic":
                return self._armed_dynamics(team, poses)
            return ArmedMotion(team, self._new_motion(team.bases, poses, z), **mirrored)
        if self.fidelity == "point_mass":
            team = Team(team.kinds, None)
            return PointMassMotion(
                team,
                poses,
                self._hand_length,
                self.step_size,
                **mirrored,
                period=self._command_period,
                environment=self._environment,
                z=z,
            )
        bodies = team, poses, self.obstacles, self._limits, self.step_size
        moving = {"encoders": self._counts_wheels, "environment": self._environment}
        if self.fidelity == "kinematic":
            if team.is_spatial:
                return AirborneMotion(*bodies, **mirrored, **moving, z=z)
            return KinematicMotion(*bodies, **mirrored, **moving)
        if self.fidelity != "dynamic":
            raise WorldError(
                "fidelity {!r}: wanted one of {}".format(self.fidelity, ", ".join(FIDELITIES))
            )
        media = {group.drive.MEDIUM for group in team.groups}
        weather = {"seed": self._seed}
        if "air" in media:
            refuse_forceless(team)
            if not is_available():
                raise WorldError(NO_SOLVER)
            return ForcedAirborneMotion(*bodies, **mirrored, **moving, **weather, z=z)
        if "water" in media:
            return ForcedMotion(*bodies, **mirrored, **moving, **weather)
        try:
            from mrs_simulator.world.dynamic import DynamicMotion  # pybullet only where it is used
        except ModuleNotFoundError as error:
            if error.name != "pybullet":
                raise
            raise WorldError(NO_SOLVER) from None
        return DynamicMotion(*bodies, **mirrored)

    def _armed_dynamics(self, team, poses):
        if not is_available():
            raise WorldError(NO_SOLVER)
        from mrs_simulator.world.dynamic_arms import ArmedDynamicMotion  # pybullet, as above

        bodies = poses, self.obstacles, self._limits, self.step_size
        return ArmedDynamicMotion(team, *bodies, mirrored=self.mirrored)

    def _new_odometry(self):
        # Wheels that roll in pybullet slip by themselves.
        errors = self._odometry_errors
        slips = self.fidelity == "kinematic" and errors is None
        try:
            return odometry.WheelOdometry(
                self.team,
                mismatch=odometry.WHEEL_MISMATCH if slips else 0.0,
                slip=odometry.WHEEL_SLIP if slips else 0.0,
                seed=self._seed,
                errors=errors,
                step=self.step_size,
            )
        except ValueError as error:
            raise WorldError(str(error)) from None

    def reset(self):
        """Put the robots back to their initial poses, at rest; time goes on.

        Mirrored ones stay where they are; ``WorldError`` if one of those is in another's place.
        """
        poses, z = self._start.copy(), self._start_z
        poses[self.mirrored] = self.pose[self.mirrored]
        if z is not None:
            z = z.copy()
            z[self.mirrored] = self._motion.z[self.mirrored]
        if len(self.mirrored) and self.fidelity != "point_mass":
            refuse_overlaps(self.team, poses, (), self.mirrored, z)
        self._motion.reset(poses, *(() if z is None else (z,)))
        self._odometry.reset()
        self._fresh_start()

    def _fresh_start(self):
        self._target = np.zeros((self.n, len(self.team.axes)), order="F")
        self._obedience = None
        if self._mismatch != NO_MISMATCH:
            fitting = self._mismatch.with_robots(self.n)
            self._obedience = Obedience(fitting, self.team.axes, self.n, self.step_size)
        self._heard = np.full(self.n, -1)  # the step of the last accepted command, -1 for none
        self._longest_silent = self._step  # no commanded robot was heard last before this step
        self.commanded = np.zeros(self.n, dtype=bool)
        self._touching = {}
        self._new_collisions = []
        self._new_incidents, self._due, self._struck = [], list(self._events), {}
        self._manoeuvres = Manoeuvres(self.team)
        self._is_direct = False  # whether thrusters were told past the controllers
        self.rising = self._to is not None  # whether all wait until those that fly are up
        if self.rising:
            rows = np.flatnonzero(self._to > 0.0)
            self._manoeuvres.take_off(rows, self._to[rows])
        self.closest_approach = self.closest_distance()
        self._take_load()
        self._ended = set()  # (row, joint) of arms that have been at their ends
        self._begun, self._estimate = self._step, self._newest_estimate().copy()
        self._estimate_z = None if self.z is None else self.z.copy()

    def _check_load(self, team, poses):
        """Raise ``WorldError`` if a ``team`` at ``poses`` (n, 3) cannot take hold of the load."""
        load = self._given_load
        if load is None:
            return
        if not team.has_arms or any(each.arm is None for each in team.kinds):
            raise WorldError("load: wanted robots that all have an arm")
        if team.n != len(load.grasps):
            raise WorldError("load: {} grasps, wanted one for each of {} robots".format(
                len(load.grasps), team.n
            ))  # fmt: skip
        try:
            CarriedLoad(load, team.tools(poses, team.rest_joints, self._hand_length))
        except LoadError as error:
            raise WorldError(str(error)) from None

    def _take_load(self):
        if self._given_load is None:
            return
        if self.load is not None:
            self.load.remove()
        self.load = getattr(self._motion, "carry", CarriedLoad)(self._given_load, self._tools())

    def _tools(self):
        return self.team.tools(self.pose, self._motion.joints(), self._hand_length)

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
        return self._step * self.step_size

    @property
    def steps(self):
        """Return how many steps were made."""
        return self._step

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
        return _read_only(self._target)

    @property
    def timed_out(self):
        """Return which robots, (n,) bool, were commanded once and have been silent for too long.

        Mirrored ones are never among them: they have a watchdog of their own.
        """
        late = (self._heard >= 0) & ~self.commanded
        late[self.mirrored] = False
        return late

    def odometry(self):
        """Return what the robots' odometry says, (n, 3), each in its own odometry frame."""
        return self.pose if self._odometry_kind == "world" else _read_only(self._odometry.pose)

    def odometry_spatial(self):
        """Return the ``Spatial`` that goes with ``odometry``, None for a team on the ground.

        Heights are above the ground, whatever the odometry: nobody's begins at another height.
        """
        spatial = self.spatial
        if spatial is None or self._odometry_kind == "world":
            return spatial
        return spatial._replace(orientation=turned(spatial.orientation, -self._start[:, 2]))

    def estimate_z(self):
        """Return the heights (n,) [m] that go with ``estimate``, None for a team on the ground."""
        return self.z if self._schedule is None or self.z is None else _read_only(self._estimate_z)

    def odometry_origins(self):
        """Return where the odometry frames lie in the common frame, (n, 3)."""
        return np.zeros((self.n, 3)) if self._odometry_kind == "world" else _read_only(self._start)

    def estimate(self):
        """Return the poses in the common frame as odometry has told them last, (n, 3), read-only."""
        return self._newest_estimate() if self._schedule is None else _read_only(self._estimate)

    @property
    def notes(self):
        """Return what users of this world should know, a list of texts."""
        return odometry_notes(self.team, self._odometry_rate, self.step_size)

    def _newest_estimate(self):
        if self._odometry_kind == "world":
            return self.pose
        estimate = compose(self._start, self._odometry.pose)
        estimate[self.mirrored] = self.pose[self.mirrored]
        return estimate

    @property
    def senses(self):
        """Return what a ``sensors.suite.Suite`` is made of: team, obstacles, and what cameras see."""
        return self.team, self.obstacles, Eyes(self.team, self.obstacles)

    def sensed(self):
        """Return what sensors read now, a ``sensors.state.State``."""
        motion = self._motion
        travel, contacts = tuple(motion.wheel_travel), tuple(motion.contacts())
        pose, twist = self.pose, self.twist
        return State(self.time, pose, twist, motion.z, motion.spatial, travel, contacts)

    def closest_distance(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._motion.closest()

    def flight_states(self):
        """Return what each robot that flies does, ``{row: text}``: landed, taking off, hovering, flying,
        landing, falling, motors off, upside down."""
        if not len(self._aloft):
            return {}
        powered = getattr(self._motion, "powered", np.ones(self.n, dtype=bool))
        x, y = self.spatial.orientation.T[:2]
        over = x * x + y * y > 0.5  # the body's axis points down
        told = zip(self.z.tolist(), powered.tolist(), over.tolist(), self._target)
        return {
            row: self._manoeuvres.state(row, *each)
            for row, each in enumerate(told)
            if self.team.airborne[row]
        }

    # Changes -------------------------------------------------------------------------------------

    def take_off(self, rows, height=HOVER_HEIGHT):
        """Let robots ``rows``, which fly, rise to ``height`` [m] and hover, whatever they are commanded.

        Motors that were cut turn again.  ``WorldError`` names a robot that cannot.
        """
        rows = self._flyers(rows, "take off")
        if not 0.0 < height <= FARTHEST:
            raise WorldError("height {} m: wanted above 0, to {:g} m".format(height, FARTHEST))
        states = self.flight_states()
        for row in rows.tolist():
            lost = self._struck.get(row) == LOST
            if lost or states[row] in ("falling", "upside down"):
                state = "has lost a rotor" if lost else "is {}".format(states[row])
                raise WorldError("robot{} {}: wanted one that can take off".format(row + 1, state))
        for row in rows.tolist():
            if states[row] == "motors off":
                self._motion.power(row)
        self._manoeuvres.take_off(rows, height)
        # What was said before is over: it hovers until it is commanded anew.
        self._target[rows], self._heard[rows], self.commanded[rows] = 0.0, -1, False

    def power(self, rows):
        """Let motors that were cut turn again, of robots ``rows`` that stand upright on the ground."""
        states = self.flight_states()
        for row in self._flyers(rows, "power").tolist():
            if states[row] == "motors off" and self._struck.get(row) != LOST:
                self._motion.power(row)

    def land(self, rows):
        """Let robots ``rows``, which fly, come down where they are and stay down until they take off.

        Told again, they still land.  ``WorldError`` names a robot that does not fly.
        """
        self._manoeuvres.land(self._flyers(rows, "land"))

    def cut_motors(self, rows, falls=False):
        """Cut the motors of robots ``rows``, which fly; in the air only where it is said that it ``falls``.

        ``WorldError`` names a robot that would fall, or has no motors; then nothing is cut.
        """
        rows = self._flyers(rows, "cut")
        if self.fidelity == "point_mass":
            raise WorldError(
                "fidelity point_mass: robots have no motors; wanted kinematic or dynamic"
            )
        for row in rows.tolist():
            if self.z[row] > 0.0 and not falls:
                raise WorldError(
                    "robot{} is {:.2f} m high and would fall; wanted it landed, or its fall "
                    "confirmed".format(row + 1, self.z[row])
                )
        self._manoeuvres.release(rows)
        for row in rows.tolist():
            self._befall(row, OFF)

    def _flyers(self, rows, what):
        rows = np.arange(self.n)[rows] if isinstance(rows, slice) else np.atleast_1d(rows)
        for row in rows.tolist():
            able = self.team.airborne[row] and hasattr(self.kinds[row].module, "climbing")
            if not able or row in self.mirrored.tolist():
                kind = self.kinds[row].title
                raise WorldError(
                    "{}: robot{} is a {}; wanted a simulated robot that flies".format(
                        what, row + 1, "real one" if row in self.mirrored.tolist() else kind
                    )
                )
        return rows

    def _strike_due(self):
        """Let what the scenario has ordered for now befall robots."""
        now = (self._step - self._begun) * self.step_size
        while self._due and self._due[0].at <= now + 1e-9:
            event = self._due.pop(0)
            self._befall(event.robot - 1, event.event, event.rotor or 0)

    def _befall(self, row, fault, rotor=0):
        """Let a ``fault`` befall robot ``row``; ``rotor``: its number."""
        self._motion.strike(row, fault, rotor - 1)
        self._struck[row] = LOST if self._struck.get(row) == LOST else fault
        self._report(row, fault, rotor)

    def _report(self, row, what, rotor=0):
        ordered = row in self._struck
        name = "robot{}".format(row + 1)
        self._new_incidents.append(Incident(self.time, name, what, rotor, ordered))

    def take_incidents(self):
        """Return the ``core.incidents.Incident``s since the last call."""
        taken, self._new_incidents = self._new_incidents, []
        return taken

    def set_commands(self, rows, commands):
        """Give robots ``rows`` (m,), or ``EVERY`` robot, the commands (m, a), as ``team.axes``.

        One that is not finite, or beyond ``FASTEST``, is refused and counted in ``refused``; that
        robot keeps its last command until its own watchdog stops it.
        """
        rows = rows if rows is EVERY else np.asarray(rows, dtype=int)
        commands = np.asarray(commands, dtype=float)
        size = np.abs(commands)
        if not size.max(initial=0.0) <= FASTEST:  # nor is nan
            finite = (size <= FASTEST).all(axis=1)
            rows = np.arange(self.n)[rows]
            np.add.at(self.refused, rows[~finite], 1)
            rows, commands = rows[finite], commands[finite]
        self._target[rows] = commands
        self._heard[rows] = self._step
        self.commanded[rows] = True
        if self._is_direct:
            self._motion.efforts[rows] = np.nan

    def set_efforts(self, rows, efforts):
        """Tell the thrusters of vessels ``rows`` (m,) what their controllers would, ``efforts`` (m, 4).

        Commands of the left and the right one, force ahead [N] and torque [N m]; nan where the
        controllers act,
        by the command in force.  ``set_commands`` ends it, and so does the watchdog, with thrusters at
        rest. Raises ``WorldError`` where no forces are moved by.
        """
        rows, efforts = np.asarray(rows, dtype=int), np.asarray(efforts, dtype=float)
        for row in rows.tolist():
            if self.fidelity != "dynamic" or self.kinds[row].module.MEDIUM != "water":
                raise WorldError(
                    "thrusters of robot{}, a {}, in fidelity {}: wanted a vessel in fidelity "
                    "dynamic".format(row + 1, self.kinds[row].title, self.fidelity)
                )
        if not self._is_direct:
            self._is_direct, self._motion.efforts = True, np.full((self.n, 4), np.nan)
        fits = ~np.isinf(efforts).any(axis=1)
        np.add.at(self.refused, rows[~fits], 1)
        self._motion.efforts[rows[fits]] = efforts[fits]
        self._heard[rows[fits]], self.commanded[rows[fits]] = self._step, True

    def set_arm_rates(self, row, rates):
        """Let the arm of robot ``row`` turn at ``rates`` (k,) [rad/s], whatever its base does."""
        rates = np.asarray(rates, dtype=float)
        if np.abs(rates).max() <= FASTEST:  # nor is nan
            self._target[row, -len(rates) :] = rates

    def stop(self, rows):
        """Make the commands in force of robots ``rows`` zero, as if they had been told to stop."""
        self._target[rows] = 0.0
        if self._is_direct:
            self._motion.efforts[rows] = np.nan

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
        refuse_places(rows, poses, twists)
        poses[:, 2] = wrap_angle(poses[:, 2])
        self._motion.place(rows, poses, twists, *(() if z is None else (z,)))

    def step(self):
        """Advance by one step: watchdogs, motion, odometry, collisions."""
        self._watch()
        if self._own_stops:
            self._stop_silent()
        if self._due and not self.rising:
            self._strike_due()
        if self._obstacles_move:
            then = (self._step + 1) * self.step_size
            self._motion.move_obstacles(obstacles_at(self.obstacles, then))
        obeyed = self._obedience.obeyed(self._target) if self._obedience else self._target
        if self._manoeuvres.busy:
            obeyed = self._manoeuvres.applied(obeyed, self.z, self._climbing(), self.rising)
            if self.rising and not self._manoeuvres.rising.any():
                self.rising, self._begun = False, self._step
        self._motion.advance(obeyed)
        self._step += 1
        if self._mishaps is not None:
            for row, what in self._mishaps():
                self._report(row, what)
        if self.team.has_arms:
            self._look_at_arms()
        if self._odometry_kind == "wheel":
            joints = self._motion.joints()
            drives = joints if joints.ndim == 1 else joints[:, 0]
            self._odometry.update(self._motion.wheel_travel, drives, self.pose[:, 2])
            if len(self._aloft):  # robots without encoders know how they have moved
                moved = relative(self._start[self._aloft], self.pose[self._aloft])
                self._odometry.pose[self._aloft] = moved
        if self._schedule is not None:
            rows = np.union1d(self._schedule.due(self._step - self._begun), self.mirrored)
            self._estimate[rows] = self._newest_estimate()[rows]
            if self._estimate_z is not None:
                self._estimate_z[rows] = self.z[rows]
        contacts = self._motion.contacts()
        if contacts:
            self._note_contacts(contacts)

    def rise(self):
        """Let robots that begin on the ground take off, before the run: time begins when all are up.

        Raises ``WorldError`` where one has not come up after ``LONGEST_RISE``.
        """
        while self.rising:
            self.step()
            if self._step * self.step_size > LONGEST_RISE:
                stuck = int(np.flatnonzero(self._manoeuvres.rising)[0])
                raise WorldError(
                    "takeoff: robot{} is {:.2f} m high after {:g} s, wanted {:g} m".format(
                        stuck + 1, self.z[stuck], LONGEST_RISE, self._to[stuck]
                    )
                )
        self._step = self._begun = self._longest_silent = 0
        self._touching, self._new_collisions, self._new_incidents = {}, [], []
        self.closest_approach = self.closest_distance()
        self._estimate = self._newest_estimate().copy()
        self._estimate_z = None if self.z is None else self.z.copy()

    def _climbing(self):
        """Return how fast robots rise, (n,) [m/s]."""
        spatial, twist = self.spatial, self._motion.twist
        body = np.column_stack([twist[:, :2], spatial.twist[:, 0]])
        return rotated(spatial.orientation, body)[:, 2]

    def _look_at_arms(self):
        """Report who has come to the end of an arm's joint, or has let go of the load."""
        ended = set(map(tuple, np.argwhere(self._motion.ended).tolist()))
        for row, joint in sorted(ended - self._ended):
            self._report(row, ARM_END, joint + 1)
        self._ended |= ended
        if self.load:
            for row in self.load.update(self._tools()):
                self._report(row, LET_GO if self.load.held.any() else FELL)

    def can_leap(self, every):
        """Return whether :meth:`leap` moves these robots, of which each hears a command ``every`` steps."""
        acts = self._own_stops, self._events, self._mishaps, self._manoeuvres.busy, self._is_direct
        other = (
            self._obstacles_move
            or self._obedience
            or self._schedule is not None
            or self.team.has_arms
            or any(acts)
        )
        heard = every * self.step_size <= self._shortest_timeout
        plain = self.fidelity == "kinematic" and self._odometry_kind == "world"
        return bool(plain and heard and not other and self._motion.can_leap)

    def leap(self, steps, every, function, *given):
        """Advance by up to ``steps`` steps in one compiled call, see ``leaping.Leaps.advance``."""
        until = every - self._step % every
        done, why = self._motion.leap(steps, until, every, self._target, function, *given)
        self._step += done
        if done >= until:
            self._heard[:] = self._step - (done - until) % every
            self.commanded[:] = True
        return done, why

    def _watch(self):
        if self._step % self._steps_per_watch:
            return
        if not self._too_long(self._longest_silent, self._shortest_timeout):
            return
        late = self._too_long(self._heard, self.timeouts) & self.commanded
        if late.any():
            self._target[late] = 0.0
            self.commanded[late] = False
            if self._is_direct:
                told = late & ~np.isnan(self._motion.efforts).all(axis=1)
                self._motion.efforts[told] = [0.0, 0.0, np.nan, np.nan]
        self._longest_silent = self._heard[self.commanded].min(initial=self._step)

    def _stop_silent(self):
        """Let robots that have been silent for too long do what their drives do then, such as land."""
        late = self.timed_out
        for group in self._own_stops:
            rows = np.arange(self.n)[group.rows]
            out = late[rows]
            if out.any():
                seconds = (self._step - self._heard[rows]) * self.step_size - self.timeouts[rows]
                command = group.of(self._target).copy()
                command[out] = group.drive.silent(seconds, group.numbers)[out]
                group.put(self._target, command)

    def _too_long(self, heard, timeout):
        return (self._step - heard) * self.step_size > timeout - 1e-9

    def _note_contacts(self, contacts):
        now = self._step
        for first, second, *place in contacts:
            last = self._touching.get((first, second))
            if last is None or self._is_over(last):
                self._new_collisions.append(Collision(self.time, first, second, *place))
            self._touching[first, second] = now
        if len(self._touching) > 2 * len(contacts) + FEW:
            over = [pair for pair, last in self._touching.items() if self._is_over(last)]
            for pair in over:
                del self._touching[pair]
        # Robots in contact are as close as robots come.
        self.measure_closest_approach()

    def _is_over(self, last):
        return (self._step - last) * self.step_size > FORGET

    def measure_closest_approach(self):
        """Return the least distance [m] between two centres seen so far, now included."""
        self.closest_approach = min(self.closest_approach, self.closest_distance())
        return self.closest_approach

    def take_collisions(self):
        """Return the collisions begun since the last call."""
        taken, self._new_collisions = self._new_collisions, []
        return taken

    def close(self):
        """Give back what the motion holds."""
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


def refuse_events(team, events, fidelity):
    """Raise ``WorldError`` that names the first of ``events`` that can befall none of the ``team``."""
    for event in events:
        kind = team.kinds[event.robot - 1] if event.robot <= team.n else None
        if kind is not None and (not hasattr(kind.module, "lost") or fidelity == "point_mass"):
            why = "a {} without rotors".format(kind.title)
            if fidelity == "point_mass":
                why = "in fidelity point_mass, which has none"
            raise WorldError(
                "events: {} of robot{}, {}; wanted a robot that flies".format(
                    event.event, event.robot, why
                )
            )


def refuse_forceless(team):
    """Raise ``WorldError`` that names the first robot that flies without a motion with forces."""
    for row, each in enumerate(team.kinds):
        if each.module.MEDIUM == "air" and not hasattr(each.module, "with_forces"):
            text = "fidelity 'dynamic': robot{}, {}, has no motion with forces; wanted kinematic"
            raise WorldError(text.format(row + 1, each.title))


def refuse_armed(team, fidelity):
    """Raise ``WorldError`` that names the first robot whose arm has no motion of this ``fidelity``."""
    media = {group.drive.MEDIUM for group in team.groups}
    if fidelity == "kinematic" or (fidelity == "dynamic" and media == {"ground"}):
        return
    for row, each in enumerate(team.kinds):
        if each.arm is not None:
            text = "fidelity {!r}: robot{}, {}, has an arm; wanted kinematic"
            raise WorldError(text.format(fidelity, row + 1, each.title))


def checked_team(kinds, poses, limits):
    """Return the ``Team`` of ``kinds``, and ``poses`` (n, 3) floats; ``WorldError`` if they are not."""
    kinds = kinds if isinstance(kinds, Team) else tuple(kinds)
    count = kinds.n if isinstance(kinds, Team) else len(kinds)
    poses = np.array(poses, dtype=float)
    if poses.shape != (count, 3) or not count:
        raise WorldError(
            "poses of shape {}: wanted one [x, y, theta] for each of {} robots, at least one".format(
                poses.shape, count
            )
        )
    refuse_places(range(count), poses)
    try:
        team = Team.of(kinds, limits)
        if has_arms(team.kinds) and not team.has_arms:
            team = ArmedTeam(team.kinds, limits)
        return team, poses
    except ValueError as error:
        raise WorldError(str(error)) from None


def checked_heights(team, z):
    """Return the heights ``z`` (n,) as floats, None for a team on the ground; ``WorldError`` names a robot
    that cannot be there."""
    z = np.zeros(team.n) if z is None else np.array(z, dtype=float)
    if z.shape != (team.n,):
        raise WorldError("heights of shape {}: wanted one of {} robots".format(z.shape, team.n))
    bad = np.flatnonzero(~((z >= 0.0) & (z <= FARTHEST)))
    if len(bad):
        text = "robot{}: height {} m, wanted from 0 to {:g} m"
        raise WorldError(text.format(bad[0] + 1, z[bad[0]], FARTHEST))
    stuck = np.flatnonzero((z != 0.0) & ~team.airborne)
    if len(stuck):
        text = "robot{}: height {:g} m, but a {} stays on the ground; wanted 0"
        row = stuck[0]
        raise WorldError(text.format(row + 1, z[row], team.kinds[row].title))
    return z if team.is_spatial else None


def refuse_places(rows, poses, twists=0.0):
    """Raise ``WorldError`` that names the first of robots ``rows`` that can be at no such pose."""
    # A comparison with nan is false.
    fits = (np.abs(poses) <= FARTHEST).all(axis=1) & np.isfinite(poses + twists).all(axis=1)
    bad = np.flatnonzero(~fits)
    if len(bad):
        raise WorldError(
            "robot{}: pose {}, wanted finite numbers within {:g} m".format(
                rows[bad[0]] + 1, poses[bad[0]].tolist(), FARTHEST
            )
        )


def refuse_overlaps(kinds, poses, obstacles, mirrored=(), z=None):
    """Raise ``WorldError`` that names the first robots, or robot and obstacle, that overlap.

    Two ``mirrored`` rows may: nobody put them there.
    """
    bodies = Bodies(kinds, obstacles, mirrored)
    first, second, depth, _ = bodies.overlaps(poses, z)
    put = ~(bodies.mirrored[first] & bodies.mirrored[second])
    first, second, depth = first[put], second[put], depth[put]
    if len(first):
        i, j = first[0], second[0]
        raise WorldError(
            "robot{} and robot{} overlap: centres {:.3f} m apart, bodies {:.3f} m into each other; "
            "wanted them apart".format(
                i + 1, j + 1, np.linalg.norm(poses[i, :2] - poses[j, :2]), depth[0]
            )
        )
    refuse_in_obstacles(bodies, poses, z)


def refuse_in_obstacles(bodies, poses, z=None):
    """Raise ``WorldError`` that names the first robot and obstacle of ``bodies`` that overlap."""
    for obstacle, rows, _, _ in bodies.obstacle_overlaps(poses, z):
        raise WorldError(
            "robot{} overlaps obstacle {}; wanted them apart".format(rows[0] + 1, obstacle.name)
        )
