"""What the law of the window's own run said at a moment that has passed: its graph and targets."""

from mrs_simulator.record.run_changes import changed_by, read_changes
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker

REST = 0.05  # [s] that a moment is shown until the law is asked


class PastLaw:
    """Asks the law in the background, and shows on the map what it answers."""

    def __init__(self, panels, study, history, live):
        self._panels, self._study = panels, study
        self._history, self._live = history, live
        self._worker, self._asked, self._changes = DebouncedWorker(REST), None, ((), ())

    def ask(self, row):
        """Ask for the moment of the sample ``row``, unless that was asked for last."""
        key = self._history.cleared, float(self._history.time[row])
        if key == self._asked or self._live.ran is None:
            return
        self._asked, (ran, facts) = key, self._live.ran
        if "unknown_law" in facts:
            return
        passed = self._history.time[row] - self._history.begun
        changes = [each for each in self._read(facts) if each.time <= passed]
        pose, ask = self._history.pose[row : row + 1].copy(), self._study.edited.ask_apart

        def work():
            now = changed_by(ran, changes)
            return ask("facts", now).topology, ask("targets_at", now, pose)

        self._worker.ask(work)

    def _read(self, facts):
        """Return the ``Change``s in ``facts``, which are read once."""
        plain = facts.get("changes", [])
        if plain is not self._changes[0]:
            self._changes = plain, read_changes(plain)
        return self._changes[1]

    def follow(self):
        """Show what the law has answered by now."""
        found = self._worker.take()
        if found is None or self._asked is None or self._asked[0] != self._history.cleared:
            return
        answer, error = found
        if error is not None:
            self._panels.say(ErrorMessage("no targets: {}".format(reason(error))))
            return
        graph, targets = answer
        self._panels.map.show_topology(graph.edges, graph.directed)
        self._panels.map.show_targets(None if targets is None else targets[0])

    def forget(self):
        """Ask for nothing more."""
        self._asked = None
        self._worker.ask(None)
