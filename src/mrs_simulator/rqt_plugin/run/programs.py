"""The programs of a study: started, ended and started again, with their output and exit codes.  No Qt."""

import json
import os
import shlex
import shutil
from typing import NamedTuple

from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage

# By name: title in the GUI, and tooltip.
OWN = {
    "stage": ("stage", "The simulation, as Start simulation starts it"),
    "control": (
        "controller",
        "The protocol, as Start controller starts it: real robots are checked first",
    ),
    "record": ("recorder", "Writes run.csv, figures and verdict of the next run to ~/mrs_runs"),
    "rosbag": ("bag", "A rosbag of the run, in ~/mrs_runs, as Record bag starts it"),
}
TAKEN = {*OWN, "preflight", "report"}  # names of programs of the GUI's
# published by one that was started elsewhere
ELSEWHERE = {"stage": "stage", "control": "control"}
MOST_KEPT, LONGEST = 50, 2000  # [-] commands that are restored, and characters of each
SIGNALS = {-2: "interrupted", -9: "killed", -15: "terminated"}


class Program(NamedTuple):
    """One program as it is now."""

    name: str
    title: str
    tip: str
    state: str
    is_running: bool
    is_ending: bool
    can_start: str  # why it cannot be started now, or ""
    failed: bool  # whether it ended by itself, with an error


class Programs:
    """The programs that were or can be started here."""

    def __init__(self, study):
        """``study``: the ``StudyRun``."""
        self._study, self._processes = study, study.processes
        self._commands = {}  # of the user's own programs, lists of words by name
        self._again = set()  # names of those to be started as soon as they have ended

    def all(self):
        """Return each ``Program``."""
        own = {name: OWN[name] for name in OWN if name not in self._study.connection.absent}
        titles = {**own, **{name: (name, shlex.join(c)) for name, c in self._commands.items()}}
        return [self._program(name, *texts) for name, texts in titles.items()]

    def _program(self, name, title, tip):
        running, ending = self._processes.is_running(name), self._processes.is_ending(name)
        state, failed = self._state(name, running, ending)
        return Program(
            name, title, tip, state, running, ending, self._no_start(name, running, ending), failed
        )

    def _state(self, name, running, ending):
        """Return in words how a program is, and whether it failed."""
        if running:
            return "runs for {}".format(_duration(self._processes.age(name))), False
        if ending:
            return "is ending", False
        if name in ELSEWHERE and self._study.connection.is_fresh(ELSEWHERE[name]):
            return "started elsewhere", False
        code = self._processes.code(name)
        if code is None:
            return "not started", False
        good = code in (0, -2, 130)
        if code < 0:
            return "{} (signal {})".format(SIGNALS.get(code, "ended"), -code), not good
        return "ended with {}".format(code), not good

    def _no_start(self, name, running, ending):
        if running:
            return "already running"
        if ending:
            return "it is ending"
        if name == "stage":
            return self._study.state.actions()["simulate"][1]
        if name == "control":
            return self._study.state.no_start()
        return "" if self._study.connection.master_online else "no ROS master"

    # Requests -----------------------------------------------------------------------------------

    def add(self, command):
        """Take ``command``, words as in a shell, as a program; return what is wrong with it, or ""."""
        try:
            words = shlex.split(command)
        except ValueError as error:
            return ErrorMessage("command {!r}: {}".format(command, error))
        if not words:
            return ErrorMessage("no command: wanted one such as rosrun my_package my_node")
        if shutil.which(words[0]) is None:
            text = "command {!r}: no program {!r} is found, wanted one such as rosrun or a path"
            return ErrorMessage(text.format(command, words[0]))
        self._list(words)
        return ""

    def _list(self, words):
        """Put the program of a command on the list, by a name of its own."""
        base = _base(words)
        name, number = base, 2
        while name in TAKEN or self._commands.get(name, words) != words:
            name, number = "{}_{}".format(base, number), number + 1
        self._commands[name] = words

    def kept(self):
        """Return the commands of the user's own programs, as a text that ``take_up`` reads."""
        return json.dumps([shlex.join(words) for words in self._commands.values()])

    def take_up(self, text):
        """Put the commands of ``kept`` on the list; nothing is started.

        What is no list of commands is left out.
        """
        try:
            commands = json.loads(text)
        except (TypeError, ValueError):
            return
        given = commands[:MOST_KEPT] if isinstance(commands, list) else []
        for command in given:
            try:
                words = shlex.split(command) if isinstance(command, str) else []
            except ValueError:
                continue
            if words and len(command) <= LONGEST:
                self._list(words)

    def remove(self, name):
        """Forget a program of the user's own that does not run."""
        if name in self._commands and not self._processes.is_running(name):
            del self._commands[name]

    def is_users(self, name):
        """Return whether it is a program of the user's own."""
        return name in self._commands

    def start(self, name, speed=1.0):
        """Start the program called ``name``; return a message, or ""."""
        why = self._no_start(
            name, self._processes.is_running(name), self._processes.is_ending(name)
        )
        if why:
            return ErrorMessage("{} not started: {}".format(called(name), why))
        try:
            return self._start(name, speed)
        except OSError as error:
            return ErrorMessage("{} not started: {}".format(called(name), error))

    def _start(self, name, speed):
        if name in ("stage", "control", "rosbag"):
            action = {"stage": "simulate", "control": "control", "rosbag": "bag"}[name]
            return self._study.do(action, speed)
        if name == "record":
            return self._record()
        self._processes.launch(name, self._commands[name])
        return "{} started".format(name)

    def _record(self):
        files = self._study.files
        folder = os.path.join(files.results_directory(), files.suggested_name() + "_recorded")
        os.makedirs(files.results_directory(), exist_ok=True)
        scenario = self._study.control.written()
        self._processes.start("record", "record", "--scenario", scenario, "--out", folder)
        return "the recorder writes the next run to {}".format(folder)

    def end(self, name):
        """End the program called ``name``; return a message, or ""."""
        self._again.discard(name)
        if name == "stage":
            return self._study.do("end")
        if name == "rosbag":
            return self._study.do("bag") if self._processes.is_running(name) else ""
        self._processes.stop(name)
        return "{} ended".format(called(name))

    def restart(self, name):
        """End the program called ``name`` and start it as soon as it has; return a message, or ""."""
        message = self.end(name) if self._processes.is_running(name) else ""
        self._again.add(name)
        return message

    def kill(self, name):
        """Kill the program called ``name`` and what it has started; return a message."""
        self._again.discard(name)
        self._processes.kill(name)
        return "{} killed".format(called(name))

    def follow(self, speed=1.0):
        """Start what is to be started again and has ended; return messages."""
        due = sorted(filter(self._processes.is_gone, self._again))
        self._again.difference_update(due)
        return [self.start(name, speed) for name in due]

    def output(self, name):
        """Return the end of what the program called ``name`` has printed."""
        return self._processes.output(name)


def called(name):
    """Return what the program ``name`` is called in the GUI; one that is ending has its id after it."""
    return OWN[name][0] if name in OWN else name


def _base(words):
    """Return a name for the program of a command: of rosrun, roslaunch and python that of what they run."""
    runner = os.path.basename(words[0])
    place = 2 if runner == "rosrun" else 1 if runner.startswith("python") else 0
    if runner == "roslaunch":
        place = 2 if len(words) > 2 and ":=" not in words[2] else 1
    chosen = words[place] if place < len(words) and not words[place].startswith("-") else words[0]
    name = os.path.splitext(os.path.basename(chosen))[0]
    return "".join(c if c.isalnum() or c in "_-" else "_" for c in name) or "program"


def _duration(seconds):
    if seconds < 60.0:
        return "{:.0f} s".format(seconds)
    return "{:.0f} min {:02.0f} s".format(*divmod(int(seconds), 60))
