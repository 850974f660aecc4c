"""A protocol's control in another process, so that the node that drives robots waits for no law."""

import inspect
import re
import sys
import threading
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.control.user_code import CallFailed, InPlace, TimedOut, Worker, WorkerThread
from mrs_simulator.control.worker_process import ForkedProcess
from mrs_simulator.core.compiling import in_time
from mrs_simulator.protocols.making import make_control
from mrs_simulator.verdict.user_values import texts_of

KILLED = "the processes that run laws were killed ({}): end this node and start it anew"
OWN_ROS = re.compile(r"\b(rospy|tf2?_ros|roslib)\b")


class State(NamedTuple):
    """What others may know of a control."""

    parameters: dict  # in force, by name
    topology: Any  # the ``core.graphs.Topology`` in force
    hand_length: float  # [m]
    deadlock: tuple = ()  # (number, since [s]) of robots that the safety filter holds still
    sensors: tuple = ()  # names of those that it asks of every robot


class LawService:
    """Makes the control of a scenario's robots and serves requests ``(method, arguments...)``."""

    def __init__(self, protocol):
        """``protocol``: a ``PioneerControl`` subclass."""
        self._protocol, self._control = protocol, None

    def __call__(self, method, *arguments):
        """Return what the method returns and the ``State`` after it."""
        value = getattr(self, method)(*arguments)
        control = self._control
        return value, State(
            dict(control.parameters),
            control.topology,
            float(control.l),
            control.safety_filter.deadlock,
            tuple(control.SENSORS),
        )

    def make(self, scenario):
        """Make the control of the robots of ``scenario``."""
        self._control = make_control(scenario, self._protocol)

    def begin(self, pose, begun=0.0):
        """Begin anew from ``pose`` (n, 3), with heights (n, 4); return theory's warnings, texts.

        ``begun`` [s]: the time of the scene then.
        """
        self._control.safety_filter.begin_scene(begun)
        self._control.start()
        return [*self._control.foreseen, *texts_of(self._control.warnings(pose), "warnings()")]

    def commands(self, pose, time, readings=None, joints=None):
        """Return the commands (n, 2) [m/s, rad/s] at ``pose`` (n, 3) and ``time`` [s].

        ``readings``: the newest of the robots' sensors, ``{row: {name: reading}}``; ``joints`` (n, k)
        [rad] of robots with arms.
        """
        more = {} if readings is None else {"readings": readings}
        more = more if joints is None else dict(more, joints=joints)
        with in_time():
            return self._control.commands(pose, time, **more)

    def targets(self, pose):
        """Return where, seen from above, the hand points are wanted, (n, 2) [m], or None."""
        targets = self._control.targets(self._control.points(pose))
        if targets is None:
            return None
        targets, wanted = np.asarray(targets, dtype=float), (len(pose), self._control.dimension)
        if targets.shape != wanted:
            raise ValueError("targets returned shape {}, wanted {}".format(targets.shape, wanted))
        return targets

    def set_parameters(self, given):
        """Set the parameters ``given`` by name, the others to their defaults."""
        self._control.set_parameters(given)

    def set_topology(self, topology):
        """Replace the interaction graph."""
        self._control.set_topology(topology)


class Law:
    """The control of a scenario's robots, run in another process; no call waits long.

    Its calls raise ``CallFailed`` where users' code raises, and ``TimedOut`` where it does not end
    within its limit.  It is then ``lost`` until it is made again, by ``remake`` or with an edit.
    """

    def __init__(self, scenario, protocol, limit, apart):
        """``protocol``: a ``PioneerControl`` subclass; ``limit`` [s] for all but commands.

        ``apart()``: returns what runs its requests, of ``control.user_code``.
        Raises ``ValueError`` for impossible parameters.
        """
        self.name, self.PARAMETERS = protocol.__name__, protocol.PARAMETERS
        self.numbers = tuple(range(1, scenario.n + 1))
        self._scenario, self._limit = scenario, limit
        self._apart, self._remaking = apart, threading.Lock()
        self.state = None  # the ``State`` after its last call
        self.other_topology = None  # set in place of the scenario's
        self.known_targets = None  # the last that the law returned
        self.remake()

    def remake(self):
        """Make it anew, with the parameters and the topology that were in force."""
        with self._remaking:
            self._remake()

    def _remake(self):
        try:
            self._worker, before = Worker(self._apart()), self.state
        except (EOFError, OSError) as error:
            raise ValueError(KILLED.format(error)) from error
        self._given = None  # the readings that it has
        try:
            self._call("make", self._scenario)
            if before is not None:
                self._call("set_parameters", before.parameters)
            if self.other_topology is not None:
                self._call("set_topology", self.other_topology)
        except CallFailed as error:
            self._worker.give_up()
            raise ValueError(str(error)) from error

    @property
    def lost(self):
        """Return whether it was given up."""
        return self._worker.given_up

    def end(self):
        """End it; it is ``lost``."""
        self._worker.give_up()

    @property
    def parameters(self):
        """Return the parameters in force by name."""
        return dict(self.state.parameters)

    def begin(self, pose, meanwhile=None, begun=0.0):
        """Begin anew from ``pose`` (n, 3) at ``begun`` [s] of the scene; return theory's warnings."""
        return self._call("begin", pose, begun, meanwhile=meanwhile)

    def commands(self, pose, time, limit, meanwhile=None, readings=None, joints=None):
        """Return the commands (n, 2) [m/s, rad/s] at ``pose`` (n, 3) and ``time`` [s].

        ``limit`` [s] of wall time; ``meanwhile()`` is called again and again while it is waited for.
        ``readings``: the newest of the robots' sensors, ``{row: {name: reading}}``; None: none are used.
        ``joints`` (n, k) [rad] of robots with arms, where they are known.
        """
        # What it has been given it keeps: nothing need be sent to another process twice.
        known = () if readings is None or readings is self._given else (readings,)
        if joints is not None:
            known = (*(known or (None,)), joints)
        self._given = readings
        return self._call("commands", pose, time, *known, limit=limit, meanwhile=meanwhile)

    def targets(self, pose, limit, meanwhile=None):
        """Return where the hand points are wanted, (n, 2) [m], or None; the last while it is busy."""
        if not self._worker.busy:
            self.known_targets = self._call("targets", pose, limit=limit, meanwhile=meanwhile)
        return self.known_targets

    def set_parameters(self, given):
        """Set the parameters ``given`` by name; ``ValueError`` says why not."""
        self._set("set_parameters", given)

    def set_topology(self, topology):
        """Replace the interaction graph; ``ValueError`` says why not."""
        self._set("set_topology", topology)
        self.other_topology = topology

    def _set(self, method, value):
        try:
            if self.lost:  # what is edited may be the cure
                self.remake()
            self._call(method, value)
        except (CallFailed, TimedOut) as error:
            raise ValueError(str(error)) from error

    def _call(self, method, *arguments, limit=None, meanwhile=None):
        limit = self._limit if limit is None else limit
        value, self.state = self._worker.ask((method, *arguments), limit, meanwhile)
        return value


def speaks_ros(protocol):
    """Return whether a protocol's own file uses ROS, for which it must be in a node's process."""
    for kind in protocol.__mro__:
        if kind.__module__.partition(".")[0] not in ("mrs_simulator", "builtins"):
            try:
                text = inspect.getsource(sys.modules[kind.__module__])
            except (OSError, TypeError, KeyError):
                text = ""
            if OWN_ROS.search(text):
                return True
    return False


def where_to_run(protocol, fork_server=None):
    """Return the ``apart`` of a :class:`Law`: a process from ``fork_server``, else in this process.

    There laws of one's own have a thread; those of this package, which are known to end, need none.
    """
    if fork_server is not None:
        return lambda: ForkedProcess(fork_server)
    kind = InPlace if is_shipped(protocol) else WorkerThread
    return lambda: kind(lambda: LawService(protocol))


def is_shipped(protocol):
    """Return whether ``protocol`` is one of this package."""
    return protocol.__module__.partition(".")[0] == "mrs_simulator"
