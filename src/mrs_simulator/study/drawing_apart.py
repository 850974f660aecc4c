"""Figures drawn by processes of their own, while a run goes on and while it is judged.

They are forked before the run, so that matplotlib is loaded meanwhile; each draws every second figure.
"""

import contextlib
import os
import threading
from multiprocessing.connection import Pipe

from mrs_simulator.control.processes_apart import guarded

PROCESSES = 2
MOST_SENT = 1 << 26  # [bytes] of poses: they are copied to each process
ENDED = "the process that draws figures ended before it had drawn them"


class Drawing:
    """Draws figures in processes apart; :meth:`finish` waits for them."""

    def __init__(self):
        """Fork; to be called while this process has no other threads."""
        pairs = [Pipe() for _ in range(PROCESSES)]
        self._pipes, theirs = zip(*pairs)
        self._process = os.fork()
        if self._process == 0:
            for pipe in self._pipes:
                pipe.close()
            guarded(_draw_all, theirs)
        for pipe in theirs:
            pipe.close()
        self._awaited = []

    def takes(self, run):
        """Return whether ``run`` is small enough to be copied."""
        return run.pose.nbytes <= MOST_SENT

    def figures(self, run, *options):
        """Begin to draw ``study.figures.figures(run, *options)``."""
        scenario = run.scenario
        if scenario is not None:  # a protocol may be a class that cannot be sent
            control = scenario.control._replace(protocol="", parameters={})
            run = run._replace(scenario=scenario._replace(control=control))
        run = run._replace(meta={})
        for row, pipe in enumerate(self._pipes):
            self._ask(pipe, "figures", run, *options, slice(row, None, PROCESSES))

    def certificates(self, *options):
        """Begin to draw ``study.certificate_figure.save_certificates(*options)``."""
        self._ask(self._pipes[0], "certificates", *options)

    def _ask(self, pipe, *request):
        pipe.send(request)
        self._awaited.append(pipe)

    def finish(self):
        """Wait until all is drawn; raises what a drawing raised."""
        while self._awaited:
            try:
                error = self._awaited.pop(0).recv()
            except EOFError:
                raise RuntimeError(ENDED) from None
            if error is not None:
                raise error

    def close(self):
        """End the processes."""
        for pipe in self._pipes:
            pipe.close()
        os.waitpid(self._process, 0)


@contextlib.contextmanager
def drawing(formats):
    """Within it, a ``Drawing`` draws; None where processes of its own gain nothing or are not safe."""
    alone = threading.active_count() == 1  # a lock that another thread holds would stay locked
    if not (formats and alone and len(os.sched_getaffinity(0)) > 1):
        yield None
        return
    made = Drawing()
    try:
        yield made
    finally:
        made.close()


def _draw_all(pipes):
    """Load what draws, and serve the first of ``pipes``, the second one in a process forked then."""
    from mrs_simulator.study import certificate_figure, figures

    draw = {"figures": figures.figures, "certificates": certificate_figure.save_certificates}
    first, second = pipes
    twin = os.fork()
    if twin == 0:
        first.close()
        guarded(_serve, second, draw)
    second.close()
    _serve(first, draw)
    os.waitpid(twin, 0)  # it would be killed with this one


def _serve(pipe, draw):
    with contextlib.suppress(EOFError, OSError):
        while True:
            name, *options = pipe.recv()
            try:
                draw[name](*options)
            except Exception as error:
                pipe.send(error)
            else:
                pipe.send(None)
