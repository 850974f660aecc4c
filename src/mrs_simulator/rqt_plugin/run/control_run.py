"""The controller of a study: started, after a check where robots are real, stopped and replaced; no Qt."""

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.preflight_run import Finding, real_arguments
from mrs_simulator.rqt_plugin.run.stage_run import lockstep_option
from mrs_simulator.study.results.report import write_scenario


class ControlRun:
    """The controller that runs, started here or elsewhere."""

    def __init__(self, connection, processes, edited, state, stage, preflight):
        """``stage``: the ``StageRun``; ``preflight``: the ``PreflightRun``."""
        self._connection, self._processes = connection, processes
        self._edited, self._state, self._stage = edited, state, stage
        self._preflight = preflight

    def start(self, _=None):
        """Start the controller, real robots after they were checked; return a message, or ""."""
        if not self._state.real():
            return self._start()
        self._preflight.begin(self.written(), self._own_findings(), accepted=frozenset())
        return "some robots are real: they are checked before the controller starts"

    def start_anyway(self):
        """Start the controller in spite of the last findings, unless a new check has others."""
        accepted = self._preflight.keys()
        self._preflight.begin(self.written(), self._own_findings(), accepted)
        return (
            "the robots are checked again; then the controller starts unless there are new findings"
        )

    def check(self, _=None):
        """Check the robots, and start nothing."""
        self._preflight.begin(self.written(), self._own_findings())
        return ""

    def checked(self, success, answer):
        """Handle the answer of a check; return a message."""
        preflight = self._preflight
        if preflight.ended(success, answer):
            why = self._state.no_start()
            preflight.outcome = "" if why else preflight.outcome
            return ErrorMessage("not started: {}".format(why)) if why else self._start()
        refused = ", the controller is not started" if preflight.outcome == "refused" else ""
        text = "robots checked, findings: {}{}".format(len(preflight.findings), refused)
        return ErrorMessage(text) if refused else text

    def _own_findings(self):
        """Return findings of the GUI's own."""
        found, wanted = [], self._edited.derived.protocol
        control, stage = self._connection.newest("control"), self._connection.newest("stage")
        if self._state.started_elsewhere() and control.protocol != wanted:
            found.append(Finding("", "controller", "runs " + control.protocol, wanted))
        if self._state.real() and self._connection.is_fresh("stage") and stage.speed != 1.0:
            found.append(Finding("", "speed", "{:g}".format(stage.speed), "1, as real robots go"))
        return found

    def _start(self):
        ending = self._processes.is_ending("control")  # it would answer, and go
        if self._connection.is_fresh("control") and self.fits() and not ending:
            self._connection.ask("start")
            return ""
        if self._state.real() and self._state.started_elsewhere():
            # Its remappings and limits are not known here: it is not to be replaced.
            return ErrorMessage(
                "not started: the controller that runs is for another team than this scenario's"
            )
        self.launch()
        return "controller started: {}".format(self._edited.scenario.control.protocol)

    def launch(self):
        """Start a controller of the GUI's own, in place of the one before."""
        self._connection.begin_run()
        # Real robots are those of the check, whose answer the start stands on.
        checked = self._preflight.real if self._state.real() else real_arguments(self._connection)
        arguments = ["--scenario", self.written()] + checked
        stage = self._connection.newest("stage")
        waits = stage.lockstep if stage is not None else self._stage.lockstep
        arguments.append(lockstep_option(waits and not self._state.real()))
        arguments.append("_autostart:=true")  # the user pressed start, and real robots are checked
        self._processes.start("control", "pioneer_control", *arguments)

    def written(self):
        """Write the scenario to a file for a program that is to start, and return its path."""
        return write_scenario(self._edited.scenario, self._processes.directory)

    def fits(self):
        """Return whether the controller that runs is for the team of the scenario."""
        control = self._connection.newest("control")
        size = 0 if control is None else len(control.command)
        return size == self._edited.scenario.n and not control.stale

    def stop(self, _=None):
        """Stop the controller that runs, or the check before a start; return a message, or ""."""
        if self._preflight.cancel():
            return "the controller does not start"
        self._connection.ask("stop")
        return ""

    def kill(self, _=None):
        """Kill the controller that was started here; return a message."""
        self._processes.kill("control")
        return "controller killed: its robots stop when their command timeout ends"

    def end(self):
        """End the controller that was started here."""
        self._processes.stop("control")

    def end_unfit(self):
        """End the controller that was started here if it is for another team."""
        if self._processes.is_running("control") and not self.fits():
            self.end()

    def follow_obstacles(self):
        """End a controller started here, which has the old obstacles; return a message, or ""."""
        if not self._processes.is_running("control"):
            return ""
        self.end()
        return "controller ended: start it with the new obstacles"

    def follow_protocol(self):
        """Let a controller started here, if one runs, follow the scenario; return a message, or ""."""
        if not self._processes.is_running("control"):
            return ""
        goes_on = self._state.drives() and not self._state.real()
        self.end()
        if goes_on:
            self.launch()
            return ""
        # Robots that stand are not set going by a choice, nor real ones without a check.
        return "controller ended: start it for the new protocol"
