#!/usr/bin/env python3
"""Brings the table of run.csv's columns in docs/scenarios.md up to date: python3 docs/make_columns.py."""

import os
import re

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.state.columns import RECORDED

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "scenarios.md")
HEAD = "| columns | unit | when | meaning |\n|---|---|---|---|\n"
FIRST = "| `time`, `robot` | s, – | always | since the first command; the robot's number |\n"
LAST = "| `kind` | – | any team but one of Pioneers 3-DX alone | the name of the robot's kind |\n"


def table():
    """Return the table in Markdown."""
    rows = []
    for column in RECORDED:
        names = ", ".join(map("`{}`".format, column.names(2, UNICYCLE_AXES)))
        row = names, column.unit or "–", column.when, column.meaning
        rows.append("| {} |\n".format(" | ".join(row)))
    return HEAD + FIRST + "".join(rows) + LAST


def with_table(page):
    """Return the text ``page`` with the table that it has now."""
    found = re.compile(r"\| columns \|.*\n(\|.*\n)*")
    assert len(found.findall(page)) == 1, "wanted one table of columns"
    return found.sub(lambda _: table(), page)


if __name__ == "__main__":
    with open(PAGE, encoding="utf-8") as file:
        made = with_table(file.read())
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(made)
