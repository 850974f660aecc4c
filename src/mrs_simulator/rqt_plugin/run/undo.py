"""Which scenarios were edited, for undo and redo; without Qt."""

import time

MOST_UNDONE = 200  # [-] edits that can be undone
TOGETHER = 0.5  # [s] of wall time between changes of poses that are one edit, such as a drag


class Undo:
    """The scenarios before each edit, and the edits that were undone."""

    def __init__(self):
        self.clear()

    def clear(self):
        """Drop all of them."""
        self.done, self.undone, self._moved = [], [], None

    def note(self, before, after):
        """Note the edit of the scenario ``before`` into ``after``."""
        now, is_move = time.monotonic(), without_poses(before) == without_poses(after)
        goes_on = is_move and self._moved is not None and now - self._moved < TOGETHER
        if not (goes_on and self.done):
            self.done = [*self.done[1 - MOST_UNDONE :], before]
        self.undone, self._moved = [], now if is_move else None

    def exchange(self, source, target, now):
        """Move the last of ``source`` away; the scenario ``now`` goes to ``target``."""
        source.pop()
        target.append(now)
        self._moved = None


def without_poses(scenario):
    """Return what of ``scenario`` an edit changes besides poses, for comparing."""
    rest = scenario.kinds, scenario.obstacles, scenario.topology, scenario.control
    return (scenario.n, scenario.duration, *map(repr, rest))
