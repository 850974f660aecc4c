"""Runs the tests in several processes, which are forked when all tests have been collected.

Collecting, and loading what tests import, takes ten seconds: each process would take them again.
"""

import atexit
import collections
import gc
import itertools
import os
import shutil
import signal
import traceback
import warnings
from multiprocessing import Pipe
from multiprocessing.connection import wait
from multiprocessing.reduction import ForkingPickler

import pytest


class Workers:
    """The plugin, in the process that reports.

    ``count``: how many processes run tests; ``begin_worker`` is called in each; ``waits(item)``: whether a
    test waits for processes of its own.  Such tests come first: others keep the cores busy to the end.
    """

    def __init__(self, count, begin_worker, waits):
        self._count, self._begin_worker, self._waits = count, begin_worker, waits

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session):
        """Let workers run the tests, instead of this process."""
        if session.testsfailed or session.config.option.collectonly or not session.items:
            return None
        session.config._tmp_path_factory.getbasetemp()  # one for all
        gc.collect()
        gc.freeze()  # or each worker would copy what it looks at
        run = _Run(session, self._begin_worker)
        try:
            run.begin(min(self._count, len(session.items)), self._waits)
            run.follow()
        finally:
            run.end()
        return True


class _Run:
    """Which worker is to run which tests, and what they report."""

    def __init__(self, session, begin_worker):
        self._session, self._begin_worker = session, begin_worker
        self._left = {}  # of each worker's link, the tests it is yet to be given
        self._given = {}  # likewise, those that it has
        self._pids = {}

    def begin(self, count, waits):
        """Start ``count`` workers, each with as many neighbouring tests that wait, and others."""
        kinds = [], []
        for test, item in enumerate(self._session.items):
            kinds[not waits(item)].append(test)
        for worker in range(count):
            parts = (
                tests[len(tests) * worker // count : len(tests) * (worker + 1) // count]
                for tests in kinds
            )
            self._fork(collections.deque(itertools.chain(*parts)))

    def _fork(self, tests):
        link, other = Pipe()
        pid = os.fork()
        if pid == 0:
            for each in (link, *self._pids):
                each.close()
            atexit.unregister(shutil.rmtree)  # of what the others go on using
            self._begin_worker()
            _Worker(self._session, other).run()
        other.close()
        self._pids[link] = pid
        self._left[link], self._given[link] = tests, collections.deque()

    def follow(self):
        """Give out tests and pass on what is reported, until all have run."""
        while self._pids:
            for link in wait(list(self._pids)):
                try:
                    what, told = link.recv()
                except (EOFError, ConnectionError):
                    self._mourn(link)
                    continue
                getattr(self, "_on_" + what)(link, told)
                if self._session.shouldfail:
                    raise self._session.Failed(self._session.shouldfail)
                if self._session.shouldstop:
                    raise self._session.Interrupted(self._session.shouldstop)

    def _on_next(self, link, _):
        if not self._left[link]:
            self._left[link] = self._taken_over()
        test = self._left[link].popleft() if self._left[link] else None
        if test is not None:
            self._given[link].append(test)
        link.send(test)

    def _taken_over(self):
        """Return the later half of the tests that the worker with the most has not been given."""
        most = max(self._left.values(), key=len)
        taken = [most.pop() for _ in range((len(most) + 1) // 2)]
        return collections.deque(reversed(taken))

    def _on_report(self, link, data):
        config = self._session.config
        report = config.hook.pytest_report_from_serializable(config=config, data=data)
        config.hook.pytest_runtest_logreport(report=report)

    def _on_started(self, link, told):
        self._session.config.hook.pytest_runtest_logstart(nodeid=told[0], location=told[1])

    def _on_finished(self, link, told):
        self._given[link].popleft()
        self._session.config.hook.pytest_runtest_logfinish(nodeid=told[0], location=told[1])

    def _on_warning(self, link, told):
        self._session.config.hook.pytest_warning_recorded.call_historic(kwargs=told)

    def _on_over(self, link, _=None):
        """Forget a worker; return how its process ended."""
        link.close()
        del self._left[link], self._given[link]
        return os.waitpid(self._pids.pop(link), 0)[1]

    def _mourn(self, link):
        """Report the test in which a worker has ended; another one runs what it was to run."""
        given, left = self._given[link], self._left[link]
        status = self._on_over(link)
        if given:
            item = self._session.items[given.popleft()]
            text = "the process of this test ended with status {:#x}".format(status)
            report = pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")
            item.config.hook.pytest_runtest_logreport(report=report)
        if given or left:
            self._fork(collections.deque([*given, *left]))

    def end(self):
        """End the workers that are left, and what their tests have begun."""
        for pid in self._pids.values():
            os.kill(pid, signal.SIGINT)
        for link in list(self._pids):
            self._on_over(link)


class _Worker:
    """The plugin in a process that runs tests: it sends what it would print."""

    def __init__(self, session, link):
        self._session, self._link, self._is_begun = session, link, False

    def run(self):
        """Run what is given, until nothing is, and end the process."""
        code = 1
        try:
            self._begin()
            self._run_all()
            code = 0
        except KeyboardInterrupt:
            self._session._setupstate.teardown_exact(None)
        except BaseException:  # which would go on as another reporting process
            traceback.print_exc()
        finally:
            try:
                atexit._run_exitfuncs()
                if code == 0:
                    self._link.send(("over", None))
            finally:
                os._exit(code)  # Qt's objects must not be taken down in any order

    def _begin(self):
        plugins = self._session.config.pluginmanager
        capture = plugins.getplugin("capturemanager")
        capture.stop_global_capturing()  # whose files are the reporting process's
        capture.start_global_capturing()
        capture.suspend_global_capture()
        plugins.getplugin("terminalreporter")._tw._file = open(os.devnull, "w")
        plugins.register(self)
        self._is_begun = True

    def _run_all(self):
        item = self._next()
        while item is not None:
            following = self._next()  # fixtures that both have are kept
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            item = following

    def _next(self):
        self._link.send(("next", None))
        test = self._link.recv()
        return None if test is None else self._session.items[test]

    def pytest_runtest_logstart(self, nodeid, location):
        """Send that a test begins."""
        self._link.send(("started", (nodeid, location)))

    def pytest_runtest_logreport(self, report):
        """Send what came of a part of a test."""
        config = self._session.config
        data = config.hook.pytest_report_to_serializable(config=config, report=report)
        self._link.send(("report", data))

    def pytest_runtest_logfinish(self, nodeid, location):
        """Send that a test is over."""
        self._link.send(("finished", (nodeid, location)))

    def pytest_warning_recorded(self, warning_message, when, nodeid, location):
        """Send a warning, as text where it cannot be sent as it is."""
        if not self._is_begun:  # it is told of those that were recorded before
            return
        told = dict(warning_message=warning_message, when=when, nodeid=nodeid, location=location)
        try:
            ForkingPickler.dumps(told)
        except Exception:  # of whoever's class of warning
            text = UserWarning(str(warning_message.message))
            where = warning_message.filename, warning_message.lineno
            told["warning_message"] = warnings.WarningMessage(text, UserWarning, *where)
        self._link.send(("warning", told))
