"""Marks what is shown of a run that is over as such, once the scenario has been edited since."""

REMARK = "last run, before your edits"
ANOTHER = "another run is shown"


class PastRun:
    """Says in verdict, curves and status line that they are of the last run, where edits came after it."""

    def __init__(self, panels, study, history, opened):
        """``opened``: the ``OpenedRun``, to which edits do not matter."""
        self._panels, self._study, self._history = panels, study, history
        self._opened = opened
        study.state.is_over = self.is_over
        self._over, self._scenario = None, None  # which run is over, and what was edited by its end
        self.remark = ""  # what the status line adds to the time

    def follow(self):
        """Look whether the scenario was edited since the run was over."""
        run = self._history.cleared if self.is_over() else None
        if run != self._over:
            self._over, self._scenario = run, self._study.scenario
        may_be = run is not None and self._opened.run is None
        edited = may_be and not _is_same(self._scenario, self._study.scenario)
        remark = REMARK if edited else ""
        self.remark = remark if self._opened.run is None else ANOTHER
        self._panels.verdict.mark(remark)
        self._panels.curves.mark(remark)

    def is_over(self):
        """Return whether there is a run that has ended, and does not go on."""
        history, study = self._history, self._study
        if history.begun is None:
            return False
        if not study.is_controlled():
            return True
        stage, ran = study.connection.newest("stage"), history.scenario or study.scenario
        paused = stage is not None and stage.paused
        return paused and history.lasts(ran.duration)


def _is_same(before, after):
    """Return whether two scenarios hold the very same, at whatever speed."""
    names = (name for name in before._fields if name != "speed")
    return all(getattr(before, name) is getattr(after, name) for name in names)
