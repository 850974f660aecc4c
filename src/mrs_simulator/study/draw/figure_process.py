"""Figures drawn by processes of their own, while a run goes on and while it is judged.

They are forked before the world is loaded, by the command even before numpy is, so that matplotlib is
loaded meanwhile, and see the run's samples in the recorder's memory: none are copied.  Each draws one
figure after the other, whichever is next.
"""

import contextlib
import gc
import mmap
import os
import signal
import sys
import threading
from collections import deque
from importlib.util import find_spec
from multiprocessing.connection import Pipe, wait

from mrs_simulator.control.worker_process import guarded
from mrs_simulator.core.cores import cores
from mrs_simulator.record import MOST_KEPT

PROCESSES = 2
# Figures of a run in space, by their places, those that take longest first, so that both processes end
# at about the same time.  What a run does not have takes no time.
TURNS = (3, 5, 1, 2, 0, 4)
ENDED = "the process that draws figures ended before it had drawn them"


class Drawing:
    """Draws figures in processes apart; :meth:`finish` waits for them."""

    def __init__(self):
        """Begin to load what draws; while this process has one thread."""
        self.memory = mmap.mmap(-1, MOST_KEPT)  # where a recorder is to keep the samples
        self._recorder, self._is_drawing = None, False
        self._waiting, self._busy = deque(), []
        pairs = [Pipe() for _ in range(PROCESSES)]
        self._pipes, theirs = zip(*pairs)
        self._free = list(self._pipes)
        self._process = os.fork()
        if self._process == 0:
            for pipe in self._pipes:
                pipe.close()
            guarded(_draw_all, theirs, _drawings(self.memory))
        for pipe in theirs:
            pipe.close()

    def warm_up(self, formats):
        """Load what writes ``formats``, before anything is drawn."""
        self._send(self._pipes[0], *formats)

    def begin(self, recorder):
        """Tell of a run that ``recorder`` keeps in :attr:`memory`."""
        self._recorder = recorder

    @property
    def is_able(self):
        """Return whether the recorder holds the run that is to be drawn, in :attr:`memory`."""
        recorder = self._recorder
        return recorder is not None and recorder.kept.is_shared and recorder.has_kept_all

    def figures(self, run, *options):
        """Begin to draw ``study.figures.figures(run, *options)``, of the recorder's run."""
        dimension = run.hand.shape[2]
        description = self._recorder.kept.given, run.time, run.collisions, run.scenario, dimension
        self._is_drawing = True
        for pipe in self._pipes:
            self._send(pipe, "run", description, options)
        self._waiting.extend(("figures", row) for row in TURNS)
        self._hand_out()

    def certificates(self, *options):
        """Begin to draw ``study.certificate_figure.save_certificates(*options)``."""
        self._waiting.append(("certificates", *options))
        self._hand_out()

    def _hand_out(self):
        while self._free and self._waiting:
            self._busy.append(self._free.pop(0))
            self._send(self._busy[-1], *self._waiting.popleft())

    def _send(self, pipe, *request):
        with contextlib.suppress(OSError):  # ``finish`` finds its other end closed
            pipe.send(request)

    def finish(self):
        """Wait until all is drawn.

        Raises what a drawing raised, and ``ChildProcessError`` where a process ended before.
        """
        while self._busy:
            for pipe in wait(self._busy):
                try:
                    error = pipe.recv()
                except (EOFError, OSError):
                    raise ChildProcessError(ENDED) from None
                if error is not None:
                    raise error
                self._busy.remove(pipe)
                self._free.append(pipe)
            self._hand_out()

    def close(self):
        """End the processes."""
        for pipe in self._pipes:
            pipe.close()
        if not self._is_drawing:  # it may still be loading
            os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        self.memory = None


_begun = []  # the ``Drawing`` that was begun ahead


@contextlib.contextmanager
def ahead(arguments):
    """Within it, the first :func:`drawing` goes on with a ``Drawing`` that begins now.

    ``arguments``: those of the command ``experiment``, by some of which it draws no run.
    """
    others = {"--sweep", "--help", "-h"}
    if _pays() and not others.intersection(each.partition("=")[0] for each in arguments):
        _begun.append(Drawing())
    try:
        yield
    finally:
        while _begun:
            _begun.pop().close()


@contextlib.contextmanager
def drawing(formats):
    """Within it, a ``Drawing`` draws; None where processes of its own gain nothing or are not safe."""
    if not formats or not (_begun or _pays()):
        yield None
        return
    made = _begun.pop() if _begun else Drawing()
    try:
        made.warm_up(formats)
        yield made
    finally:
        made.close()


def _pays():
    """Return whether processes of their own are of use, and may be forked."""
    if not sys.platform.startswith("linux") or cores() == 1 or find_spec("matplotlib") is None:
        return False
    return threading.active_count() == 1  # a lock that another thread holds would stay locked


def _drawings(memory):
    """Return the functions that serve requests, by name, about the run whose samples are in ``memory``."""
    given = []

    def begin(description, options):
        from mrs_simulator.record.recording import Kept

        given_kept, time, collisions, scenario, dimension = description
        run = Kept(*given_kept, memory).run(time, scenario, (collisions, {}))
        given[:] = (run.in_space(dimension), *options)

    def draw(row):
        from mrs_simulator.study.draw.figures import figures

        figures(*given, slice(row, row + 1))

    def certificates(*options):
        from mrs_simulator.study.draw.certificate_figure import save_certificates

        save_certificates(*options)

    return {"run": begin, "figures": draw, "certificates": certificates}


def _draw_all(pipes, drawings):
    """Load what draws runs, and serve the first of ``pipes``, the second one in a process forked then."""
    gc.disable()  # it would look through all of matplotlib again and again, a fourth of the time

    from matplotlib import artist

    artist.kwdoc = lambda _: ""  # texts of help, a third of what matplotlib takes to load

    import mrs_simulator.record.recording  # noqa: F401
    from mrs_simulator.study.draw.figures import warm_up

    first, second = pipes
    with contextlib.suppress(EOFError):
        warm_up(first.recv())
    twin = os.fork()
    if twin == 0:
        first.close()
        guarded(_serve, second, drawings)
    second.close()
    _serve(first, drawings)
    os.waitpid(twin, 0)  # it would be killed with this one, and its time be counted nowhere


def _serve(pipe, drawings):
    with contextlib.suppress(EOFError, OSError):
        while True:
            name, *options = pipe.recv()
            error = None
            try:
                drawings[name](*options)
            except Exception as raised:
                error = raised
            if name != "run" or error:
                pipe.send(error)
