"""Workers of a sweep: processes of this machine, or a Dask cluster."""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, ProcessPoolExecutor, wait

from mrs_simulator.core.cores import cores
from mrs_simulator.core.writing import Limited

CONNECT_LIMIT = 10.0  # [s] of wall time to reach a Dask scheduler
RENEWED = 1000  # [-] tasks after which processes are made anew
POLL = 5.0  # [s] of wall time between two looks at the cluster's workers
WORKER_LIMIT = 60.0  # [s] of wall time for which a cluster may be without workers


class SweepError(ValueError):
    """A sweep that cannot be made; the message names the axis, or the scheduler."""

    page = "docs/sweeps.md#sweeps"


def failed(reason):
    """Return the verdict on a run that did not come to an end."""
    return {"outcome": "failed", "passed": False, "reason": "", "ended": reason, "checks": []}


def on_cores(run, tasks, jobs):
    """``run(*task)`` for each of ``tasks``, as ``Cores.run``, in processes that end with the last."""
    with contextlib.closing(Cores(jobs)) as cores:
        yield from cores.run(run, tasks)


class Cores:
    """Processes of this machine that run batches of tasks; new ones after ``RENEWED`` tasks.

    So that what laws leave behind in them stays bounded.
    """

    def __init__(self, jobs, printed=None):
        """``jobs``: processes (default: those that this one may use).

        ``printed``: a shared ``multiprocessing.Value``, how many characters of what runs print are still
        shown; None for all.
        """
        self._jobs, self._printed = jobs or cores(), printed
        self._pool, self._done = None, 0

    def run(self, run, tasks):
        """``run(*task)`` for each of ``tasks``; yield ``(row, verdict)`` as they end."""
        waiting = deque(range(len(tasks)))
        while waiting:
            # A process that dies takes the whole pool with it: who did it shows when each runs alone.
            for row in (yield from self._run_many(run, tasks, waiting, self._jobs)):
                with contextlib.closing(Cores(1, self._printed)) as alone:
                    if (yield from alone._run_many(run, tasks, deque([row]), 1)):
                        yield row, failed("its process died")

    def _run_many(self, run, tasks, waiting, jobs):
        """Run the tasks in the rows ``waiting``, which are taken from it; yield ``(row, verdict)``.

        Returns the rows that ran when the pool broke, if it did.  No more are handed in than can run.
        Where no more are wanted, as after an interruption, processes are killed: none is waited for.
        """
        running = {}
        try:
            while waiting or running:
                while waiting and len(running) < jobs:
                    running[self._processes().submit(run, *tasks[waiting[0]])] = waiting[0]
                    waiting.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    verdict = future.result()
                    self._done += 1
                    yield running.pop(future), verdict
        except BrokenExecutor:
            self.close()
        except BaseException:
            self._kill()
            raise
        return sorted(running.values())

    def _processes(self):
        if self._pool is not None and self._done >= RENEWED:
            self.close()
        if self._pool is None:
            options = dict(initializer=_begin, initargs=(self._printed,))
            self._pool, self._done = ProcessPoolExecutor(self._jobs, **options), 0
        return self._pool

    def _kill(self):
        # Of 3.14 on the pool has a method for it.
        for process in list((self._pool._processes or {}).values()) if self._pool else ():
            process.kill()
        self.close()

    def close(self):
        """End the processes, after what they are at."""
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None


def _begin(printed):
    """Begin a process: a terminal's interruption, which all get, is heeded by the one that waits alone."""
    # Raised in a process that holds a lock of the pool's queues, it would leave the others waiting for it.
    signal.signal(signal.SIGINT, _wait_on)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if printed is not None:
        sys.stdout = Limited(printed)


def _end_with_parent():
    """End this process, whatever it is at, once the one that began it was killed."""
    multiprocessing.parent_process().join()
    os._exit(1)


def _wait_on(_number, _frame):
    """Go on: what runs in this process is killed by the one that began it."""


def on_cluster(run, tasks, scheduler):
    """The same on the Dask cluster at ``scheduler``; ``SweepError`` if it cannot be used."""
    try:
        from dask import distributed
    except ImportError:
        raise SweepError("--scheduler: wanted the Python package distributed") from None
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_LIMIT)
    except (OSError, ValueError, TimeoutError) as error:
        raise SweepError("--scheduler {}: {}".format(scheduler, error)) from None
    with client:
        killed = []
        for row, future in _submitted(
            distributed, client, run, tasks, range(len(tasks)), scheduler
        ):
            if isinstance(future.exception(), distributed.KilledWorker):
                killed.append(row)  # perhaps by another run that was on the same worker
            else:
                yield row, _verdict_of(future)
        for row in killed:
            for _, future in _submitted(distributed, client, run, tasks, [row], scheduler):
                yield row, _verdict_of(future)


def _submitted(distributed, client, run, tasks, rows, scheduler):
    """Run the tasks in ``rows`` on the cluster; yield ``(row, future)`` as they end."""
    futures = {client.submit(run, *tasks[row], pure=False): row for row in rows}
    left = set(futures)
    while left:
        ended = _ended(distributed, client, left, scheduler)
        left -= ended
        for future in ended:
            yield futures[future], future


def _verdict_of(future):
    error = future.exception()
    return future.result() if error is None else failed("its process died: {}".format(error))


def _ended(distributed, client, futures, scheduler):
    """Return those of ``futures`` that have ended, at least one; ``SweepError`` without workers."""
    alone = 0.0
    while True:
        try:
            first = distributed.wait(futures, POLL, return_when="FIRST_COMPLETED")
            return set(first.done)
        except distributed.TimeoutError:
            alone = 0.0 if client.scheduler_info()["workers"] else alone + POLL
        if alone >= WORKER_LIMIT:
            text = "--scheduler {}: no worker for {:g} s; what has ended is kept"
            raise SweepError(text.format(scheduler, alone))
