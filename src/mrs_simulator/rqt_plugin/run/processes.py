"""Programs started by the GUI, which ends what it started and nothing else."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time

from mrs_simulator.core.program import PARENT

# How a program is ended: with each signal, the time [s] that it has until the next one.
ENDINGS = ((signal.SIGINT, 6.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 5.0))
# [s] more after the first signal, for programs that write results then.
PATIENCE = {"record": 60.0}
TAIL, LONGEST = 2000, 4  # [-] characters of output that are shown, and bytes of one at most


class Processes:
    """Named programs of this package, each at most once."""

    def __init__(self):
        _let_programs_be_interrupted()
        self.directory = tempfile.mkdtemp(prefix="mrs_simulator_gui_")
        self.running, self.jobs, self._begun = {}, {}, {}
        self._newest = {}  # the last process of each name
        self._closing = None  # the thread that ends them all

    def start(self, name, script, *arguments, package="mrs_simulator"):
        """Start ``rosrun package script``; one of that name that still runs is ended first."""
        self.launch(name, [*self.command(script, package), *map(str, arguments)])

    def command(self, script, package="mrs_simulator"):
        """Return the words that run a ``script`` of ``package``."""
        return ["rosrun", package, script]

    def launch(self, name, command):
        """Start ``command``, a list of words; one of that name that still runs is ended first."""
        self.stop(name)
        process = self._open(name, command)
        self.running[name] = self._newest[name] = process
        self._begun[name] = time.monotonic()

    def code(self, name):
        """Return the exit code of the last program called ``name``, None of one that runs or never did."""
        process = self._newest.get(name)
        return None if process is None else process.poll()

    def begin(self, name, script, *arguments):
        """Start a script of this package as ``run`` does, without waiting; return its ``Popen``."""
        command = [*self.command(script), *map(str, arguments)]
        self.jobs[name] = process = self._open(name, command)
        return process

    def run(self, name, script, *arguments, limit=None):
        """Run a script of this package to its end, from any thread; return ``(exit code, output)``."""
        process = self.begin(name, script, *arguments)
        try:
            code = process.wait(limit)
        except subprocess.TimeoutExpired:
            _end_all([process])
            code = process.wait()
        return code, self.output(name)

    def cancel(self, name):
        """End the script that ``run`` or ``begin`` has started as ``name``, if it still runs."""
        process = self.jobs.get(name)
        if process is not None:
            threading.Thread(target=_end_all, args=([process],)).start()

    def _open(self, name, command):
        with open(os.path.join(self.directory, name + ".log"), "wb") as log:
            # A group of its own: Ctrl-C in the terminal is for the GUI, which then ends these in order.
            return subprocess.Popen(
                command,
                stdout=log,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
                env=dict(os.environ, PYTHONUNBUFFERED="1", **{PARENT: str(os.getpid())}),
            )

    def is_running(self, name):
        """Return whether the program started as ``name`` still runs."""
        process = self.running.get(name)
        return process is not None and process.poll() is None

    def age(self, name):
        """Return the wall time [s] since the program called ``name`` was started, 0 without one."""
        return time.monotonic() - self._begun[name] if self.is_running(name) else 0.0

    def is_ending(self, name):
        """Return whether ``name`` was asked to end, and ``take_ended`` has not reported its end.

        Until then what it published counts as that of a program that runs.
        """
        return any(n.partition(" ")[0] == name and n != name for n in self.running)

    def is_gone(self, name):
        """Return whether ``name`` neither runs nor has ended without ``take_ended`` having reported it."""
        return all(n.partition(" ")[0] != name for n in self.running)

    def take_ended(self):
        """Return ``(name, exit code, output)`` of the programs that ended by themselves."""
        ended = [(n, p.returncode) for n, p in self.running.items() if p.poll() is not None]
        for name, _ in ended:
            del self.running[name]
        return [(name, code, self.output(name)) for name, code in ended]

    def output(self, name):
        """Return the end of what the program called ``name`` has printed."""
        path = os.path.join(self.directory, name + ".log")
        if not os.path.exists(path):
            return ""
        with open(path, "rb") as file:
            file.seek(max(0, os.path.getsize(path) - LONGEST * TAIL))  # however long the rest is
            return file.read().decode("utf-8", "replace")[-TAIL:]

    def stop(self, name):
        """End the program called ``name`` by the signals of ``ENDINGS`` in turn; return at once."""
        process = self.running.pop(name, None)
        if process is not None:
            self.running["{} {}".format(name, process.pid)] = process
            given = [process], PATIENCE.get(name, 0.0)
            threading.Thread(target=_end_all, args=given).start()

    def kill(self, name):
        """Kill the program ``name`` and its child processes at once."""
        process = self.running.get(name)
        if process is not None:
            _signal(process, signal.SIGKILL)

    def close(self):
        """End every program as :meth:`stop` does and return; :meth:`wait_closed` until they have ended.

        The interpreter waits for them too: a host that lives on need not.
        """
        started = {0.0: [*self.jobs.values()]}  # by how much longer they have
        for name, process in self.running.items():
            patience = PATIENCE.get(name.partition(" ")[0], 0.0)
            started.setdefault(patience, []).append(process)
        self.running.clear()
        self._closing = threading.Thread(target=self._end, args=(started,))
        self._closing.start()

    def wait_closed(self):
        """Wait until all programs have ended; remove the files written for them."""
        if self._closing is not None:
            self._closing.join()

    def _end(self, started):
        threads = [
            threading.Thread(target=_end_all, args=(processes, patience))
            for patience, processes in started.items()
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        shutil.rmtree(self.directory, ignore_errors=True)


def _let_programs_be_interrupted():
    """Ignore an interrupt by a handler, if at all: what a process starts inherits that it is ignored.

    A shell without job control has its background jobs ignore interrupts, by which programs here are ended.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        with contextlib.suppress(ValueError):  # not in the main thread
            signal.signal(signal.SIGINT, lambda *_: None)


def _end_all(processes, patience=0.0):
    """Send the signals of ``ENDINGS`` to those ``processes`` that have not ended before.

    ``patience`` [s]: how much longer they have after the first.
    """
    for place, (number, limit) in enumerate(ENDINGS):
        left = [process for process in processes if process.poll() is None]
        for process in left:
            _signal(process, number)
        end = time.monotonic() + limit + (0.0 if place else patience)
        for process in left:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(max(0.0, end - time.monotonic()))


def _signal(process, number):
    """Send a signal; a kill reaches the whole group, lest what the program has started lives on."""
    with contextlib.suppress(ProcessLookupError):
        if number == signal.SIGKILL:
            os.killpg(process.pid, number)
        elif process.poll() is None:
            process.send_signal(number)
