"""The searches in the window: run ``break``, ``assure`` and ``margins``, and show what they find."""

from mrs_simulator.core.fields import counted
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.run.long_command import jobs
from mrs_simulator.rqt_plugin.run.study_run import last_lines
from mrs_simulator.rqt_plugin.search.inputs import (
    read_share,
    suggested,
    with_search,
    without_search,
)
from mrs_simulator.rqt_plugin.search.results import ASSURE, BREAK, MARGINS, result_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.window.command_control import CommandControl
from mrs_simulator.study.results.report import write_scenario
from mrs_simulator.study.search.assurance import clean_runs
from mrs_simulator.study.search.break_command import progress_in

GOOD = {BREAK: (0, 1), ASSURE: (0, 1), MARGINS: (0,)}  # exit codes
WORDS = {BREAK: "Searching", ASSURE: "Drawing", MARGINS: "Measuring margins"}
NOTHING = "nothing was to vary: above is what the scenario offers. Edit it, or press Assure again"
SHRINKING = "runs; it is shrunk"  # printed once a counterexample was found


@guarded
class SearchControl(CommandControl):
    """One search at a time, of the scenario as it is edited when it starts."""

    def __init__(self, panels, study, opened, replay, files, shelf):
        """``opened``: the ``OpenedRun``; ``replay``: the ``Replay``; ``files``: the ``ScenarioFiles``.

        ``shelf``: the ``ShelfControl``, which lists and shows what was found.
        """
        super().__init__(panels, study, panels.search, "search")
        self._opened, self._replay, self._files, self._shelf = opened, replay, files, shelf
        self._command, self._most, self._nearest = "", None, ""
        self._source = None  # the file and its key ``search`` of which there was an offer
        self.directory, self._given, self.result = "", "", None
        self._goes_to = None  # a run, and the moment [s] to be shown of it
        panel = panels.search
        panel.asked.connect(self._on_asked)
        panel.run_asked.connect(self._on_run)
        panel.scenario_asked.connect(self._on_scenario)

    # Starting ------------------------------------------------------------------------------------

    def _on_asked(self, command):
        panel, errors, words = self._panel, {}, []
        panel.runs.interpretText()
        scenario, self._most = without_search(self._study.scenario), None
        vary = panel.vary.toPlainText()
        if command == ASSURE and not vary.strip():
            panel.suggest(suggested(self._study.scenario), anew=True)
            errors["vary"] = NOTHING
        elif command != MARGINS and vary.strip():
            try:
                names = getattr(self._study.edited.derived, "values", ())
                scenario = with_search(scenario, vary, names)
            except ValueError as error:
                errors["vary"] = reason(error)
        if command == BREAK:
            self._most = panel.runs.value()
            words = ["--runs", self._most]
        elif command == ASSURE:
            words = self._assurance(errors)
        panel.show_errors(errors)
        if errors or self._process.is_running:
            return
        try:
            self.directory = self._study.files.new_folder(command)
            path = write_scenario(scenario, self.directory)
            formats = (
                [] if command == ASSURE else ["--formats", "png" if command == MARGINS else ""]
            )
            options = "--out", self.directory, "--jobs", jobs(), *formats
            self._process.start(command, path, *words, *options)
            self._given = path
        except OSError as error:
            panel.title.say("not started: {}".format(reason(error)), "error")
            return
        self._command, self._nearest, self.result = command, "", None
        panel.show_result(None)
        panel.set_running(True)
        self._show_progress()

    def _assurance(self, errors):
        """Return the words of ``assure``; note in ``errors`` what is wrong with them."""
        panel, shares = self._panel, []
        for name, field in (("At least", panel.share), ("Confidence", panel.confidence)):
            try:
                shares.append(read_share(field.text().strip()))
            except ValueError as error:
                errors[name] = str(error)
        if errors:
            return []
        self._most = clean_runs(*shares)
        return ["--at-least", shares[0], "--confidence", shares[1]]

    # Following -----------------------------------------------------------------------------------

    def follow(self):
        """Show how far the search is, what it has found, and what there is to vary."""
        self._follow_process()
        if self._process.is_running:
            self._show_progress()
        run = self._opened.run
        if self._goes_to is not None and run is not None and run.path == self._goes_to[0]:
            self._replay.cursor.go(float(run.history.time[0]) + self._goes_to[1])
            self._goes_to = None

    def _offer(self):
        source = self._offered.path, self._offered.search
        self._panel.suggest(suggested(self._offered), anew=source != self._source)
        self._source = source

    def _show_progress(self):
        printed = self._process.output()
        runs, nearest = progress_in(printed)
        self._nearest = nearest or self._nearest
        parts = [WORDS[self._command]]
        parts += [counted(runs, "run")] if runs else []
        parts += ["nearest: " + self._nearest] if self._nearest else []
        parts += ["it is shrunk"] if SHRINKING in printed else []
        self._panel.show_progress(", ".join(parts), runs or 0, self._most)

    def _end(self, code):
        """Show what a process that has ended with ``code`` has found."""
        panel, printed = self._panel, self._process.output()
        if self._process.is_cancelled:
            folder = self._study.files.short_path(self.directory)
            panel.title.say("cancelled; its runs are in {}".format(folder), "aside")
            return
        if code not in GOOD[self._command]:
            why = last_lines(printed).rpartition("{}: ".format(self._command))[2]
            panel.title.say("not done: {}".format(why.replace(self._given + ": ", "")), "error")
            return
        try:
            found = result_of(self._command, self.directory, printed)
        except (OSError, ValueError) as error:
            self._panels.say(ErrorMessage("{}: {}".format(self._command, reason(error))))
            return
        folder = self._study.files.short_path(self.directory)
        self.result = found._replace(text=found.text.replace(self.directory, folder))
        panel.title.say("in {}".format(folder), "aside")
        panel.show_result(self.result)
        said = folder if self._command == MARGINS else self.result.text.partition("\n")[0]
        self._panels.say("{}: {}".format(self._command, said))

    def _on_run(self):
        self._goes_to = self.result.run, self.result.moment
        self._shelf.open(self.result.run)

    def _on_scenario(self):
        self._files.open_unless_controlled(self.result.scenario)
