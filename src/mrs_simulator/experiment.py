"""Headless experiments: the world and the control in lockstep in one process, without a master."""

import argparse
import os
import signal
import sys
import time
import traceback

import numpy as np

from mrs_simulator.commands import refusing_bad_input
from mrs_simulator.control.loading import choose_protocol
from mrs_simulator.core.interruptions import failure
from mrs_simulator.core.recording import read_run_csv, write_facts
from mrs_simulator.core.scenario import FARTHEST, load_scenario
from mrs_simulator.core.verdict import verdict_text
from mrs_simulator.reporting import begin_run, make_control, write_report
from mrs_simulator.shipped import scenario_path
from mrs_simulator.world.world import EVERY, World

PROGRESS_AFTER = 2.0  # [s] of wall time before a progress bar appears


class LawFailed(RuntimeError):
    """The protocol raised, or returned no usable commands; the run ends there."""


class Experiment:
    """A world and a control; ``run`` closes the loop between them."""

    def __init__(self, scenario, protocol=None):
        """``protocol``: a ``PioneerControl`` subclass, by default the one the scenario names."""
        scenario, protocol = choose_protocol(scenario, protocol)
        self.scenario = scenario
        self.world = World.from_scenario(scenario)
        self.control = make_control(scenario, protocol)
        self.collisions = []
        self.warnings = self.control.warnings(scenario.poses)

    def samples(self):
        """Step through the scenario; yield ``(time, pose, command)`` at the recorded steps.

        ``time`` [s], ``pose`` (n, 3) in the common frame, ``command`` (n, 2) held from then on.
        Raises ``LawFailed`` after all robots were told to stop.
        """
        scenario, world = self.scenario, self.world
        self.control.start()
        steps = int(round(scenario.duration / scenario.step))
        for step in range(steps + 1):
            if step % scenario.steps_per_command == 0:
                world.set_commands(EVERY, self._command(world.estimate()))
            if step % scenario.steps_per_record == 0:
                self._check_near(world)
                yield world.time, world.pose, world.command
            if step < steps:
                world.step()
                self.collisions.extend(world.take_collisions())

    def _check_near(self, world):
        far = np.flatnonzero(~(np.abs(world.pose[:, :2]) <= FARTHEST).all(axis=1))
        if len(far):
            world.set_commands(EVERY, np.zeros((self.scenario.n, 2)))
            text = "at {:.3f} s robot{} was more than {:g} m away: the team is driven apart"
            raise LawFailed(text.format(world.time, far[0] + 1, FARTHEST))

    def _command(self, pose):
        try:
            return self.control.commands(pose, self.world.time)
        except (Exception, SystemExit) as error:
            self.world.set_commands(EVERY, np.zeros((self.scenario.n, 2)))
            text = "at {:.3f} s {}".format(self.world.time, failure(error))
            raise LawFailed(text) from error


def run_experiment(scenario, out, protocol=None, progress=False, formats=("png", "pdf")):
    """Run ``scenario``, write everything to the directory ``out`` and return the verdict.

    Writes ``scenario.yaml`` and, as it goes, ``run.csv``; then ``run.json``, the figures and
    ``verdict.json``.  A run that is interrupted or whose law fails is reported as far as it
    went; ``verdict["ended"]`` says which.
    """
    experiment = Experiment(scenario, protocol)
    scenario = experiment.scenario
    started, ended = time.monotonic(), "complete"
    with begin_run(scenario, out) as recorder:
        try:
            for stamp, pose, command in _with_progress(experiment.samples(), scenario, progress):
                recorder.sample(stamp, pose, command)
        except KeyboardInterrupt:
            ended = "interrupted"
        except LawFailed as error:
            ended = str(error)
            world = experiment.world
            if world.time == 0.0:  # where the robots stand is known all the same
                recorder.sample(world.time, world.pose, world.command)
            if error.__cause__:
                cause = error.__cause__
                traceback.print_exception(type(cause), cause, cause.__traceback__)
    wall = time.monotonic() - started
    meta = {
        "real_time_factor": experiment.world.time / wall,
        "closest_approach": experiment.world.closest_approach,
        "warnings": experiment.warnings,
        "ended": ended,
    }
    experiment.world.close()
    write_facts(recorder.path, experiment.collisions, meta)
    run = read_run_csv(recorder.path, scenario)
    return write_report(run, out, formats, experiment.control)


def _with_progress(samples, scenario, wanted):
    if not wanted:
        return samples
    from tqdm import tqdm  # only a terminal needs it

    total = int(scenario.duration / scenario.step) // scenario.steps_per_record + 1
    return tqdm(samples, total=total, unit="sample", delay=PROGRESS_AFTER, leave=False)


def main(argv=None):
    """Run the command ``experiment``; exits with 0 passed, 1 failed verdict, 2 bad input."""
    arguments = _arguments(argv)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        with refusing_bad_input("experiment"):
            if arguments.sweep:
                sys.exit(_sweep(arguments))
            scenario = _scenario(arguments)
            verdict = run_experiment(scenario, arguments.out, progress=sys.stderr.isatty())
    except KeyboardInterrupt:
        sys.exit(130)
    print(verdict_text(verdict))
    print("  figures and data: {}".format(os.path.abspath(arguments.out)))
    sys.exit(
        {"complete": 0 if verdict["passed"] else 1, "interrupted": 130}.get(verdict["ended"], 1)
    )


def _sweep(arguments):
    """Run the sweep and say how many passed, and why not the others; return the exit code."""
    from mrs_simulator import sweep

    given = _given(arguments, ("robots", "duration", "fidelity", "seed"))
    if arguments.protocol:
        given[sweep.PROTOCOL] = arguments.protocol
    axes = map(sweep.read_axis, arguments.sweep)
    runs = sweep.make_runs(scenario_path(arguments.scenario), axes, given)
    table = os.path.join(os.path.abspath(arguments.out), sweep.TABLE)
    options = (arguments.out, arguments.jobs, arguments.scheduler)
    try:
        verdicts = sweep.run_sweep(runs, *options, progress=sys.stderr.isatty())
    except KeyboardInterrupt:
        text = "experiment: interrupted; what has ended is in {}, the same command does the rest"
        print(text.format(table), file=sys.stderr)
        raise
    print("\n".join(sweep.summary(verdicts)))
    print("  table: {}".format(table))
    figure = os.path.join(os.path.dirname(table), sweep.FIGURE + ".png")
    if os.path.exists(figure):
        print("  figure: {}".format(figure))
    return 0 if all(verdict["passed"] for verdict in verdicts) else 1


def _scenario(arguments):
    scenario = load_scenario(scenario_path(arguments.scenario))
    if arguments.robots is not None:
        _tell_added(scenario, arguments.robots)
        scenario = scenario.with_robots(arguments.robots)
    if arguments.protocol:
        scenario = scenario.with_protocol(arguments.protocol)
    given = _given(arguments, ("duration", "fidelity", "seed"))
    return scenario.changed(**given) if given else scenario


def _tell_added(scenario, robots):
    """Say on stderr what robots that the scenario does not have begin with, and that they lack edges."""
    if robots > scenario.n:
        lonely = ", without edges of the topology" if scenario.topology else ""
        text = "experiment: robots {} to {} are not in the scenario: put where there is room{}"
        print(text.format(scenario.n + 1, robots, lonely), file=sys.stderr)


def _given(arguments, names):
    """Return the ``arguments`` called ``names`` that are given, by name."""
    values = {name: getattr(arguments, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _arguments(argv):
    parser = argparse.ArgumentParser(
        prog="experiment",
        description="Run a scenario headless, as fast as possible, and write run.csv, "
        "figures and verdict.json. Needs no ROS master.",
    )
    parser.add_argument("scenario", help="YAML file, or the name of a shipped one")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the results")
    parser.add_argument("--robots", type=int, metavar="N", help="number of robots")
    parser.add_argument("--protocol", help="a shipped one, package.module:Class or file.py:Class")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated seconds")
    parser.add_argument("--fidelity", help="kinematic, dynamic or point_mass")
    parser.add_argument("--seed", type=int)
    parser.add_argument(
        "--sweep",
        action="append",
        metavar="KEY=VALUES",
        help="run under all values of a scenario's key: control.parameters.k=0.01,0.02 or "
        "seed=0..9; may be given several times for all combinations",
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="processes of a sweep")
    parser.add_argument("--scheduler", default="", help="address of a Dask scheduler for a sweep")
    return parser.parse_args(argv)


if __name__ == "__main__":
    main()
