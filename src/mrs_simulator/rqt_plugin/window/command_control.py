"""What sweep and searches of the window have in common: a command in the background, and its end."""

from mrs_simulator.rqt_plugin.run.long_command import LongCommand
from mrs_simulator.rqt_plugin.widgets.guard import guarded


@guarded
class CommandControl:
    """A command of the scenario as it is edited when it starts, one at a time.

    A subclass starts ``_process``, offers by ``_offer`` what of a scenario there is to vary, and shows by
    ``_end(code)`` how the process has ended.
    """

    def __init__(self, panels, study, panel, name):
        """``panel``: asks for the command; ``name``: what its process is called among the programs."""
        self._panels, self._study, self._panel = panels, study, panel
        self._process = LongCommand(study.processes, name)
        self._offered = None  # the scenario of which there was an offer
        panel.cancel_asked.connect(self._on_cancel)

    def _on_cancel(self):
        self._process.cancel()
        self._panel.cancel.setEnabled(False)

    def _follow_process(self):
        """Offer what a new scenario has, where that is seen; show the end of the process, once."""
        if self._study.scenario is not self._offered and self._panel.isVisible():
            self._offered = self._study.scenario
            self._offer()
        code = self._process.take()
        if code is not None:
            self._panel.set_running(False)
            self._end(code)
