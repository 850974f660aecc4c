"""``check_protocol``: runs a law against its own claims, then with mistakes put in, to see them caught.

A verdict that passes says something only if a wrong law would have failed.
"""

import argparse
import contextlib
import sys
import time
from typing import Any, Dict, List, NamedTuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by, words
from mrs_simulator.core.kinematics import Limits, hand_points
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.check.check_protocol_text import (
    LIMITED,
    NOT_CLAIMS,
    POINTS,
    WHEELS,
    claim_counts,
    report_text,
)
from mrs_simulator.study.check.claim_mistakes import confirmed, mistaken
from mrs_simulator.study.check.mutants import Mutated, mutants_of
from mrs_simulator.study.results.report import judged
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.verdict import FAILED, HOLDS, outcome_of

RETURNS = " returns"  # how the name of a check ends that a method did not raise
GRAPHS = ("path", "ring", "chain")
ROBOTS = (3, 5)
SEEDS = (0, 1)
DURATION = 30.0  # [s]
MODES = {
    POINTS: {"fidelity": "point_mass", "limits": "none", "saturation": "none"},
    LIMITED: {"fidelity": "point_mass", "limits": "none", "saturation": "robot"},
    WHEELS: {"fidelity": "kinematic", "limits": "top", "saturation": "robot"},
}
LOW_LIMITS = Limits(0.4, 2.0, np.inf, np.inf)  # of LIMITED: low, so that they matter
FIELD, APART = 8.0, 1.5  # [m] of the random starts: side of the square, least distance
RAISED = "the law raised"
SAME = 1e-6  # [m] by which an edit that matters moves a robot at least
MOST_MUTATED = 2  # settings in which mistakes are put in, each on a graph of its own


class Setting(NamedTuple):
    """Where a law is tried: on which graph, with how many robots, from which start and how moved."""

    graph: str
    robots: int
    seed: int
    mode: str

    def __str__(self):
        return "{}, {} robots, seed {}, {}".format(*self)


class Trial(NamedTuple):
    """One run: its setting, its verdict, and where the hand points were, (m, n, d) [m]."""

    setting: Setting
    verdict: Dict[str, Any]
    hand: np.ndarray

    @property
    def outside(self):
        """Return the conditions of the theorem that do not hold here, by name."""
        checks = self.verdict["checks"]
        return [c["name"] for c in checks if c["predicted"] == HOLDS and c["measured"] != HOLDS]

    @property
    def raised(self):
        """Return what methods of the protocol raised, ``name: text`` of each, a list."""
        checks = self.verdict["checks"]
        return [
            "{}: {}".format(c["name"][: -len(RETURNS)], c["note"])
            for c in checks
            if c["name"].endswith(RETURNS) and c["passed"] is False
        ]

    @property
    def touched(self):
        """Return whether bodies touched: points do not, and theory speaks of points."""
        return any(c["name"] == "collisions" and c["measured"] for c in self.verdict["checks"])

    @property
    def judged(self):
        """Return whether theory speaks of this run."""
        return not self.outside and not self.touched

    def failures(self):
        """Return the checks that failed, by name; a run that did not end is one."""
        return [c["name"] for c in self.verdict["checks"] if c["passed"] is False]


class Report(NamedTuple):
    """What :func:`check_protocol` found; ``str`` of it is a page of text.

    ``trials``: of the law as it is; ``caught``: by mutant's name the names of the checks that failed,
    ``None`` where the mistake changed nothing; ``slight``: those mutants that claims of ends and rates may
    well not notice; ``refused``: settings that the law refused, and why; ``confirmed``: by claim's name the
    check that did not fail though the claim's own number was wrong.
    """

    name: str
    trials: List[Trial]
    caught: Dict[str, Any]
    refused: Dict[str, str]
    seconds: float
    slight: Any = frozenset()
    confirmed: Dict[str, Any] = {}

    @property
    def failed(self):
        """Return the trials of the law as it is that failed though theory speaks of them."""
        spoken = [t for t in self.trials if t.judged or t.raised]
        return [t for t in spoken if outcome_of(t.verdict) == FAILED]

    @property
    def survivors(self):
        """Return the mistakes that no verdict noticed, by name, but for slight ones."""
        return [name for name in self._unnoticed if name not in self.slight]

    @property
    def slight_survivors(self):
        """Return the slight mistakes that no verdict noticed, by name."""
        return [name for name in self._unnoticed if name in self.slight]

    @property
    def _unnoticed(self):
        return [name for name, checks in self.caught.items() if checks is not None and not checks]

    @property
    def blind(self):
        """Return the claims that never failed, whatever was put in, by name."""
        failed_claims = {name for checks in self.caught.values() if checks for name in checks}
        failed_claims.update(name for trial in self.failed for name in trial.failures())
        tried = [trial for trial in self.trials if trial.setting.mode == POINTS]
        return [name for name in claim_counts(tried) if name not in failed_claims]

    @property
    def ok(self):
        """Return whether no run failed, some were judged, and every mistake that matters was caught."""
        judged_runs = any(self.claims_judged(trial) for trial in self.trials)
        return judged_runs and not self.failed and not self.survivors

    @staticmethod
    def claims_judged(trial):
        """Return whether a claim of the protocol was judged in ``trial``."""
        return trial.judged and any(
            c["passed"] is not None
            for c in trial.verdict["checks"]
            if c["name"] not in NOT_CLAIMS and c["predicted"] != HOLDS
        )

    def __str__(self):
        return report_text(self)


@explained_by("docs/claims.md#would-a-wrong-law-fail")
def check_protocol(
    protocol,
    graphs=GRAPHS,
    robots=ROBOTS,
    seeds=SEEDS,
    duration=DURATION,
    parameters=None,
    base=None,
):
    """Run ``protocol`` in every setting, then with mistakes put in; return the ``Report``.

    ``protocol``: a ``PioneerControl`` subclass or its name; ``graphs``: presets; ``robots``: team
    sizes; ``seeds`` of the random starts; ``duration`` [s]; ``parameters`` by name; ``base``: a
    ``Scenario`` whose control and duration are taken instead.  Each setting is run with points, and
    from the first seed with points within low speed limits and with kinematic robots too.  Raises
    ``ValueError`` if the law refuses all settings.
    """
    begun = time.monotonic()
    law = load_protocol(protocol) if isinstance(protocol, str) else protocol
    content = _content(law, duration, parameters, base)
    trials, refused = [], {}
    for setting in (
        Setting(graph, n, seed, mode)
        for graph in graphs
        for n in robots
        for seed in seeds
        for mode in (MODES if seed == seeds[0] else (POINTS,))
    ):
        try:
            trials.append(_trial(law, content, setting))
        except ValueError as error:
            refused[str(setting)] = words(error)
    if not trials:
        raise ValueError(
            "{} refuses every setting: {}".format(law.__name__, next(iter(refused.values())))
        )
    caught, slight = _caught(law, content, trials)
    wrong = _confirmed(law, content, trials)
    seconds = time.monotonic() - begun
    return Report(law.__name__, trials, caught, refused, seconds, slight, wrong)


def assert_protocol(protocol, **options):
    """Fail a test, with the report as its message, unless :func:`check_protocol` finds ``protocol`` ok."""
    report = check_protocol(protocol, **options)
    assert report.ok, "\n" + str(report)
    return report


def _content(law, duration, parameters, base):
    """Return what the scenarios of all settings share."""
    control = {"rate": 50.0, "parameters": dict(parameters or {})}
    if base is not None:
        control["rate"], duration = base.control.rate, base.duration
        control["parameters"] = {**base.control.parameters, **(parameters or {})}
    # So named, the class keeps the parameters that are given.
    control["protocol"] = "checked:" + law.__name__
    return {"duration": duration, "control": control}


def _scenario(content, setting):
    mode = MODES[setting.mode]
    control = dict(content["control"], saturation=mode["saturation"])
    poses = {"layout": "random", "size": max(FIELD, 2.0 * setting.robots), "min_distance": APART}
    return scenario_from_dict(
        {
            **content,
            "robots": setting.robots,
            "poses": poses,
            "seed": setting.seed,
            "topology": {"preset": setting.graph},
            "fidelity": mode["fidelity"],
            "limits": mode["limits"],
            "control": control,
        },
        str(setting),
    )


def _trial(law, content, setting, mutant=None):
    """Return the ``Trial`` of ``law`` in ``setting``, with ``mutant`` in it, judged by its own claims."""
    return _tried(law, content, setting, mutant)[0]


def _tried(law, content, setting, mutant=None):
    """Return the ``Trial``, its ``Run`` and the control that made the claims."""
    scenario = _scenario(content, setting)
    experiment, judge = Experiment(scenario, law), Experiment(scenario, law).control
    if setting.mode == LIMITED:
        for control in (experiment.control, judge):
            control.set_team(Team.from_scenario(scenario, LOW_LIMITS))
    if mutant is not None and mutant.parameters:
        experiment.control.set_parameters(mutant.parameters)
    if mutant is not None and (mutant.change or mutant.late):
        experiment.control = Mutated(experiment.control, mutant)
    with mutant.edit.made() if mutant is not None and mutant.edit else contextlib.nullcontext():
        run = _run(experiment)
    return Trial(setting, judged(run, judge, derives=False)[0], run.hand), run, judge


def _run(experiment):
    """Return the ``Run`` of ``experiment``, kept in memory."""
    scenario = experiment.scenario
    rows, ended = [], "complete"
    try:
        for stamp, pose, command in experiment.samples():
            rows.append((stamp, np.array(pose), np.array(command)))
    except LawFailed as error:
        ended = str(error)
    if not rows:
        raise ValueError(ended)
    stamps, poses, commands = (np.array(column) for column in zip(*rows))
    experiment.world.close()
    hand = hand_points(poses, scenario.hand_length)
    numbers = np.arange(1, scenario.n + 1)
    meta = {"ended": ended, "lockstep": True}
    return Run(stamps, numbers, poses, hand, commands, experiment.collisions, scenario, meta)


def _caught(law, content, trials):
    """Return by mutant the checks that failed for it, where the law as it is passed; and which are slight.

    A mistake in the source that one setting noticed is not put in again.
    """
    passed = [t for t in trials if t.setting.mode == POINTS and t.judged and not t.failures()]
    chosen = {trial.setting.graph: trial for trial in passed}  # the last: the largest team
    caught, slight = {}, set()
    for trial in list(chosen.values())[:MOST_MUTATED]:
        control = Experiment(_scenario(content, trial.setting), law).control
        for mutant in mutants_of(control):
            if mutant.edit and caught.get(mutant.name):
                continue
            found = _noticed(law, content, trial, mutant)
            caught[mutant.name] = _joined(caught.get(mutant.name), found)
            slight |= {mutant.name} if mutant.slight else set()
    return caught, slight


def _noticed(law, content, trial, mutant):
    """Return the checks by name that fail for ``mutant``; None where it changes nothing."""
    try:
        other = _trial(law, content, trial.setting, mutant)
    except ValueError:
        return [RAISED]
    least = SAME if mutant.edit else 0.0
    same = other.hand.shape == trial.hand.shape and np.abs(other.hand - trial.hand).max() <= least
    return None if same else other.failures()


def _confirmed(law, content, trials):
    """Return the checks by claim's name that do not fail though the claim's own number is wrong."""
    found = {}
    for mode in (POINTS, WHEELS):
        passed = [t for t in trials if t.setting.mode == mode and t.judged and not t.failures()]
        for trial in passed[:1]:
            right, run, judge = _tried(law, content, trial.setting)
            wrong = [judged(run, mistaken(judge, sign), derives=False)[0] for sign in (1.0, -1.0)]
            found.update(confirmed(right.verdict, wrong))
    return found


def _joined(before, found):
    if before is None or found is None:
        return before if found is None else found
    return before + [name for name in found if name not in before]


@printing
def main(argv=None):
    """Run the command ``check_protocol``; exits with 0 for a law that is ok, 1 for one that is not, 2 for
    bad input."""
    parser = argparse.ArgumentParser(
        prog=program("check_protocol"),
        description="Run a protocol against its claims on several graphs, team sizes and starts, with "
        "speed limits off and on; then put mistakes in and see whether the verdict notices.",
    )
    parser.add_argument("protocol", help="a shipped one, package.module:Class or file.py:Class")
    parser.add_argument("--graphs", default=",".join(GRAPHS), help="presets of the topology")
    parser.add_argument("--robots", default=",".join(map(str, ROBOTS)), help="team sizes")
    parser.add_argument("--seeds", type=int, default=len(SEEDS), metavar="N", help="random starts")
    parser.add_argument("--duration", type=float, default=DURATION, metavar="S")
    parser.add_argument("--scenario", help="YAML file, or a shipped one, whose control is taken")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a parameter"
    )
    arguments = parser.parse_args(argv)
    with refusing_bad_input("check_protocol"):
        report = check_protocol(**_options(arguments))
    print(report)
    sys.exit(0 if report.ok else 1)


def _options(arguments):
    from mrs_simulator.study.run.sweep import read_axis

    base = load_scenario(scenario_path(arguments.scenario)) if arguments.scenario else None
    try:
        robots = [int(n) for n in arguments.robots.split(",")]
    except ValueError:
        raise ValueError("--robots {!r}: wanted whole numbers".format(arguments.robots)) from None
    return dict(
        protocol=arguments.protocol,
        graphs=arguments.graphs.split(","),
        robots=robots,
        seeds=range(arguments.seeds),
        duration=arguments.duration,
        parameters={key: values[0] for key, values in map(read_axis, arguments.set)},
        base=base,
    )
