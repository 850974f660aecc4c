"""What is computed in the background: the last thing asked for, and no other."""

import threading

from ros_fixtures import wait_until

from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker


def test_of_many_moves_the_last_one_is_computed():
    later, done = DebouncedWorker(rest=0.2), []
    for move in range(20):
        later.ask(lambda move=move: done.append(move) or move)
    assert wait_until(later.take) == (19, None)
    assert done[-1] == 19 and len(done) < 20
    assert later.take() is None


def test_an_answer_that_is_out_of_date_is_dropped():
    later, begun, goes_on = DebouncedWorker(rest=0.0), threading.Event(), threading.Event()
    later.ask(lambda: begun.set() or goes_on.wait() and "old")
    assert begun.wait(60.0)
    later.ask(lambda: "new")
    goes_on.set()
    assert wait_until(later.take) == ("new", None)
    later.ask(lambda: len(3))
    answer, error = wait_until(later.take)
    assert answer is None and isinstance(error, TypeError)


def test_nothing_is_computed_after_the_end():
    later, begun, goes_on = DebouncedWorker(rest=0.0), threading.Event(), threading.Event()
    later.ask(lambda: begun.set() or goes_on.wait())
    assert begun.wait(60.0)
    later.ask(None)
    goes_on.set()
    wait_until(lambda: not later._serving)
    assert later.take() is None
