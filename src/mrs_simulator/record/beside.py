"""A thread that does things one after the other, beside whoever asks for them."""

import queue
import threading
import weakref

MOST_WAITING = 6  # [-] things that wait until they are done: they take memory


class Beside:
    """A thread that calls functions in the order in which it is asked to.

    After one that raises it calls none.  It ends with :meth:`close`, with this object, or with the
    process; what it was asked for is done by then.
    """

    def __init__(self):
        self._waiting, self._raised = queue.Queue(MOST_WAITING), []
        thread = threading.Thread(target=_work, args=(self._waiting, self._raised), daemon=True)
        thread.start()
        self.close = weakref.finalize(self, _end, self._waiting, thread)

    def ask(self, function):
        """Let the thread call ``function``; wait while too much waits.  Raises as :meth:`settle` does."""
        self._waiting.put(function)
        self._raise()

    def settle(self):
        """Wait until all is done; raises, once, what a function raised."""
        done = threading.Event()
        self._waiting.put(done)
        done.wait()
        self._raise()

    def _raise(self):
        if self._raised:
            raise self._raised.pop()


def _work(waiting, raised):
    """Call what comes from the queue ``waiting``, up to None, and set events; put what is ``raised`` first
    into that."""
    is_able = True
    for function in iter(waiting.get, None):
        if isinstance(function, threading.Event):
            function.set()
        elif is_able:
            try:
                function()
            except BaseException as error:
                is_able = False
                raised.append(error)
        del function  # its owner may go meanwhile


def _end(waiting, thread):
    waiting.put(None)
    if thread is not threading.current_thread():
        thread.join()
