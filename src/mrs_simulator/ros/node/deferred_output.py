"""Prints a text after all else that roslaunch prints, which ends the other nodes after this one."""

import contextlib
import os
import subprocess
import sys
import time

LIMIT = 40.0  # [s] of wall time; roslaunch gives its nodes up to 17 s to end, drivers and rosbag together
NAP = 0.02  # [s] of wall time


def command_line(process):
    """Return the words with which the process of this number was started, [] once it has ended."""
    try:
        with open("/proc/{}/cmdline".format(process), "rb") as file:
            return file.read().decode("utf-8", "replace").split("\0")[:-1]
    except OSError:  # another system, or it is gone
        return []


def roslaunch_words():
    """Return the arguments of the roslaunch that started this process, None if none did."""
    words = command_line(os.getppid())
    names = [os.path.basename(word) for word in words[:3]]
    return words[names.index("roslaunch") + 1 :] if "roslaunch" in names else None


def print_last(text):
    """Print ``text`` once the roslaunch that started this process has ended, without one at once.

    A process of its own waits for that.
    """
    sys.stdout.flush()
    if roslaunch_words() is not None:
        waiter = [sys.executable, os.path.abspath(__file__), str(os.getppid()), text]
        # Ctrl-C, and roslaunch's own signals, are not meant for it.
        subprocess.Popen(waiter, stdin=subprocess.DEVNULL, start_new_session=True)
    else:
        print(text, flush=True)


def _wait_and_print(process, text):
    end = time.monotonic() + LIMIT
    while command_line(process) and time.monotonic() < end:
        time.sleep(NAP)
    with contextlib.suppress(BrokenPipeError):
        print(text, flush=True)


if __name__ == "__main__":
    _wait_and_print(*sys.argv[1:3])
