"""Runs the command ``preflight`` for the GUI and reads its findings, without Qt."""

import os
import time
from typing import NamedTuple

from mrs_simulator.core.fields import shown
from mrs_simulator.scenario.reading import Section, read_json, reason
from mrs_simulator.state.columns import REAL as IS_REAL

LIMIT = 120.0  # [s] of wall time for the whole check
PATIENCE = 10.0  # [s] of wall time in which a stage has to publish its status
NAP = 0.02  # [s] of wall time


class Finding(NamedTuple):
    """A check that did not pass."""

    robot: str  # such as robot3; "" for the whole team
    what: str
    value: str
    wanted: str
    judged: bool = False  # whether a person who sees the robots may overrule it

    @property
    def key(self):
        """Return what makes it the same finding in another check."""
        return self.robot, self.what


class PreflightRun:
    """One check at a time, in the background, alone or before a start."""

    def __init__(self, connection, processes):
        self._connection, self._processes = connection, processes
        self.running = False
        self.findings, self.passed = None, 0  # of the last check; None before the first
        self.outcome = ""  # of the last check for the controller: started or refused
        self.real = []  # the argument with the real robots of the last check, as ``real_arguments``
        self._accepted = None  # keys of the findings that a start goes on with; None: no start

    @property
    def starting(self):
        """Return whether the controller is to start when the check is passed."""
        return self.running and self._accepted is not None

    def begin(self, scenario_path, own=(), accepted=None):
        """Check the robots of the scenario; with ``accepted``, start the controller afterwards.

        ``own``: findings of the GUI's own; ``accepted``: keys of findings that a person has
        overruled.
        """
        self.running, self._accepted, self.outcome = True, accepted, ""
        topics, run = self._connection.odometry_topics(), ["--scenario", scenario_path]
        self._connection.do("preflight", lambda: self._check(run, list(own), topics))

    def cancel(self):
        """Do not start the controller after the check; return whether it was to start."""
        was, self._accepted = self.starting, None
        return was

    def ended(self, success, answer):
        """Handle the answer of a check; return whether the controller is to start now."""
        self.running = False
        if not success:
            answer = (0, [Finding("", "the check itself", str(answer).strip()[-500:], "to end")])
        self.passed, self.findings = answer
        if self._accepted is None:
            return False
        accepted, self._accepted = self._accepted, None
        start = all(f.judged and f.key in accepted for f in self.findings)
        self.outcome = "started" if start else "refused"
        return start

    def may_judge(self):
        """Return whether a person may start the robots in spite of the findings."""
        return self.outcome == "refused" and all(finding.judged for finding in self.findings)

    def keys(self):
        """Return the keys of the findings."""
        return frozenset(finding.key for finding in self.findings or ())

    def _check(self, run, findings, topics):
        """Run the command; return ``(True, (checks passed, findings))``.  Not in the GUI's thread."""
        path = os.path.join(self._processes.directory, "preflight.json")
        if os.path.exists(path):
            os.remove(path)
        has_stage = self._has_stage()  # which says whose robots are real, on wall time, too
        if self._connection.has_simulated_time() and not has_stage:
            findings.append(
                Finding("", "clock", "/use_sim_time is true, and no stage runs", "false")
            )
        self.real = real_arguments(self._connection)
        arguments = run + self.real + ["--json", path]
        arguments += self._connection.controller_arguments(topics)
        _, output = self._processes.run("preflight", "preflight", *arguments, limit=LIMIT)
        if not os.path.exists(path):
            return False, output or "no answer within {:g} s".format(LIMIT)
        try:
            passed, found = read_findings(path)
        except (ValueError, OSError) as error:
            return False, "{}: {}".format(path, reason(error))
        return True, (passed, findings + found)

    def _has_stage(self):
        """Return whether a stage publishes its status; one that the master knows has ``PATIENCE``.

        Robots may be received before it, and a busy machine makes it silent for a while.
        """
        end = time.monotonic() + PATIENCE
        while not self._connection.is_fresh("stage"):
            if "stage" not in self._connection.registered or time.monotonic() > end:
                return False
            time.sleep(NAP)
        return True


def read_findings(path):
    """Return how many checks of the file at ``path`` passed, and the ``Finding`` of each other.

    Raises ``ValueError`` or ``OSError`` where it is not as the command ``preflight`` writes it.
    """
    rows = read_json(path)
    if not isinstance(rows, list):
        raise ValueError("{}, wanted a list of checks".format(shown(rows)))
    checks = [_read_check(row, "check {}".format(place)) for place, row in enumerate(rows, 1)]
    found = [finding for finding in checks if finding is not None]
    return len(checks) - len(found), found


def _read_check(row, where):
    """Return the ``Finding`` of a check, None of one that passed."""
    section = Section(row, where)
    texts = [section.text(name, "") for name in ("robot", "what", "value", "wanted")]
    passed, judged = section.flag("passed", None), section.flag("judged", False)
    section.done()
    return None if passed else Finding(*texts, judged)


def real_arguments(connection):
    """Return the argument with the stage's real robots, in a list; [] without a stage: all are real.

    A stage that the master knows is one, though a busy machine may have made it silent for a while.
    """
    if not (connection.is_fresh("stage") or "stage" in connection.registered):
        return []
    snapshot = connection.snapshot()
    # An empty list is passed as well: the parameter outlives the last controller.
    return ["_real:={}".format(sorted(snapshot.numbers_with(IS_REAL)) if snapshot else [])]
