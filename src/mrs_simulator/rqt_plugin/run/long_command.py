"""A command of this package that takes long, in a process of its own; without Qt."""

from mrs_simulator.core.cores import cores


def jobs():
    """Return how many processes a command may have: all cores but one, which is the window's."""
    return max(1, cores() - 1)


class LongCommand:
    """At most one process at a time, which ends with the GUI."""

    def __init__(self, processes, name):
        """``processes``: the ``Processes``; ``name``: what the process is called there."""
        self._processes, self._name, self._process = processes, name, None
        self.is_cancelled = False

    @property
    def is_running(self):
        """Return whether a process was started whose end ``take`` has not returned."""
        return self._process is not None

    def start(self, script, *arguments):
        """Start ``script`` of this package; raises ``OSError``, and ``ValueError`` while one runs."""
        if self.is_running:
            raise ValueError("{} already runs".format(self._name))
        self.is_cancelled = False
        self._process = self._processes.begin(self._name, script, *arguments)

    def cancel(self):
        """End the process; return at once."""
        if self.is_running:
            self.is_cancelled = True
            self._processes.cancel(self._name)

    def take(self):
        """Return its exit code once it has ended, once; else None."""
        code = None if self._process is None else self._process.poll()
        if code is not None:
            self._process = None
        return code

    def output(self):
        """Return the end of what it has printed."""
        return self._processes.output(self._name)
