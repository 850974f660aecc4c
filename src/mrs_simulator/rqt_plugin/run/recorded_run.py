"""A run's data where a program other than the GUI has recorded it; without Qt and ROS."""

import json
import math
import os

from mrs_simulator.core.writing import naming, write_text
from mrs_simulator.record.recording import facts_path, write_facts
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.results.provenance import write_provenance
from mrs_simulator.study.results.report import (
    RUN_FILE,
    SCENARIO_FILE,
    VERDICT_FILE,
    is_result,
    remove_results,
)

UNANSWERED = "the simulation did not end in order: what it alone knew of the run is missing"
BLOCK = 1 << 20  # [bytes] copied at once


def copy_recorded(source, directory, sizes, history, report):
    """Copy the data of the run in ``source`` to ``directory``; return the path of ``run.csv``.

    ``sizes``: ``{name: bytes}`` of the files, of which no more is copied, or texts to write; None where the
    program that records has not answered: ``run.json`` then says what the ``History`` ``history`` has, and
    that.
    """
    os.makedirs(directory, exist_ok=True)
    remove_results(directory)
    facts = facts_path(RUN_FILE)
    if sizes is None:
        kept = (RUN_FILE, SCENARIO_FILE, facts)  # the latter where the run had ended in order
        names = [name for name in os.listdir(source) if name in kept or is_result(name)]
        sizes = {name: os.path.getsize(os.path.join(source, name)) for name in names}
    for name, size in sorted(sizes.items()):
        target = os.path.join(directory, name)
        if isinstance(size, str):
            write_text(target, size)
        else:
            _copy(os.path.join(source, name), target, size, report)
    path = os.path.join(directory, RUN_FILE)
    if facts not in sizes:
        meta = {"lockstep": True, "ended": UNANSWERED, "warnings": [UNANSWERED]}
        if history.incidents:
            meta["incidents"] = list(history.incidents)
        write_facts(path, history.collisions, meta)
    return path


def note_closest(directory):
    """Note in ``run.json`` of a reported run the least distance of its samples, too, as runs alone do."""
    path = facts_path(os.path.join(directory, RUN_FILE))
    facts, verdict = read_json(path), read_json(os.path.join(directory, VERDICT_FILE))
    closest = verdict["min_distance"]
    if closest is not None and closest < facts.get("closest_approach", math.inf):
        facts["closest_approach"] = closest
        write_text(path, json.dumps(facts, indent=2) + "\n")


def describe(directory):
    """Write ``provenance.json`` and the crate of a reported run, as runs alone have them."""
    scenario = load_scenario(os.path.join(directory, SCENARIO_FILE))
    write_provenance(scenario, directory)


def _copy(source, target, size, report):
    with naming(target), open(source, "rb") as given, open(target, "wb") as made:
        for begin in range(0, size, BLOCK):
            made.write(given.read(min(BLOCK, size - begin)))
            report(begin / size)
