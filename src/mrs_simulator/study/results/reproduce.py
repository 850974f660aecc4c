"""The program ``reproduce``: run again what made a figure or a run, and compare the bytes."""

import argparse
import os
import sys
import tempfile

from mrs_simulator.core import compiling
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.draw.style import FORMATS, look
from mrs_simulator.study.programs import refusing_bad_input
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
    parser.add_argument("path", help="a run's directory, or one of its files")
    parser.add_argument("--style", default="", help="of its figures, where they had one")
    arguments = parser.parse_args(argv)
    with refusing_bad_input("reproduce"):
        sys.exit(reproduce(arguments))


def reproduce(arguments):
    """Run again and compare; print each file and what has changed; return the exit code."""
    out, name = arguments.path, ""
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
    style = look(made["look"].get("width", ""), arguments.style)
    scenario = load_scenario(os.path.join(out, "scenario.yaml"))
    with tempfile.TemporaryDirectory(prefix="mrs_simulator") as directory:
        with compiling.chosen(_compiled(made)):  # which decides on last bits
            run_experiment(scenario, directory, formats=formats, look=style)
        again = {each: digest(os.path.join(directory, each)) for each in outputs}
    for each in outputs:
        print(_line(each, again[each], outputs[each], digest(os.path.join(out, each))))
    if again == outputs:
        return SAME
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


def _line(name, again, made, now):
    said = "the same bytes" if again == made else "not made" if not again else "other bytes"
    edited = "" if now == made else ", and the file was changed since it was made"
    return "{}: {}{}".format(name, said, edited)


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


if __name__ == "__main__":
    main()
