"""The program ``reproduce``: run again what made a figure or a run, and compare the bytes."""

import argparse
import os
import sys
import tempfile

from mrs_simulator.core import compiling
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import FORMATS, look
from mrs_simulator.study.results.provenance import commit, processor, read_provenance
from mrs_simulator.study.results.report import PROVENANCE_FILE
from mrs_simulator.study.results.stamp import digest
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.verdict.verdict import versions

SAME, OTHER = 0, 1  # exit codes


@printing
def main(argv=None):
    """Reproduce what the command line names; exit with 0 where all bytes are the same, else with 1."""
    parser = argparse.ArgumentParser(prog=program("reproduce"), description=__doc__.split(": ")[1])
    parser.add_argument("path", help="a run's directory, one of its files, or a directory of runs")
    parser.add_argument("--style", default="", help="of its figures, where they had one")
    arguments = parser.parse_args(argv)
    with refusing_bad_input("reproduce"):
        runs = runs_in(arguments.path)
        if len(runs) == 1:
            sys.exit(reproduce(runs[0], arguments.style))
    codes = [_one_of_many(run, arguments.style) for run in runs]
    print("{} of {} runs: the same bytes".format(codes.count(SAME), len(runs)))
    sys.exit(max(codes))


def _one_of_many(run, style):
    """Reproduce ``run`` as :func:`reproduce` does; what is wrong with it is printed, and others go on."""
    print("{}:".format(run), flush=True)
    try:
        with refusing_bad_input("reproduce"):
            return reproduce(run, style)
    except SystemExit as end:
        return end.code


def runs_in(path):
    """Return the runs below ``path``, a list of paths in order: ``path`` itself where it is of one run."""
    if not os.path.isdir(path) or os.path.exists(os.path.join(path, PROVENANCE_FILE)):
        return [path]
    found = [above for above, _, names in os.walk(path) if PROVENANCE_FILE in names]
    return sorted(found) or [path]


def reproduce(path, style=""):
    """Run again what ``path`` names and compare; print each file and what has changed.

    ``style``: of its figures, where they had one.  Return the exit code.
    """
    out, name = path, ""
    if not os.path.isdir(out):
        out, name = os.path.split(os.path.abspath(out))
    made = read_provenance(out)
    outputs = made["outputs"]
    if name:
        if name not in outputs:
            text = "{}: not among what the run made: {}"
            raise ValueError(text.format(name, ", ".join(sorted(outputs))))
        outputs = {name: outputs[name]}
    formats = sorted({each.rpartition(".")[2] for each in outputs} & set(FORMATS))
    own_look = look(made["look"].get("width", ""), style)
    scenario = load_scenario(os.path.join(out, "scenario.yaml"))
    with tempfile.TemporaryDirectory(prefix="mrs_simulator") as directory:
        with compiling.as_made(_compiled(made)):  # which decides on last bits
            run_experiment(scenario, directory, formats=formats, look=own_look)
        again = {each: digest(os.path.join(directory, each)) for each in outputs}
    now = {each: digest(os.path.join(out, each)) for each in outputs}
    for each in outputs:
        print("{}: {}".format(each, _said(again[each], outputs[each], now[each])))
    if again == outputs:
        return SAME if now == outputs else OTHER
    changed = changes(made, out)
    print(
        "\n".join("  changed: " + each for each in changed) or "  nothing that is known has changed"
    )
    return OTHER


def _compiled(made):
    """Return ``MRS_SIMULATOR_COMPILED`` as the run was ``made``; today's, where that is not known."""
    wanted = made.get("compiled", os.environ.get(compiling.VARIABLE))
    if not isinstance(wanted, (str, type(None))):
        raise ValueError("{}: compiled: {!r}, wanted a text".format(PROVENANCE_FILE, wanted))
    return wanted


def _said(again, made, now):
    """Return in words how a file made ``again`` is to what was ``made`` and to what is there ``now``."""
    if again == made:
        return (
            "the same bytes"
            if now == made
            else "edited since it was made; made again it has its first bytes"
        )
    said = "other bytes" if again else "not made"
    return said if now == made else said + ", and the file was edited since it was made"


def changes(made, out):
    """Return what is otherwise now than when the run in ``out`` was ``made``, a list of texts."""
    found = []
    for name, value in versions().items():
        if made["versions"].get(name) != value:
            found.append("{} {}, was {}".format(name, value, made["versions"].get(name)))
    for name, value in (("commit", commit()), ("processor", processor())):
        if made[name] != value:
            found.append("{} {}, was {}".format(name, value or "unknown", made[name] or "unknown"))
    for path, value in made["inputs"].items():
        now = digest(path if os.path.isabs(path) else os.path.join(out, path))
        if now != value:
            found.append("{} {}".format(path, "is another" if now else "is gone"))
    return found
