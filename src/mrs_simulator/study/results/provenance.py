"""How the files of a run were made: ``provenance.json`` beside ``run.json``."""

import json
import os
import platform
import sys

from mrs_simulator.core import compiling
from mrs_simulator.core.writing import write_text
from mrs_simulator.scenario.reading import read_json
from mrs_simulator.scenario.shipped import PACKAGE
from mrs_simulator.study.draw.style import Look
from mrs_simulator.study.results.report import PROVENANCE_FILE, RUN_FILE, is_result
from mrs_simulator.study.results.ro_crate import MEANINGS, write_crate
from mrs_simulator.study.results.stamp import digest, input_files, stamp_of
from mrs_simulator.verdict.verdict import versions

LOCKSTEP, STAGE, ROBOTS = "a stage in lockstep", "a stage", "robots"  # of which ROS tells
KEYS = ("command", "versions", "commit", "processor", "seed", "look", "inputs", "outputs")


def provenance(scenario, out, look, recorded_of="", **told):
    """Return how the run of ``scenario`` in the directory ``out`` was made, a plain mapping.

    ``command``: the command line; ``versions`` of what computed, ``commit`` of the product, "" outside
    of a clone; ``processor``; ``compiled``: ``MRS_SIMULATOR_COMPILED``, None where it was unset, or
    "many" in a sweep that was compiled; ``seed``; ``look``: width [in] and style of the figures;
    ``recorded_of``: over ROS ``LOCKSTEP``, ``STAGE`` or ``ROBOTS``; ``told``: what else is known of it,
    of a stage the name of its ``preset``, or "none";
    ``stamp``: what figures carry, one hash of all inputs; ``inputs`` and ``outputs``: SHA-256 by file, the
    outputs without those that hold wall times
    (``run.json``, ``verdict.json``).
    """
    inputs = {path: digest(path) for path in input_files(scenario)}
    inputs["scenario.yaml"] = digest(os.path.join(out, "scenario.yaml"))
    made = sorted(name for name in os.listdir(out) if name == RUN_FILE or is_result(name))
    return {
        "command": " ".join([os.path.basename(sys.argv[0]), *sys.argv[1:]]),
        "versions": versions(),
        "commit": commit(),
        "processor": processor(),
        "compiled": compiling.mode(),
        "seed": scenario.seed,
        "recorded_of": recorded_of,
        **told,
        "look": {"width": look.width, "style": {k: str(v) for k, v in look.style.items()}},
        "stamp": stamp_of(scenario),
        "inputs": inputs,
        "outputs": {name: digest(os.path.join(out, name)) for name in made},
    }


def write_provenance(scenario, out, look=None, recorded_of="", **told):
    """Write ``provenance.json`` to the directory ``out``, whose other files are complete, and its crate."""
    made = provenance(scenario, out, look or Look(), recorded_of, **told)
    write_text(os.path.join(out, PROVENANCE_FILE), json.dumps(made, indent=2) + "\n")
    names = sorted({*MEANINGS, *made["outputs"]} & set(os.listdir(out)))
    write_crate(scenario.title, names, out)


def read_provenance(out):
    """Return what :func:`write_provenance` wrote to ``out``; ``ValueError`` where it is none."""
    path = os.path.join(out, PROVENANCE_FILE)
    found = read_json(path)
    missing = [key for key in KEYS if not isinstance(found, dict) or key not in found]
    if missing:
        raise ValueError("{}: no {}, wanted what a run writes".format(path, missing[0]))
    for key in ("versions", "look", "inputs", "outputs"):
        if not isinstance(found[key], dict):
            raise ValueError("{}: {} is no mapping".format(path, key))
    return found


def commit():
    """Return the commit that is checked out where this package lies in a clone, else ""."""
    root = os.path.dirname(os.path.dirname(os.path.realpath(PACKAGE)))
    try:
        own = os.path.join(root, ".git")
        if os.path.isfile(own):  # of a worktree
            own = os.path.join(root, _text(own).partition("gitdir: ")[2])
        head = _text(os.path.join(own, "HEAD"))
        if not head.startswith("ref: "):
            return head
        shared = os.path.join(own, "commondir")
        common = os.path.join(own, _text(shared)) if os.path.exists(shared) else own
        return _referred(common, head[5:])
    except OSError:  # a wheel
        return ""


def _referred(common, name):
    """Return the commit of the reference ``name`` in the directory ``common`` of a clone, "" if none."""
    loose = os.path.join(common, *name.split("/"))
    if os.path.exists(loose):
        return _text(loose)
    rows = map(str.split, _text(os.path.join(common, "packed-refs")).splitlines())
    return next((row[0] for row in rows if row[1:] == [name]), "")


def _text(path):
    with open(path) as file:
        return file.read().strip()


def processor():
    """Return the processor's name, which decides on last bits."""
    try:
        with open("/proc/cpuinfo") as file:
            names = [
                line.partition(":")[2].strip() for line in file if line.startswith("model name")
            ]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()
