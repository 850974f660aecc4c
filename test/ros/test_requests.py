"""What a service was asked for is carried out in time, or never."""

import threading

from ros_fixtures import wait_until

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node.requests import Requests


def asked(requests, function):
    """Ask in a thread of its own, as a service does; return the thread and the list of its answer."""
    answer = []
    thread = threading.Thread(target=lambda: answer.append(requests.ask(function)), daemon=True)
    thread.start()
    return thread, answer


def answered(function):
    """Return the answer to ``function``, which is served at once."""
    requests = Requests()
    _, answer = asked(requests, function)
    wait_until(lambda: requests.serve() or answer)
    return answer[0]


def test_answers_and_errors_come_back():
    assert answered(lambda: "moved") == (True, "moved")
    assert answered(lambda: None) == (True, "done")
    assert answered(lambda: 1 / 0) == (False, "division by zero")


def test_a_refusal_names_the_page_that_explains_it():
    @explained_by("docs/scenarios.md#graphs")
    def refused():
        raise ValueError("robot9: wanted one of 4")

    said = "robot9: wanted one of 4 (see docs/scenarios.md#graphs)"
    assert answered(refused) == (False, said)


def test_what_was_answered_as_failed_is_not_carried_out_later():
    requests, done = Requests(limit=0.05), []
    thread, answer = asked(requests, lambda: done.append(1))
    thread.join()
    assert answer == [(False, "no answer within 0.05 s: it is not carried out")]
    requests.serve()
    assert done == []


def test_what_takes_long_is_said_to_be_under_way():
    requests, begun, go_on = Requests(limit=2.0), threading.Event(), threading.Event()

    def work():
        begun.set()
        go_on.wait()

    server = threading.Thread(
        target=lambda: wait_until(lambda: requests.serve() or begun.is_set()), daemon=True
    )
    server.start()
    thread, answer = asked(requests, work)
    thread.join()
    go_on.set()
    server.join()
    assert answer == [(False, "not done within 2 s, and still under way")]
