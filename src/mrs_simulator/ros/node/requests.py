"""Hands requests of service threads to a node's main loop and returns the results."""

import queue
import threading

from mrs_simulator.core.doc_links import with_page

ANSWER_LIMIT = 10.0  # [s] of wall time a caller waits for the main loop


class Requests:
    """A queue of functions, run one after another by ``serve``."""

    def __init__(self, limit=ANSWER_LIMIT):
        """``limit`` [s] of wall time that a caller waits."""
        self._queue, self._limit = queue.Queue(), limit
        self._lock = threading.Lock()

    def ask(self, function):
        """Have ``function`` run in the main loop; return its ``(success, message)``.

        What has not begun within the time limit is never carried out, as its caller is informed.
        """
        request = _Request(function)
        self._queue.put(request)
        if request.done.wait(self._limit):
            return request.answer
        with self._lock:
            if not request.begun:
                request.withdrawn = True
                return False, "no answer within {:g} s: it is not carried out".format(self._limit)
        if request.done.is_set():
            return request.answer
        return False, "not done within {:g} s, and still under way".format(self._limit)

    def serve(self):
        """Run what was asked for.  An error becomes the answer; it never leaves the loop."""
        while True:
            try:
                request = self._queue.get_nowait()
            except queue.Empty:
                return
            with self._lock:
                if request.withdrawn:
                    continue
                request.begun = True
            try:
                request.answer = True, request.function() or "done"
            except Exception as error:  # returned to the caller; the stage goes on
                request.answer = False, with_page(error) or type(error).__name__
            request.done.set()


class _Request:
    def __init__(self, function):
        self.function, self.done, self.answer = function, threading.Event(), None
        self.begun = self.withdrawn = False
