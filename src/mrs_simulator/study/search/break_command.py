"""The program ``break``: search the run that breaks a scenario's requirements, and shrink it."""

import argparse
import contextlib
import json
import os
import re
import sys
from importlib.util import find_spec

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import counted
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import Limited, printing, write_text
from mrs_simulator.scenario.reading import load_yaml, parse_yaml
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.scenario.search import search_from
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.draw.style import add_look, look_of
from mrs_simulator.study.run.command import at_least, ending
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.run.workers import SweepError
from mrs_simulator.study.search.breaking import Search
from mrs_simulator.study.search.default_space import default_search
from mrs_simulator.study.search.kept_runs import KeptRuns, search_of
from mrs_simulator.study.search.space import Space, check_keys, least_values, varied_scenario
from mrs_simulator.verdict.requirements.results import line_of

SCENARIO, REPORT, RUN = "counterexample.yaml", "search.json", "run"
BROKEN, HELD = 1, 0  # exit codes
PROGRESS = re.compile(r"^search: (\d+) runs?(?: so far|, (.*))$", re.MULTILINE)


@printing
def main(argv=None):
    """Search as the command line says; exit with 1 where a run breaks a requirement, else with 0."""
    exit_with("break", break_scenario, _arguments(argv))


def exit_with(name, work, arguments):
    """Exit with what ``work(arguments)`` returns, or say what is wrong with its input.

    A program that is interrupted ends its processes, too.
    """
    with ending(name):
        code = work(arguments)
    sys.exit(code)


def _arguments(argv):
    parser = argparse.ArgumentParser(prog=program("break"), description=__doc__.split(": ")[1])
    add_search(parser)
    parser.add_argument("--runs", type=at_least(2), default=500, metavar="N", help="at most (500)")
    parser.add_argument(
        "--optimiser", choices=("cma", "random"), help="cma where the package cma is installed"
    )
    parser.add_argument("--no-shrink", action="store_true", help="keep the run as it was found")
    add_look(parser)
    return parser.parse_args(argv)


def add_runs(parser):
    """Add the arguments of all commands that run one scenario many times."""
    parser.add_argument("scenario", help="YAML file, or the name of a shipped one")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the results")
    parser.add_argument("--jobs", type=at_least(1), metavar="N", help="processes")
    parser.add_argument("--scheduler", default="", help="address of a Dask scheduler")


def add_search(parser):
    """Add the arguments of all searches."""
    add_runs(parser)
    parser.add_argument(
        "--seed", type=at_least(0), default=0, metavar="S", help="of the search (0)"
    )
    text = "what may vary, beside the scenario's search: mismatch.delay=[0, 0.4]"
    parser.add_argument("--vary", action="append", default=[], metavar="KEY=RANGE", help=text)


def opened(arguments, default=None):
    """Return the ``Search`` that the ``arguments`` of :func:`add_search` ask for; its directory is made.

    ``default(scenario)``: what varies where neither these nor the scenario say it.
    """
    path = os.path.abspath(scenario_path(arguments.scenario))
    content = load_yaml(path)
    scenario = scenario_of_file(content, path)
    varied = {**(content.get("search") or {}), **dict(map(_varied, arguments.vary))}
    unsaid = default is not None and not varied
    if unsaid:
        varied = default(scenario)
        tell("the scenario has no search; this varies: {}".format(", ".join(varied)))
    found = search_from(varied, path + ": search")
    check_keys(least_values(found), content, path, "search")
    with explained_by("docs/search.md"):
        space = Space(found, scenario.n, scenario.topology)
    known = search_of(content, path, found, seed=arguments.seed, within=unsaid)
    options = arguments.jobs, arguments.scheduler, tell, unsaid
    return Search(content, path, space, *options, KeptRuns(arguments.out, known, tell))


def _varied(text):
    key, _, value = text.partition("=")
    return key.strip(), parse_yaml(value, "--vary {}".format(key))


def optimiser_of(wanted):
    """Return the optimiser that is ``wanted``, by default the best that is installed.

    It is loaded, for most of a second, by searches that come to it alone.
    """
    if wanted == "random" or find_spec("cma") is not None:
        return wanted or "cma"
    if wanted == "cma":
        raise SweepError("--optimiser cma: wanted the Python package cma")
    tell("the Python package cma is not installed: runs are drawn at random")
    return "random"


def break_scenario(arguments):
    """Search and write what was found; return the exit code."""
    (look, formats), optimiser = look_of(arguments), optimiser_of(arguments.optimiser)
    search = opened(arguments, default_search)
    nominal = search.nominal()
    if nominal.is_broken:
        tell("the scenario is broken as it stands: {}".format(nominal.text))
    what = "requirement" if search.content.get("requirements") else "claim"
    try:
        found = search.find(arguments.runs, arguments.seed, optimiser)
    except KeyboardInterrupt:
        text = "interrupted: none of {} runs broke a {}; the same command goes on"
        tell(text.format(search.runs, what))
        raise
    searched = search.runs
    report = {
        "scenario": search.path,
        "search": search.space.search.to_plain(),
        "optimiser": optimiser,
        "seed": arguments.seed,
        "runs": searched,
        "refused": search.errors,
        "found": found is not None,
    }
    if found is None:
        _refuse_all_refused(search.errors, searched - 1)  # one was the scenario itself
        _write(report, arguments.out)
        print("not found: none of {} runs breaks a {}. That is no proof.".format(searched, what))
        if nominal.has_no_margin:
            print("  in the scenario as it stands: {}".format(line_of(nominal.worst)))
        elif search.left_open(nominal):
            names = ", ".join(search.left_open(nominal))
            print("  in the scenario as it stands: {} left open".format(names))
        if search.errors:
            often = max(search.errors, key=search.errors.get)
            refused = sum(search.errors.values())
            print("  {} of them were refused, as: {}".format(refused, often))
        return HELD
    if not arguments.no_shrink:
        tell("found after {}; it is shrunk".format(counted(found.runs, "run")))
        found = search.shrunk(found)
    report.update(
        variation=found.variation,
        worst=found.trial.worst,
        thresholds=found.thresholds,
        runs_of_shrinking=search.runs - searched,
    )
    _write(report, arguments.out)
    scenario = _write_scenario(search, found, arguments.out)
    with contextlib.redirect_stdout(Limited(search.printed)):
        run_experiment(scenario, os.path.join(arguments.out, RUN), formats=formats, look=look)
    print("\n".join(story_of(found, report, arguments.out)))
    return BROKEN


def _refuse_all_refused(errors, tried):
    """Raise ``SweepError`` where each of the runs that were ``tried`` was refused; ``errors``: by text."""
    if errors and sum(errors.values()) >= tried:
        text = "each of {} varied runs was refused, as: {}"
        raise SweepError(text.format(tried, max(errors, key=errors.get)))


def _write(report, out):
    write_text(os.path.join(out, REPORT), json.dumps(report, indent=2) + "\n")


def _write_scenario(search, found, out):
    """Write the counterexample as a scenario of its own; return it."""
    title = "Counterexample: {}".format(search.content.get("title", os.path.basename(search.path)))
    scenario = varied_scenario(search.content, search.path, found.variation, title, found.duration)
    write_text(os.path.join(out, SCENARIO), scenario.to_yaml())
    return scenario


def story_of(found, report, out):
    """Return in lines what breaks, where the threshold lies, and how many runs it took."""
    worst = found.trial.worst
    said = line_of(worst) if "formula" in worst else "{}: {}".format(worst["name"], worst["note"])
    text = "found after {}, shrunk by {} more"
    lines = [text.format(counted(found.runs, "run"), report["runs_of_shrinking"]), "  " + said]
    for key, value in found.variation.items():
        lines.append("  {}: {}".format(key, value))
    for key, holds, breaks in found.thresholds:
        lines.append("  {} holds at {:.5g} and breaks at {:.5g}".format(key, holds, breaks))
    again = "  run it again: mrs-simulator experiment {} --out {}"
    lines.append(again.format(os.path.join(out, SCENARIO), os.path.join(out, "again")))
    return lines


def tell(text):
    """Say on stderr how far a search is; a display reads it by ``progress_in``."""
    print("search: " + text, file=sys.stderr)


def progress_in(printed):
    """Return ``(runs, nearest)`` of what a search has ``printed``: how many runs, and what came nearest.

    None and "" where it does not say; ``nearest`` is a text with its unit.
    """
    found = PROGRESS.findall(printed)
    nearest = [text for _, text in found if text]
    return (int(found[-1][0]) if found else None), (nearest[-1] if nearest else "")
