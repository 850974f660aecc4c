"""The program ``assure``: show with confidence that runs at random keep their requirements."""

import argparse
import contextlib
import json
import math
import os

import numpy as np

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.search import SEED
from mrs_simulator.study.run.command import at_least
from mrs_simulator.study.search.assurance import clean_runs, log_evidence, lower_bound
from mrs_simulator.study.search.break_command import add_search, exit_with, opened, tell
from mrs_simulator.study.search.space import varied_scenario
from mrs_simulator.verdict.requirements.results import line_of

SHOWN, NOT_SHOWN = 0, 1  # exit codes
BATCH = 32  # runs at once
MOST_CLEAN = 1000000  # runs without a failure that one command may plan
REPORT, FAILED = "assurance.json", "failed.yaml"


@printing
def main(argv=None):
    """Draw runs as the command line says; exit with 0 where it is shown, with 1 where it is not."""
    exit_with("assure", assure, _arguments(argv))


def _arguments(argv):
    parser = argparse.ArgumentParser(prog=program("assure"), description=__doc__.split(": ")[1])
    add_search(parser)
    parser.add_argument("--at-least", type=_share, default=0.99, metavar="P", help="share (0.99)")
    parser.add_argument("--confidence", type=_share, default=0.95, metavar="C", help="(0.95)")
    text = "go on after failures, up to N runs, by a test that is valid at any time"
    parser.add_argument("--runs", type=at_least(1), metavar="N", help=text)
    arguments = parser.parse_args(argv)
    share, confidence = arguments.at_least, arguments.confidence
    if arguments.runs is None and clean_runs(share, confidence) > MOST_CLEAN:
        text = (
            "--at-least {!r}, --confidence {!r}: {:,} runs without a failure, wanted at most {:,}"
        )
        parser.error(text.format(share, confidence, clean_runs(share, confidence), MOST_CLEAN))
    return arguments


def _share(text):
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) < 1.0:
            return float(text)
    raise argparse.ArgumentTypeError("{}: wanted a number between 0 and 1".format(text))


def assure(arguments):
    """Draw and judge; write what was found and print it; return the exit code."""
    search = opened(arguments)
    share, confidence = arguments.at_least, arguments.confidence
    nominal = search.nominal()
    if nominal.has_no_margin:
        tell("in the scenario as it stands: {}".format(line_of(nominal.worst)))
    anytime = arguments.runs is not None
    most = arguments.runs if anytime else clean_runs(share, confidence)
    good, runs, first_bad = _drawn(search, arguments.seed, most, share, confidence, anytime)
    if anytime:
        shown = runs > 0 and log_evidence(good, runs, share) >= -math.log(1.0 - confidence)
    else:
        shown = runs == good == most
    report = {
        "scenario": search.path,
        "search": search.space.search.to_plain(),
        "seed": arguments.seed,
        "at_least": share,
        "confidence": confidence,
        "good": good,
        "runs": runs,
        "shown": shown,
        "plan": "at any time" if anytime else "{} runs without a failure".format(most),
        "refused": search.errors,
    }
    if anytime:
        report["lower_bound"] = lower_bound(good, runs, confidence)
    write_text(os.path.join(arguments.out, REPORT), json.dumps(report, indent=2) + "\n")
    print(_said(report))
    if first_bad is not None:
        variation, why = first_bad
        path = os.path.join(os.path.abspath(arguments.out), FAILED)
        write_text(path, varied_scenario(search.content, search.path, variation).to_yaml())
        print("  the first that failed: {} ({})".format(path, why))
    return SHOWN if shown else NOT_SHOWN


def _drawn(search, seed, most, share, confidence, anytime):
    """Return how many of how many runs were good, in the order drawn, and the first bad variation, and why.

    What a run leaves open is not shown to be kept: it counts as bad.
    """
    random, good, runs, first_bad = np.random.default_rng(seed), 0, 0, None
    while runs < most:
        batch = [_variation(search, random) for _ in range(min(BATCH, most - runs))]
        for variation, trial in zip(batch, search.tried(batch)):
            if math.isinf(trial.value):
                raise ScenarioError("a run that was drawn is refused: {}".format(trial.error))
            runs += 1
            why = _failure(search, trial)
            if why:
                first_bad = first_bad or (variation, why)
                if not anytime:
                    return good, runs, first_bad
                continue
            good += 1
            if anytime and log_evidence(good, runs, share) >= -math.log(1.0 - confidence):
                return good, runs, first_bad
    return good, runs, first_bad


def _failure(search, trial):
    """Return in words why the run of ``trial`` is not shown to keep what it should, "" where it is."""
    if trial.is_broken:
        return trial.text
    left_open = search.left_open(trial)
    if left_open:
        return "{} left open".format(", ".join(left_open))
    return "" if trial.spares else "nothing was judged"


def _variation(search, random):
    """Return the next variation, with a seed of its own where none varies: noise is drawn, too."""
    variation = search.space.variation(search.space.draw(random))
    variation.setdefault(SEED, int(random.integers(0, 2**31)))
    return variation


def _said(report):
    counted = "{} of {}".format(report["good"], report["runs"])
    confidence, share = 100.0 * report["confidence"], 100.0 * report["at_least"]
    if report["shown"]:
        text = (
            "with {:g} % confidence at least {:g} % of the runs drawn from this search keep it: {}"
        )
        return text.format(confidence, share, counted)
    text = "not shown with {:g} % confidence that at least {:g} % keep it: {}"
    return text.format(confidence, share, counted)
