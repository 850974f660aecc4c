#!/usr/bin/env python3
"""Bring the generated tables of these pages up to date: python3 docs/make_tables.py

Tables of keys and parameters are made of their declarations, and those of speeds of what was measured, each
between two marks in its page.
"""

import os
import re
import sys

from mrs_simulator.core.writing import write_text
from mrs_simulator.ros.node import node_parameters
from mrs_simulator.scenario import keys

DOCS = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, DOCS)
import make_protocols  # noqa: E402, beside this file
import make_speeds  # noqa: E402

# Of keys under others, by page, where that is not the one of scenarios.
ELSEWHERE = {
    "search.md": ("search",),
    "sensors.md": ("odometry_errors", "estimates"),
    "manipulators.md": ("load",),
    "safety_filter.md": ("safety",),
}
BEGIN, END = "<!-- table {}, made by docs/make_tables.py -->", "<!-- end -->"


def tables():
    """Return the text of each table: ``{page: {name: text}}``."""
    nested = {key: keys.nested_table(key) for key in keys.NESTED}
    elsewhere = {name: {key: nested.pop(key) for key in own} for name, own in ELSEWHERE.items()}
    nodes = {node: node_parameters.table(node) for node in node_parameters.NODES}
    made_of = {
        "nodes.md": nodes,
        "scenarios.md": {"keys": keys.table(), **nested},
        "shipped_protocols.md": {"protocols": make_protocols.overview()},
        "gallery.md": {"pictures": make_protocols.pictures()},
        **make_speeds.tables(),
    }
    for page, own in elsewhere.items():
        made_of[page] = {**made_of.get(page, {}), **own}
    return made_of


def path_of(page):
    """Return the path of the ``page``."""
    return os.path.join(DOCS, page)


def text_of(page):
    """Return the text of the ``page``."""
    with open(path_of(page), encoding="utf-8") as file:
        return file.read()


def made(page, named):
    """Return the text of the ``page`` with the tables ``named``; ``ValueError`` without a place for one."""
    text = text_of(page)
    for name, table in named.items():
        begin = BEGIN.format(name)
        pattern = re.compile(re.escape(begin) + "\n.*?" + re.escape(END), re.DOTALL)
        if not pattern.search(text):
            raise ValueError("{}: no place for a table, wanted {} and {}".format(page, begin, END))
        fresh = "{}\n{}\n{}".format(begin, table, END)
        text = pattern.sub(lambda _, fresh=fresh: fresh, text)
    return text


if __name__ == "__main__":
    for page, named in tables().items():
        write_text(path_of(page), made(page, named))
