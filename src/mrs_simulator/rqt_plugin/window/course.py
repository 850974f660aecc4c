"""Shows how the claims of a run stand while it goes on, and its verdict when it is over."""

import numpy as np

from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.run.run_judge import RunJudge
from mrs_simulator.rqt_plugin.widgets.guard import guarded


@guarded
class Course:
    """Keeps the tab *Verdict* up to date; what the user saves or opens is shown there as before."""

    def __init__(self, panels, study, history, live, opened):
        """``opened``: the ``OpenedRun``, of which nothing is asked here."""
        self._panels, self._history, self._live = panels, history, live
        self._opened = opened
        self._judge, self._cleared = RunJudge(study, history), history.cleared
        panels.verdict.headline_changed.connect(self._on_headline)

    def _on_headline(self, text):
        """Say on the tab how the run stands, whichever tab is in front."""
        tabs, panel = self._panels.results_tabs, self._panels.verdict
        tabs.setTabText(tabs.indexOf(panel), "Verdict: " + text if text else "Verdict")

    def follow(self):
        """Ask about the run, and show what was answered."""
        if self._opened.run is not None:
            return
        history, panel = self._history, self._panels.verdict
        if history.cleared != self._cleared:  # another run, or none
            self._cleared = history.cleared
            panel.clear()
        ran = self._live.ran
        self._judge.follow(ran)
        said = self._judge.take()
        if said is None:
            return
        if said.error is not None:
            panel.show_trouble("no verdict yet: {}".format(reason(said.error)))
        elif said.verdict is not None:
            panel.set_verdict(said.verdict)
        # What was asked while a run lasted must not hide the verdict on it, which others may have shown.
        elif np.isfinite(history.moved) and not (ran and self._judge.is_over(ran[0])):
            duration = ran[0].duration if ran else said.time
            panel.set_standings(said.standings, said.time, duration)

    def close(self):
        """Ask for nothing more."""
        self._judge.close()
