"""Status texts and enabled actions, without Qt and ROS."""

from mrs_simulator.core.fields import counted
from mrs_simulator.record.controller_log import EMERGENCY
from mrs_simulator.state.columns import REAL
from mrs_simulator.study.run.ahead import FIDELITIES

BY_REQUEST = "stopped by request"  # the controller's text for a stop that a user asked for
RELEASED = "the emergency stop was released"
NO_MASTER = "no ROS master"
NO_STAGE = "no simulation runs"
REAL_ALONE = "the robots are real, there is no simulation to {}"
HANGS = 3.0  # [s] of wall time without a message after which a controller hangs
START_LIMIT = 20.0  # [s] of wall time within which one started here has to publish its status
SILENT = "has not answered for {:.0f} s"
NEVER = "has not answered since it started {:.0f} s ago"
USUAL_TOPIC = "/robot{}/odom"


class StudyState:
    """Reads the state of master, stage, controller and robots from the connection."""

    def __init__(self, connection, processes, preflight):
        """``preflight``: the ``PreflightRun``."""
        self.connection, self.processes, self.preflight = connection, processes, preflight
        # Whether the run in view is over and nothing moves, although its controller is still there.
        self.is_over = lambda: False

    # State ---------------------------------------------------------------------------------------

    def is_controlled(self):
        """Return whether a controller runs and gives commands."""
        control = self.connection.newest("control")
        return self.connection.is_fresh("control") and control is not None and control.running

    def is_silent(self):
        """Return whether a controller started here gave commands, and now says nothing.

        The machine is busy, or a law hangs, which :meth:`hangs` says.
        """
        control = self.connection.newest("control")
        commands = (
            control is not None and control.running and not self.connection.is_fresh("control")
        )
        return commands and self.processes.is_running("control")

    def drives(self):
        """Return whether a controller gives commands in a run that is not over."""
        return self.is_controlled() and not self.is_over()

    def has_control(self):
        """Return whether a controller takes edits: one that runs, stands or is about to start."""
        is_fresh = self.connection.is_fresh("control") and not self.processes.is_ending("control")
        return is_fresh or self.processes.is_running("control")

    def hangs(self):
        """Return the text on a controller that does not respond, or ""."""
        silence, here = self.connection.silence("control"), self.processes.is_running("control")
        if silence is None:
            age = self.processes.age("control") if here else 0.0
            return NEVER.format(age) if age > START_LIMIT else ""
        there = here or "control" in self.connection.registered
        return SILENT.format(silence) if silence > HANGS and there else ""

    def is_emergency(self):
        """Return whether the emergency stop is latched."""
        return bool(self.connection.newest("emergency"))

    def real(self):
        """Return the numbers of the real robots."""
        snapshot = self.connection.snapshot()
        return frozenset() if snapshot is None else snapshot.numbers_with(REAL)

    def real_alone(self):
        """Return whether there are real robots, and no simulation about them."""
        return bool(self.real()) and not self.connection.is_fresh("stage")

    def started_elsewhere(self):
        """Return whether a controller runs that was not started here."""
        return self.connection.is_fresh("control") and not self.processes.is_running("control")

    def lines(self):
        """Return ``name: (good, text)`` of master, stage, controller, robots and time."""
        connection = self.connection
        stage, alive = connection.newest("stage"), connection.is_fresh("stage")
        return {
            "master": self._master(),
            "stage": self._stage(stage, alive),
            "controller": self._controller(connection.newest("control")),
            "robots": self._robots(),
            "time": self._time(stage, alive),
        }

    def _master(self):
        if "master" in self.connection.absent:
            return None, self.connection.absent["master"]
        online = self.connection.master_online
        return online, "master" if online else "no master"

    def _stage(self, stage, alive):
        if not alive:
            starting = self.processes.is_running("stage")
            return (False, "stage starting") if starting else (None, "no stage")
        where = "" if self.processes.is_running("stage") else ", started elsewhere"
        return True, "stage: {}{}{}".format(
            stage.fidelity, " (paused)" if stage.paused else "", where
        )

    def _controller(self, control):
        if self.preflight.starting:
            return None, "controller: the robots are checked before it starts"
        hangs = self.hangs()
        if hangs:
            return False, "controller: {}".format(hangs)
        if control is None or not self.connection.is_fresh("control"):
            starting = self.processes.is_running("control")
            return None, "controller starting" if starting else "no controller"
        if control.running and not control.trouble:
            return True, "controller: {}".format(control.protocol)
        if (
            control.trouble.startswith((EMERGENCY, RELEASED))
            and not control.running
            and not self.is_emergency()
        ):
            return None, "controller: stopped; emergency stop released: press Start"
        good = None if control.trouble == BY_REQUEST else False
        return good, "controller: {}".format(control.trouble or "stopped")

    def _robots(self):
        snapshot = self.connection.snapshot()
        if snapshot is None:
            return None, "no robots"
        n, real = len(snapshot.robots), len(snapshot.numbers_with(REAL))
        stale = len(self._stale(snapshot))
        text = counted(n, "robot")
        if real:
            simulated = "{} simulated, ".format(n - real) if n > real else ""
            text = "robots: {}{} real".format(simulated, real)
        return not stale, text + (", {} stale".format(stale) if stale else "")

    @staticmethod
    def _stale(snapshot):
        return [n for n, fresh in zip(snapshot.robots, snapshot.fresh) if not fresh]

    def _time(self, stage, alive):
        snapshot = self.connection.snapshot()
        if snapshot is None:
            return None, ""
        text = "t = {:.1f} s".format(snapshot.time)
        if not alive:
            return None, text
        if not stage.paused:  # its speed is that of before
            text += ", {:.1f} \u00d7 real time".format(stage.real_time_factor)
        if snapshot.numbers_with(REAL) and stage.speed != 1.0:
            return False, text + ", but real robots run at 1 \u00d7"
        return True, text

    # What can be done ----------------------------------------------------------------------------

    def actions(self):
        """Return ``name: (possible, remark)`` of the run's actions, with a reason or a warning."""
        connection = self.connection
        stage, alive = connection.newest("stage"), connection.is_fresh("stage")
        paused = alive and stage is not None and stage.paused
        reasons = {
            "simulate": self._no_simulation(),
            "pause": self._no_stage("pause"),
            "step": self._no_stage("step") or ("" if paused else "pause the simulation first"),
            "reset": self._no_stage("reset"),
            "speed": self._no_stage("speed up") if self.real_alone() else "",
            "end": "" if self.processes.is_running("stage") else "no simulation was started here",
            "preflight": self._no_check(),
            "control": self.no_start(),
            "stop": ""
            if self.is_controlled() or self.preflight.starting or self.hangs()
            else "no controller sends commands",
            "bag": "" if connection.master_online else NO_MASTER,
            "save": "" if connection.snapshot() is not None else "no data of robots received",
        }
        reasons.update(
            (name, connection.absent[name]) for name in reasons if name in connection.absent
        )
        remarks = dict.fromkeys(reasons, "")
        if self.real() and alive:
            remarks["reset"] = "real robots stay where they are: {}".format(named(self.real()))
            remarks["speed"] = "real robots run at 1 \u00d7, whatever the simulation's speed"
        if self.real():
            remarks["control"] = "the robots are checked first: some are real"
        return {name: (not why, why or remarks[name]) for name, why in reasons.items()}

    def _no_stage(self, what):
        if self.connection.is_fresh("stage"):
            return ""
        return REAL_ALONE.format(what) if self.real() else NO_STAGE

    def _no_simulation(self):
        if not self.connection.master_online:
            return NO_MASTER
        if self.processes.is_running("stage"):
            return "already running"
        if self.processes.is_ending("stage"):
            return "the last simulation is ending"
        if self.real_alone():  # two sources of one robot's state
            return "real robots publish odometry: a simulation would be mixed up with them"
        return ""

    def _no_check(self):
        if not self.connection.master_online:
            return NO_MASTER
        return "a check is under way" if self.preflight.running else ""

    def no_start(self):
        """Return why the controller cannot be started now, or ""."""
        snapshot = self.connection.snapshot()
        if not self.connection.master_online:
            return NO_MASTER
        if snapshot is None:
            return "no robots: start the simulation, or the robots' drivers"
        if self.is_controlled():
            return "a controller runs"
        if self.hangs():
            return "the controller {}: end it first".format(self.hangs())
        if self.processes.is_ending("control"):
            return "the last controller is ending"
        if self.is_emergency():
            return "release the emergency stop first"
        if self.preflight.running:
            return "a check is under way"
        stale = self._stale(snapshot)
        if stale:
            return "no recent data of {}".format(named(stale))
        return self._no_topics(snapshot)

    def _no_topics(self, snapshot):
        """Return why no controller of the GUI's own can reach the real robots, or ""."""
        if self.connection.is_fresh("control") or self.connection.is_fresh("stage"):
            return ""
        topics = self.connection.odometry_topics()
        other = [t for n, t in sorted(topics.items()) if t != USUAL_TOPIC.format(n)]
        if not snapshot.numbers_with(REAL) or not other:
            return ""
        text = "odometry on {}: start the controller with the launch file that sets this topic"
        return text.format(other[0])

    def team_locked(self):
        """Return why the team cannot be changed now, or ""."""
        if self.drives():
            return "stop the controller to change the team: press Reset, End, or Stop controller"
        if self.real_alone():
            return "real robots cannot be placed; a scenario can be opened"
        return ""

    def no_push(self):
        """Return why no robot can be pushed now, or ""."""
        stage = self.connection.newest("stage")
        if "hold" in self.connection.absent:
            return self.connection.absent["hold"]
        if self.real():
            return "real robots are pushed by hand"
        if stage is not None and stage.fidelity not in FIDELITIES:
            return "with forces no robot can be put elsewhere"
        return "" if self.is_controlled() else "run first: robots are pushed on their way"

    def obstacles_locked(self):
        """Return why obstacles cannot be changed now, or ""."""
        if self.drives():
            return "stop the controller to change the obstacles: press End"
        if self.connection.is_fresh("stage") or self.processes.is_running("stage"):
            return "the simulation reads obstacles at its start: end it to change them, by End"
        if self.started_elsewhere():
            return "the controller was started elsewhere with its own obstacles: end it first"
        return ""

    def poses_locked(self, n):
        """Return why the robots of a scenario of ``n`` cannot be dragged now, or ""."""
        running = len(self.connection.snapshot().robots) if self.connection.is_fresh("state") else n
        if running != n and not self.processes.is_running("stage"):
            return "{} robots run, the scenario has {}: attach to the simulation first".format(
                running, n
            )
        if self.is_controlled() and self.is_over():
            return "the map shows where the run has ended: press Reset to drag robots, or type their poses"
        return self.team_locked()


def named(numbers, most=6):
    """Return robots' ``numbers`` for a message: all of a few, else the first and how many."""
    numbers = sorted(numbers)
    shown = ", ".join("robot{}".format(number) for number in numbers[:most])
    more = len(numbers) - most
    return shown + (" and {} more".format(more) if more > 0 else "")
