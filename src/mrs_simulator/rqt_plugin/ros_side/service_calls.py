"""Service calls of the GUI in the background, one queue per server, without Qt."""

import queue
import threading
import time

import rospy
from std_srvs.srv import SetBool, Trigger

from mrs_simulator.rqt_plugin.run.answers import SERVERS, no_answer
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.srv import SetSpeed, SetTeam, SetTopology, StepStage

SERVICE_LIMIT = 5.0  # [s] a caller waits for a service to appear
SLOW = 2.0  # [s] of wall time after which a missing answer is reported
CONTROLLER, MASTER, STAGE = "pioneer_control", "master", "stage"
SIMULATED_TIME = "/use_sim_time"

SERVICES = {
    "pause": (STAGE, SetBool),
    "pause_after": (STAGE, StepStage),
    "step": (STAGE, StepStage),
    "reset": (STAGE, Trigger),
    "set_speed": (STAGE, SetSpeed),
    "set_team": (STAGE, SetTeam),
    "start": (CONTROLLER, Trigger),
    "stop": (CONTROLLER, Trigger),
    "set_topology": (CONTROLLER, SetTopology),
}


class ServiceCalls:
    """Requests in the background, those to one server one after the other; ``stop`` waits for none."""

    def __init__(self):
        self._queues, self._results, self._ended = {}, queue.Queue(), threading.Event()

    def ask(self, name, arguments, then=None, first=None):
        """Call service ``name`` of ``SERVICES``, ``first()`` before, and ``then()`` right after a success.

        ``take_results`` returns the answer.
        """
        server, kind = SERVICES[name]
        service = "{}/{}".format(server, name)
        self.put(server, name, lambda: _call(service, server, kind, arguments, then, first))

    def put(self, server, name, work):
        """Run ``work`` after all else for ``server``; its ``(success, answer)`` is the result ``name``."""
        key = "stop" if name == "stop" else server
        if key not in self._queues:
            self._queues[key] = _ServerQueue(server, self._answer, self._ended)
        self._queues[key].work.put((name, work))

    def do(self, name, function):
        """Run ``function`` in a thread of its own; its ``(success, answer)`` is the result ``name``."""
        threading.Thread(target=self._answer, args=(name, function), daemon=True).start()

    def take_results(self):
        """Return the answers since the last call ``(name, success, answer)``, and which are missing."""
        taken = []
        for server_queue in self._queues.values():
            taken += server_queue.take_slow()
        while True:
            try:
                taken.append(self._results.get_nowait())
            except queue.Empty:
                return taken

    def _answer(self, name, work):
        try:
            success, answer = work()
        except Exception as error:  # reported as the answer; the thread goes on
            success, answer = False, reason(error)
        self._results.put((name, success, answer))

    def close(self, end):
        """Finish pending requests until ``end`` [s] of the monotonic clock; drop the rest."""
        for server_queue in self._queues.values():
            server_queue.work.put(None)
        for server_queue in self._queues.values():
            server_queue.thread.join(max(0.0, end - time.monotonic()))
        # A robot is not to start because a server has come back after the GUI was closed.
        self._ended.set()


class _ServerQueue:
    """The queue of requests to one server, and the thread that serves it."""

    def __init__(self, server, answer, ended):
        self.work, self._server = queue.Queue(), server
        self._answer, self._ended = answer, ended
        self._under_way = None  # (name, [s] when it began) until answered or reported as slow
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self):
        for name, work in iter(self.work.get, None):
            if self._ended.is_set():
                return
            self._under_way = name, time.monotonic()
            self._answer(name, work)
            self._under_way = None

    def take_slow(self):
        """Return a list with the report, made once, of a missing answer; else an empty one."""
        slow = self._under_way
        if slow is None or time.monotonic() - slow[1] < SLOW:
            return []
        self._under_way = None
        return [("slow", True, no_answer(slow[0], self._server))]


def _call(service, server, kind, arguments, then, first):
    who = SERVERS[server]
    try:
        rospy.wait_for_service(service, SERVICE_LIMIT)
        if first is not None:
            first()
        answer = rospy.ServiceProxy(service, kind)(*arguments)
    except rospy.ROSException:
        return False, "{} is not there, or is about to end".format(who)
    except rospy.ServiceException:
        return False, "{} ended before it answered".format(who)
    if answer.success and then is not None:
        then()
    return answer.success, answer.message


def reconfigure(values):
    """Set the protocol's parameters through dynamic_reconfigure; return ``(success, message)``."""
    from dynamic_reconfigure.client import Client  # slow to import, seldom needed

    client = Client(CONTROLLER, timeout=SERVICE_LIMIT)
    try:
        in_force = client.update_configuration(values)
    finally:
        client.close()
    refused = [name for name, value in values.items() if in_force.get(name) != value]
    if refused:
        return False, "refused: " + ", ".join(refused)
    return True, "parameters set"


def begin_simulated_time():
    """Set ``/use_sim_time``; return ``(True, what it was)``, None if not set."""
    before = rospy.get_param(SIMULATED_TIME, None)
    rospy.set_param(SIMULATED_TIME, True)
    return True, before


def restore_simulated_time(before):
    """Set ``/use_sim_time`` to what it was ``before``; return ``(True, "")``."""
    if before is not None:
        rospy.set_param(SIMULATED_TIME, before)
    elif rospy.has_param(SIMULATED_TIME):
        rospy.delete_param(SIMULATED_TIME)
    return True, ""
