"""Debounced background computation: only the newest request is computed.  No Qt."""

import threading
import time


class DebouncedWorker:
    """Computes the last request in a thread, once there was no other for ``rest`` [s]."""

    def __init__(self, rest):
        self._rest, self._lock = rest, threading.Lock()
        self._wanted, self._asked_at = None, 0.0
        self._answer, self._serving = None, False

    def ask(self, work):
        """Compute ``work()``, None for nothing; earlier requests are dropped."""
        with self._lock:
            self._wanted, self._asked_at, self._answer = work, time.monotonic(), None
            if not self._serving:
                self._serving = True
                threading.Thread(target=self._serve, daemon=True).start()

    def take(self):
        """Return ``(answer, error)`` of the last request, once, one of them None; else None."""
        with self._lock:
            answer, self._answer = self._answer, None
            return answer

    def _serve(self):
        while True:
            with self._lock:
                work, left = self._wanted, self._asked_at + self._rest - time.monotonic()
                if work is None:
                    self._serving = False
                    return
            if left > 0.0:
                time.sleep(left)
                continue
            try:
                answer = work(), None
            except Exception as error:  # a file of one's own may raise anything
                answer = None, error
            with self._lock:
                if self._wanted is work:
                    self._wanted, self._answer = None, answer
