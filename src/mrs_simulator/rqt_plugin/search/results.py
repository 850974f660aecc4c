"""What the commands ``break``, ``assure`` and ``margins`` have found, read from their files; without Qt."""

import os
from typing import NamedTuple

from mrs_simulator.scenario.reading import read_json
from mrs_simulator.study.results.report import RUN_FILE
from mrs_simulator.study.search import assure_command, break_command, margins_command

BREAK, ASSURE, MARGINS = "break", "assure", "margins"
PROGRESS, WARNING = "search: ", ": warning: "


class Result(NamedTuple):
    """What a command has found: ``text`` in lines, and paths of what can be shown, "" without."""

    text: str
    run: str = ""  # the counterexample's folder
    moment: float = 0.0  # [s] at which it breaks
    scenario: str = ""  # what broke, as a scenario
    figure: str = ""


def result_of(command, out, printed):
    """Return the ``Result`` of a ``command`` that has ended without an error.

    ``out``: its directory; ``printed``: what it has printed.  Raises ``OSError`` and ``ValueError``.
    """
    lines = [line for line in printed.splitlines() if not line.startswith(PROGRESS)]
    lines.sort(key=lambda line: WARNING in line)  # what was found comes first
    text = "\n".join(lines).strip()
    if command == MARGINS:
        report = read_json(os.path.join(out, margins_command.REPORT))
        figure = os.path.join(out, margins_command.FIGURE + ".png")
        return Result("\n".join(margins_command.lines_of(report)), figure=figure)
    name = break_command.SCENARIO if command == BREAK else assure_command.FAILED
    scenario = os.path.join(out, name)
    if not os.path.exists(scenario):
        return Result(text)
    run = os.path.join(out, break_command.RUN)
    if command == ASSURE or not os.path.exists(os.path.join(run, RUN_FILE)):
        return Result(text, scenario=scenario)
    worst = read_json(os.path.join(out, break_command.REPORT)).get("worst") or {}
    return Result(text, run, worst.get("decided_at") or 0.0, scenario)
