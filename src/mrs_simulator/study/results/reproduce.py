"""The program ``reproduce``: run again what made a figure or a run, and compare the bytes."""

import argparse
import os
import shlex
import shutil
import sys
import tempfile

from mrs_simulator.core import compiling
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import FORMATS, look
from mrs_simulator.study.results.provenance import (
    LOCKSTEP,
    ROBOTS,
    STAGE,
    commit,
    processor,
    read_provenance,
)
from mrs_simulator.study.results.report import (
    PROVENANCE_FILE,
    RUN_FILE,
    SCENARIO_FILE,
    control_of,
    read_run,
    write_report,
)
from mrs_simulator.study.results.stamp import digest, stamp_of
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.verdict.verdict import versions

SAME, OTHER = 0, 1  # exit codes
UNCHANGED = "  nothing that is known has changed"
EQUAL = "the same bytes"
BUT_STAMP = " but for the hash of all inputs, which it carries"
ANOTHER = "is another: sha256 {}..., was {}..."
DIGITS = 12  # of a hash that are shown
AGREES = "  the run agrees all the same: made again, run.csv has the same bytes"
DISAGREES = "  the run does not agree: made again, run.csv has other bytes"
NONE = "none"  # the preset of a stage without one
OVER_ROS = "  over ROS alone: {}what wheel odometry rounds, the last digits of tilt"
UNTOLD = "a driver's preset, "
EXPECTED = (
    "  made with the preset {}, which a run without ROS does not have: another run.csv is expected"
)
AGAIN = (
    "  over ROS its run.csv is made again by: roslaunch mrs_simulator simulation.launch "
    "scenario:={} {}lockstep:=true speed:=0 out:=ANOTHER_DIR"
)
RECORDED = {  # whether its run.csv is kept
    False: "recorded of {}: run again without ROS",
    True: "recorded of {} in time: run.csv stays as it is, figures are made of it again",
}


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
    if not os.path.exists(os.path.join(out, PROVENANCE_FILE)):
        text = "{}: wanted a run's directory, or one of its files, with the {} that says how it was made"
        raise ValueError(text.format(path, PROVENANCE_FILE))
    made = read_provenance(out)
    outputs = made["outputs"]
    if name:
        if name not in outputs:
            text = "{}: not among what the run made: {}"
            raise ValueError(text.format(name, ", ".join(sorted(outputs))))
        outputs = {name: outputs[name]}
    formats = sorted({each.rpartition(".")[2] for each in outputs} & set(FORMATS))
    stamp = _text_in(made, "stamp", "")  # none of earlier versions
    own_look = look(made["look"].get("width", ""), style)._replace(stamp=stamp)
    if made.get("recorded_of"):
        with_preset = " with the preset {}".format(made["preset"]) if _preset(made) else ""
        print(RECORDED[_is_kept(made)].format(made["recorded_of"] + with_preset))
    with tempfile.TemporaryDirectory(prefix="mrs_simulator") as directory:
        with compiling.as_made(_compiled(made)):  # which decides on last bits
            _make_again(made, out, directory, formats, own_look)
        again = {each: digest(os.path.join(directory, each)) for each in outputs}
        run = digest(os.path.join(directory, RUN_FILE))
    now = {each: digest(os.path.join(out, each)) for each in outputs}
    inputs, stamped = changed_inputs(made, out), _stamped(stamp, out, outputs)
    for each in outputs:
        text = _said(again[each], outputs[each], now[each])
        print("{}: {}".format(each, text + BUT_STAMP * (each in stamped and text == EQUAL)))
    changed = ["  changed: " + each for each in inputs]
    if inputs and not _is_kept(made):
        changed.append(AGREES if run == made["outputs"].get(RUN_FILE) else DISAGREES)
    if again == outputs and not stamped:
        print("\n".join(changed), end="\n" * bool(changed))
        return SAME if now == outputs else OTHER
    changed = ["  changed: " + each for each in changed_programs(made)] + changed
    if made.get("recorded_of") == LOCKSTEP:
        changed += _over_ros(made, out)
    print("\n".join(changed or [UNCHANGED]))
    return OTHER


def _over_ros(made, out):
    """Return in lines what a run without ROS lacks of that in ``out``, and how it is made over ROS."""
    if "preset" not in made:  # by an earlier version
        return [OVER_ROS.format(UNTOLD)]
    preset, scenario = _preset(made), os.path.join(os.path.abspath(out), SCENARIO_FILE)
    why = EXPECTED.format(preset) if preset else OVER_ROS.format("")
    given = "preset:={} ".format(shlex.quote(preset)) if preset else ""
    return [why, AGAIN.format(shlex.quote(scenario), given)]


def _preset(made):
    """Return the name of the preset of the stage that was recorded, "" where it had none."""
    preset = _text_in(made, "preset", NONE)
    return "" if preset == NONE else preset


def _is_kept(made):
    """Return whether what was ``made`` is of robots, or a stage, in time: it cannot be run again."""
    return made.get("recorded_of") in (STAGE, ROBOTS)


def _make_again(made, out, directory, formats, own_look):
    """Make in ``directory`` the files of the run in ``out`` again; what robots did stays as it is."""
    if not _is_kept(made):
        scenario = load_scenario(os.path.join(out, SCENARIO_FILE))
        run_experiment(scenario, directory, formats=formats, look=own_look)
        return
    for name in os.listdir(out):
        if name.endswith((".csv", ".json")) or name == SCENARIO_FILE:
            shutil.copy(os.path.join(out, name), directory)
    run = read_run(directory)
    write_report(run, directory, formats, control_of(run), own_look)


def _compiled(made):
    """Return ``MRS_SIMULATOR_COMPILED`` as the run was ``made``; today's, where that is not known."""
    known = os.environ.get(compiling.VARIABLE)
    return None if made.get("compiled", known) is None else _text_in(made, "compiled", known)


def _text_in(made, key, otherwise):
    text = made.get(key, otherwise)
    if not isinstance(text, str):
        raise ValueError("{}: {}: {!r}, wanted a text".format(PROVENANCE_FILE, key, text))
    return text


def _said(again, made, now):
    """Return in words how a file made ``again`` is to what was ``made`` and to what is there ``now``."""
    if again == made:
        return (
            EQUAL if now == made else "edited since it was made; made again it has its first bytes"
        )
    said = "other bytes" if again else "not made"
    return said if now == made else said + ", and the file was edited since it was made"


def _stamped(stamp, out, outputs):
    """Return which of ``outputs`` would carry another hash of all inputs now than ``stamp``."""
    if not stamp or stamp == stamp_of(load_scenario(os.path.join(out, SCENARIO_FILE))):
        return []
    return [each for each in outputs if each.rpartition(".")[2] in FORMATS]


def changed_programs(made):
    """Return what computes otherwise now than when a run was ``made``, a list of texts."""
    found = []
    for name, value in versions().items():
        if made["versions"].get(name) != value:
            found.append("{} {}, was {}".format(name, value, made["versions"].get(name)))
    for name, value in (("commit", commit()), ("processor", processor())):
        if made[name] != value:
            found.append("{} {}, was {}".format(name, value or "unknown", made[name] or "unknown"))
    return found


def changed_inputs(made, out):
    """Return which files of the run in ``out`` are others than when it was ``made``, a list of texts."""
    found = []
    inputs = dict(made["inputs"])
    if _is_kept(made):
        inputs[RUN_FILE] = made["outputs"].get(RUN_FILE)
    for path, value in inputs.items():
        now = digest(path if os.path.isabs(path) else os.path.join(out, path))
        if now != value:
            hashes = ANOTHER.format(*(str(each or NONE)[:DIGITS] for each in (now, value)))
            found.append("{} {}".format(path, hashes if now else "is gone"))
    return found
