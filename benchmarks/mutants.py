#!/usr/bin/env python3
"""A mutation campaign: mistakes put into the shipped laws, one at a time, and who catches them.

    python3 benchmarks/mutants.py             # all of them
    python3 benchmarks/mutants.py --fast      # the first of each group, as the tests do
    python3 benchmarks/mutants.py --table     # all of them, as the table in docs/mistakes.md

Each mutant, of benchmarks/mutants.yaml, is an edit of the source, made in a process of its own as it
imports the package; a short run of a shipped scenario must then fail.  The scenarios themselves must
pass without an edit.  Exits with 1 if a mutant survives, other than those that the table explains, or
if an edit no longer fits.
"""

import argparse
import contextlib
import importlib.abc
import importlib.machinery
import importlib.util
import io
import multiprocessing
import os
import sys
import tempfile
from typing import Any, Dict, NamedTuple, Optional

import yaml

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PACKAGE = os.path.join(ROOT, "src", "mrs_simulator")
TABLE = os.path.join(ROOT, "benchmarks", "mutants.yaml")
FAST = 1  # [-] mutants of each group that the tests run


def groups():
    """Return the groups of mutants by name, as the table has them."""
    with open(TABLE, encoding="utf-8") as file:
        return yaml.safe_load(file)


class Task(NamedTuple):
    """One run: a group's scenario, the values ``changes`` of its keys, and an ``edit``, None for none."""

    group: str
    scenario: str
    changes: Dict[str, Any]
    edit: Optional[Dict[str, str]] = None


class Edited(importlib.machinery.SourceFileLoader):
    """Loads a module whose source has one line edited."""

    edit = ("", "")

    def get_code(self, name):
        """Return the code of the edited source."""
        source = self.get_data(self.path).decode()
        if self.edit[0] not in source:
            raise ValueError("{}: nowhere {!r}".format(self.path, self.edit[0]))
        return compile(source.replace(*self.edit), self.path, "exec")


class Finder(importlib.abc.MetaPathFinder):
    """Finds the edited module."""

    def __init__(self, module, old, new):
        self.name = "mrs_simulator." + module
        path = os.path.join(PACKAGE, *module.split(".")) + ".py"
        self.loader = Edited(self.name, path)
        self.loader.edit = (old, new)

    def find_spec(self, name, path=None, target=None):
        """Return the spec of the module that is to be edited, None for any other."""
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.loader.path, loader=self.loader)


def run(task):
    """Return ``(outcome, names of the failed checks)`` of the task, in a process that is new."""
    if task.edit:
        edit = task.edit
        sys.meta_path.insert(0, Finder(edit["module"], edit["right"], edit["wrong"]))
    with contextlib.redirect_stderr(io.StringIO()):
        try:
            verdict = _verdict(task.scenario, task.changes)
        except Exception as error:
            return "error", ["{}: {}".format(type(error).__name__, error)]
    return verdict["outcome"], [c["name"] for c in verdict["checks"] if c["passed"] is False]


def _verdict(name, changes):
    from mrs_simulator import load_scenario, run_experiment
    from mrs_simulator.scenario.scenario import scenario_from_dict

    path = os.path.join(ROOT, "scenarios", name + ".yaml")
    content = load_scenario(path).to_dict()
    content.pop("step", None)
    for key, value in changes.items():
        into, parts = content, key.split(".")
        for part in parts[:-1]:
            into = into[part]
        into[parts[-1]] = value
    with tempfile.TemporaryDirectory() as out:
        return run_experiment(scenario_from_dict(content, path), out, formats=())


def tasks(fast=False):
    """Return the tasks: each group without an edit, and with each of its edits, or ``fast`` the first."""
    found = []
    for name, group in groups().items():
        plain = Task(name, group["scenario"], group["changes"])
        edits = group["mutants"][:FAST] if fast else group["mutants"]
        found += [plain] + [plain._replace(edit=edit) for edit in edits]
    return found


def results(wanted):
    """Yield ``(task, outcome, failed checks)`` of the ``wanted`` tasks; a process for each."""
    import geometry_msgs.msg  # noqa: F401
    import numpy  # noqa: F401  shared by all processes

    context = multiprocessing.get_context("fork")
    with context.Pool(os.cpu_count(), maxtasksperchild=1) as pool:
        for task, found in zip(wanted, pool.imap(run, wanted, chunksize=1)):
            yield (task, *found)


def main():
    """Run the campaign and say who survived."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--fast", action="store_true", help="the first mutant of each group")
    parser.add_argument("--table", action="store_true", help="print a table in Markdown")
    parser.add_argument("groups", nargs="*", help="of protocols, by default all")
    arguments = parser.parse_args()
    wanted = [
        t for t in tasks(arguments.fast) if not arguments.groups or t.group in arguments.groups
    ]
    wrong, table = [], {}
    for task, outcome, failed in results(wanted):
        if task.edit is None:
            if outcome not in ("passed", "not_judged"):  # of a few seconds the law alone is judged
                wrong.append("{}: {} without an edit: {}".format(task.group, outcome, failed))
            continue
        caught = outcome == "failed"
        table.setdefault(task.group, []).append((task, caught, failed))
        if caught == ("survives" in task.edit):
            wrong.append("{}: {} with {!r}: {}".format(task.group, outcome, task.edit, failed))
    print_table(table) if arguments.table else print_counts(table)
    print("\n".join(wrong), file=sys.stderr)
    sys.exit(1 if wrong else 0)


def print_counts(table):
    """Print how many mutants of each group were caught."""
    for group, rows in table.items():
        print("{:30} {} of {} caught".format(group, sum(row[1] for row in rows), len(rows)))


def print_table(table):
    """Print how many mutants of each group were caught, and by which checks, as Markdown."""
    print("| group | mutants | caught | checks that caught them, and how many each |")
    print("|---|---|---|---|")
    for group, rows in table.items():
        counts = {}
        for _, _, failed in rows:
            for name in failed:
                counts[name] = counts.get(name, 0) + 1
        told = ", ".join(
            "{} ({})".format(name.replace("|", "\\|"), n) for name, n in counts.items()
        )
        print("| {} | {} | {} | {} |".format(group, len(rows), sum(r[1] for r in rows), told))
        for task, caught, _ in rows:
            if not caught:
                why = task.edit.get("survives", "not explained")
                print("| | | survives | `{}`: {} |".format(task.edit["wrong"].strip(), why))


if __name__ == "__main__":
    main()
