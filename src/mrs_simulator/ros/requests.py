"""Hands requests of service threads to a node's main loop and returns the results."""

import queue
import threading

ANSWER_LIMIT = 10.0  # [s] of wall time a caller waits for the main loop


class Requests:
    """A queue of functions, run one after another by whoever calls ``serve``."""

    def __init__(self):
        self._queue = queue.Queue()

    def ask(self, function):
        """Have ``function`` run in the main loop; return its ``(success, message)``."""
        done, answer = threading.Event(), []
        self._queue.put((function, done, answer))
        if not done.wait(ANSWER_LIMIT):
            return False, "no answer within {:g} s".format(ANSWER_LIMIT)
        return answer[0]

    def serve(self):
        """Run what was asked for.  An error becomes the answer; it never leaves the loop."""
        while True:
            try:
                function, done, answer = self._queue.get_nowait()
            except queue.Empty:
                return
            try:
                answer.append((True, function() or "done"))
            except Exception as error:  # the caller is told; the stage goes on
                answer.append((False, str(error) or type(error).__name__))
            done.set()
