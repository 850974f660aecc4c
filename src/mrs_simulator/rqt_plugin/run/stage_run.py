"""The simulation of a study: starts a stage or attaches to one, and sets its team; without Qt."""

import math

from mrs_simulator.protocols import HOMES
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.history import ROUNDING
from mrs_simulator.rqt_plugin.run.staged import staged_scenario
from mrs_simulator.rqt_plugin.run.study_state import named
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.results.report import write_scenario
from mrs_simulator.vehicles.portable import team_from_message

# What a stage has from its start.
OF_THE_STAGE = ("fidelity", "engine", "odometry", "limits", "obstacles", "step", "cmd_vel_timeout")
ATTACHED = "attached to the running stage"


class StageRun:
    """The stage that runs, started here or elsewhere."""

    def __init__(self, connection, processes, edited, state):
        """``edited``: the ``EditedScenario``; ``state``: the ``StudyState``."""
        self._connection, self._processes = connection, processes
        self._edited, self._state = edited, state
        self.lockstep = False  # whether the stage that was started here waits for commands
        self._speed, self._whole = None, False  # of a stage that is about to start
        self._swapped = None  # [what /use_sim_time was before a stage was started here]

    def simulate(self, speed, whole=False):
        """Start a stage at ``speed``, or attach to the one that runs; return a message, or "".

        ``whole``: for a run from its beginning to its end: time begins with the
        controller, and waits for it.
        """
        if self._connection.is_fresh("stage"):
            return self._attach()
        try:
            scenario_from_dict(self._edited.scenario.to_dict(), "scenario")
        except ValueError as error:
            return ErrorMessage(error)
        if self._speed is None:
            self._connection.begin_simulated_time()  # whose answer starts the stage
        self._speed, self._whole = speed, whole
        return ""

    def start(self, success, before):
        """Start the stage once time is a simulated one; ``before``: what ``/use_sim_time`` was."""
        speed, self._speed = self._speed, None
        if not success:
            return ErrorMessage("simulation not started: {}".format(before))
        self._swapped = [before]
        self._connection.begin_run()
        # Else a controller that cannot keep up would drive another experiment, and be judged for it.
        self.lockstep = self._whole or speed != 1.0
        options = ["_speed:={:g}".format(speed), lockstep_option(self.lockstep)]
        written = write_scenario(self._edited.scenario, self._processes.directory)
        self._processes.start("stage", "stage", "--scenario", written, *options)
        return "simulation started"

    def is_gone(self):
        """Return whether no stage of the GUI's own runs, or is about to once time is a simulated one."""
        return self._speed is None and self._processes.is_gone("stage")

    def end(self):
        """End the stage that was started here."""
        self._processes.stop("stage")
        self.restore_time()

    def restore_time(self):
        """Leave ``/use_sim_time`` as it was before a stage was started here."""
        if self._swapped is not None:
            self._connection.restore_simulated_time(*self._swapped)
            self._swapped = None

    def _attach(self):
        """Take up the scenario of the stage that runs; its law only if that is a shipped one."""
        if self._processes.is_running("control"):  # for that scenario, and perhaps another law
            return ATTACHED
        try:
            runs = self._scenario()
        except ValueError as error:
            return ErrorMessage("not attached: {}".format(error))
        if runs is None:
            return ErrorMessage("not attached: the stage has not published its scenario yet")
        try:
            team_from_message(runs)  # nor does it open files
        except ValueError as error:
            return ErrorMessage("not attached: {}; open the stage's scenario here".format(error))
        mine = self._edited.scenario
        if runs.control.protocol not in HOMES:  # a name that comes in a topic runs no code
            runs = runs._replace(control=mine.control, path=mine.path)
        speed = self._connection.newest("stage").speed
        return self._edited.try_out(runs._replace(speed=speed)) or ATTACHED

    def _scenario(self):
        """Return the scenario of the stage that runs, None before it is known."""
        text = self._connection.newest("scenario")
        if text is None or not self._connection.is_fresh("stage"):
            return None
        return staged_scenario(text)

    def kept(self):
        """Return a message on what a running stage does not take over from the scenario, or ""."""
        runs, mine = self._scenario(), self._edited.scenario
        if runs is None:
            return ""
        kept = [name for name in OF_THE_STAGE if getattr(runs, name) != getattr(mine, name)]
        other = "the running simulation keeps its own {}: end it to use the scenario's"
        return other.format(", ".join(kept)) if kept else ""

    def pause(self, _=None):
        """Pause a stage that runs, let a paused one go on."""
        stage = self._connection.newest("stage")
        self._connection.ask("pause", not (stage is not None and stage.paused))
        return ""

    def end_after(self, duration):
        """Let the next run pause after ``duration`` [s]; the answer is the result ``pause_after``."""
        step = (self._scenario() or self._edited.scenario).step
        self._connection.pause_after(math.ceil(duration / step - ROUNDING))

    def step(self, _=None):
        """Advance by one step."""
        self._connection.ask("step", 1)
        return ""

    def reset(self, _=None):
        """Put the robots to where they began."""
        self._connection.ask("reset")
        return ""

    def set_speed(self, speed):
        """Ask a running stage for ``speed``; return a message, or ""."""
        self._edited.scenario = self._edited.scenario._replace(speed=speed)
        if not self._connection.is_fresh("stage"):
            return ""
        self._connection.ask("set_speed", speed)
        real = self._state.real() if speed != 1.0 else ()
        return "{}: real, at 1 \u00d7 at any speed".format(named(real)) if real else ""

    def set_team(self):
        """Ask for the team as it stands; return a message, or ""."""
        mine = self._edited.scenario
        self._connection.set_team(mine.poses, mine.kinds, mine.altitude)
        real = self._state.real()
        return "{}: real, not moved".format(named(real)) if real else ""


def lockstep_option(waits):
    """Return the argument of a node that is to wait, or not, for the others in each cycle."""
    return "_lockstep:={}".format(str(bool(waits)).lower())
