"""One run by one button: simulation, controller, the scenario's duration, verdict."""

import time

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.history import ROUNDING
from mrs_simulator.rqt_plugin.run.study_run import WHOLE
from mrs_simulator.rqt_plugin.run.study_state import START_LIMIT

ELSEWHERE = "a simulation runs that was started elsewhere: start the controller singly"
LATE = "no run: the {} has not done its part within {:g} s; End it, and press Run"
# What a run that begins waits for, and who is late where it does not come.
STARTING = {
    "reset": "simulation",
    "controller's end": "controller of the run before",
    "set_team": "simulation",
    "simulation": "simulation",
    "pause_after": "simulation",
    "controller": "controller",
}


class WholeRun:
    """Starts what a run needs, step by step, and ends with its verdict.

    Whatever else ends the run, such as Stop, End or a law that fails, ends this, too.
    """

    def __init__(self, study, history, results, team, say):
        """``results``: the ``Results``; ``team``: the ``PendingTeam``; ``say``: shows a message."""
        self._study, self._history, self._results, self._say = study, history, results, say
        self._team = team
        self._stood = None  # [s] since when a controller has been there that moves no robot
        self.waits, self._since = "", 0.0  # for what, and since when, "" while no run is under way
        self._cleared = 0  # times that the history had been cleared when a run was asked for

    def no_run(self):
        """Return why a run cannot begin now, or ""."""
        state, here = self._study.state, self._study.processes.is_running("stage")
        if self.waits:
            return "a run is under way"
        if state.real():
            return "real robots are checked first: use Start controller"
        if state.is_emergency():
            return "release the emergency stop first"
        if state.hangs():
            return "the controller {}: end it first".format(state.hangs())
        if self._study.connection.is_fresh("stage"):
            return "" if here else ELSEWHERE
        return state.actions()["simulate"][1]

    def begin(self, speed):
        """Begin a run at ``speed``; robots of one before return to where they began."""
        why = self.no_run()
        if why:
            return ErrorMessage("no run: " + why)
        self._cleared, self._stood = self._history.cleared, None
        connection = self._study.connection
        if not connection.is_fresh("stage"):
            said = self._study.do(WHOLE, speed)
            self.wait_for("" if isinstance(said, ErrorMessage) else "simulation")
            return said
        self._study.do("reset")
        connection.ask("pause", False)
        self.wait_for("reset")
        return ""

    def answered(self, name, success):
        """Take in the answer to the request ``name``."""
        if name == self.waits == "reset":
            after = "simulation" if self._team.is_taken() else "controller's end"
            self.wait_for(after if success else "")
        elif name == self.waits == "set_team":
            self.wait_for("simulation" if success else "")
        elif name == self.waits == "pause_after" and not self._team.is_taken():
            # edited meanwhile: a team sent later would end the controller
            self.wait_for("simulation")
        elif name == self.waits == "pause_after":
            said = self._study.do("control")
            self._say(said)
            self.wait_for("" if isinstance(said, ErrorMessage) else "controller")

    def give_up(self):
        """Let what runs go on, without an end and a verdict of itself."""
        if self.waits in ("controller", "end"):
            self._study.connection.pause_after(0)
        self.waits = ""

    def wait_for(self, what):
        self.waits, self._since = what, time.monotonic()

    def follow(self):
        """Go on with the next step where the last one is done."""
        if self.waits in STARTING:
            self._follow_start()
        elif self.waits == "end":
            self._follow_run()

    def _follow_start(self):
        is_there = self.waits == "simulation" and not self._study.state.no_start()
        if self._study.is_controlled() and self.waits == "controller":
            self.wait_for("end")
        elif (self.waits == "controller's end" and not self._study.is_controlled()) or (
            is_there and not self._team.is_taken() and self._study.connection.is_fresh("state")
        ):
            self.wait_for("set_team")
            self._say(self._team.send_now())
        elif is_there and self._team.is_taken():
            self._study.stage.end_after(self._study.scenario.duration)
            self.wait_for("pause_after")
        elif self.waits == "simulation" and self._study.stage.is_gone():
            self.waits = ""  # it was refused: messages say why
        elif time.monotonic() - self._since > START_LIMIT:
            self._say(ErrorMessage(LATE.format(STARTING[self.waits], START_LIMIT)))
            self.waits = ""

    def _begun(self, snapshot):
        """Return when the run began, [s]; with the controller where no robot was ever moved."""
        history = self._history
        if history.begun is not None or not len(history.time):
            return history.begun
        if history.recorded is not None:  # from its beginning
            return history.time[0]
        if self._stood is None and snapshot is not None:
            self._stood = max(history.time[0], history.applied.since(snapshot.time))
        return self._stood

    def _follow_run(self):
        connection, history = self._study.connection, self._history
        if (
            history.cleared == self._cleared
        ):  # what is there, and its controller, is of a run before
            if time.monotonic() - self._since > START_LIMIT:
                self._say(ErrorMessage(LATE.format("run", START_LIMIT)))
                self.waits = ""
            return
        if not self._study.is_controlled():
            if not self._study.state.is_silent():
                self.waits = ""  # stopped, or failed: messages say why
            return
        snapshot, ran = connection.snapshot(), history.scenario or self._study.scenario
        begun = self._begun(snapshot)
        if begun is None or snapshot is None:
            return
        # What a program records it has itself; else the run is what is in the history.
        now = history.time[-1] if history.recorded is None else snapshot.time
        if now - begun >= ran.duration - ROUNDING:
            self.waits = ""
            history.begun = begun  # the controller may have commanded the robots to stand
            if not connection.newest("stage").paused:
                connection.ask("pause", True)  # of a run in which nothing moved
            self._results.judge()
