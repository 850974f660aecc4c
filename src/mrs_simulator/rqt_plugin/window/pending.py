"""Edits that stage or controller have not applied yet: what they publish until then is old.  No Qt."""

import math
import time

TEAM_REST = 0.4  # [s] after the last change of the team until the stage is asked for it
GRAPH_REST = 5.0  # [s] after the controller's answer, beyond which its graph is shown anyway


class PendingTeam:
    """A team that was edited here, until the stage has it."""

    def __init__(self, study):
        self._study = study
        self._changed_at = None  # [s], when it was changed last; None: it was sent
        self._awaited = False  # whether the stage has not answered yet
        self._differs = False  # whether it has refused the team, or was not asked for it

    def changed(self):
        """Begin to wait for the end of the editing."""
        self._changed_at = time.monotonic()

    def is_settled(self):
        """Return whether the stage has applied the team edited here."""
        return self._changed_at is None and not self._awaited

    def is_taken(self):
        """Return whether a stage that runs is known to have the team edited here."""
        return self.is_settled() and not self._differs

    def send(self):
        """Send the team once editing rests, if there is a stage; return a message, or ""."""
        if self._changed_at is None or time.monotonic() - self._changed_at <= TEAM_REST:
            return ""
        return self.send_now()

    def send_now(self):
        """Send the team, if there is a stage; return a message, or ""."""
        if not self._study.connection.is_fresh("state"):
            self._changed_at = self._changed_at if self._is_to_come() else None
            return ""
        self._changed_at = None
        self._awaited = not self._study.state.drives()
        self._differs = not self._awaited
        return self._study.send_team()

    def _is_to_come(self):
        """Return whether a stage that was started before the last edit, without it, has yet to report."""
        processes = self._study.processes
        begun = time.monotonic() - processes.age("stage")
        return processes.is_running("stage") and begun < (self._changed_at or begun)

    def answered(self, success):
        """Note the stage's answer."""
        self._awaited, self._differs = False, not success


class PendingGraph:
    """A graph that was edited here, until the controller publishes it."""

    def __init__(self):
        self._wanted, self._answered_at = None, -math.inf  # (edges, directed); [s]

    def asked(self, edges, directed):
        """Note that the controller was asked for this graph."""
        self._wanted, self._answered_at = (sorted(edges), directed), math.inf

    def answered(self, success):
        """Note the controller's answer."""
        self._answered_at = time.monotonic() if success else -math.inf

    def is_old(self, edges, directed):
        """Return whether the controller published these ``edges`` before it applied the edited graph."""
        if self._wanted is None:
            return False
        taken_in = (sorted(edges), directed) == self._wanted
        if not taken_in and time.monotonic() < self._answered_at + GRAPH_REST:
            return True
        self._wanted = None
        return False
