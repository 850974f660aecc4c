"""Consensus over lossy edges: many seeds against the expected square of the disagreement.

A single run decays faster than the mean square, which a few unlucky ones carry: one seed proves nothing.
"""

import argparse
import os
import sys

import numpy as np

from mrs_simulator.control.laws.mean_square import confidence, mean_square_rate, mean_squares
from mrs_simulator.core.claims import disagreement
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.scenario import load_scenario
from mrs_simulator.study.experiment import Experiment
from mrs_simulator.study.programs import refusing_bad_input
from mrs_simulator.study.shipped import scenario_path

SEEDS = 200
OUTSIDE = (
    0.10  # [-] of the samples that may lie outside their 95 % intervals: neighbours hang together
)
PROTOCOL = "consensus"


class LossyError(ValueError):
    """A scenario of which no mean square is known; the message says what was wanted."""


def lossy_study(scenario, seeds=SEEDS):
    """Run ``scenario`` under the first ``seeds`` seeds; return what is measured and what is expected.

    A mapping: ``time`` (m,) [s], ``squares`` (seeds, m) ``|p - mean|^2`` [m^2], their ``mean`` and
    ``half`` width of its 95 % interval, ``expected`` (m,), ``rate`` ``rho(E[W (x) W])`` for each command,
    ``typical`` the same of the median run, and ``inside``, the share of samples whose interval holds
    the expected value.  Raises ``LossyError`` unless the scenario is of point masses under consensus
    over edges that drop what is lost.
    """
    _refuse(scenario)
    runs = [_squares(scenario._replace(seed=seed)) for seed in range(seeds)]
    time, squares = runs[0][0], np.array([square for _, square in runs])
    mean, half = confidence(squares)
    gain = scenario.control.parameters.get("gain", 0.5)
    share, links = gain / scenario.control.rate, scenario.links
    graph = scenario.topology, share, links.loss.matrix(scenario.n)
    start = hand_points(scenario.poses, scenario.hand_length)
    expected = mean_squares(start, *graph, len(time), links.symmetric)
    later = slice(1, None)  # at the start all agree
    inside = np.abs(mean - expected)[later] <= half[later] + 1e-12 * expected[0]
    median = np.median(squares, axis=0)
    last = int(np.flatnonzero(median > 1e-20 * median[0])[-1])
    return {
        "time": time,
        "squares": squares,
        "mean": mean,
        "half": half,
        "expected": expected,
        "rate": mean_square_rate(*graph, links.symmetric),
        "typical": float((median[last] / median[0]) ** (1.0 / max(last, 1))),
        "inside": float(inside.mean()),
    }


def agrees(study):
    """Return whether the expected mean square lies within the intervals, but for what chance allows."""
    return study["inside"] >= 1.0 - OUTSIDE


def _refuse(scenario):
    links = scenario.links
    wanted = {
        "control.protocol: consensus": scenario.control.protocol == PROTOCOL,
        "fidelity: point_mass": scenario.fidelity == "point_mass",
        "a topology": scenario.topology is not None,
        "links.on_loss: drop": links.on_loss == "drop" and "lossy" in links.faults,
        "links without delay and switching": links.faults == "lossy",
        "links.symmetric on an undirected topology": not links.symmetric
        or (scenario.topology is not None and not scenario.topology.directed),
    }
    for name, holds in wanted.items():
        if not holds:
            raise LossyError("{}: wanted {}".format(scenario.path or "scenario", name))


def _squares(scenario):
    """Return times (m,) and squares of the disagreement (m,) at the commands of one run."""
    scenario = scenario._replace(record_rate=scenario.control.rate)
    experiment = Experiment(scenario)
    rows = [(stamp, np.array(pose)) for stamp, pose, _ in experiment.samples()]
    experiment.world.close()
    hand = hand_points(np.array([pose for _, pose in rows]), scenario.hand_length)
    return np.array([stamp for stamp, _ in rows]), disagreement(hand) ** 2


def lossy_figure(study):
    """Return the figure: all runs faint, their mean with its interval, what is expected dashed."""
    from mrs_simulator.study.figures import WIDTH, new_figure, settle, styled

    @styled
    def drawn():
        figure = new_figure(WIDTH, 3.4)
        axes = figure.add_subplot(1, 1, 1)
        time = study["time"]
        floor = 1e-12 * study["expected"][0]
        for row, square in enumerate(study["squares"][:100]):
            label = "one run" if row == 0 else "_nolegend_"
            axes.plot(time, np.maximum(square, floor), color="0.8", lw=0.5, label=label)
        low, high = study["mean"] - study["half"], study["mean"] + study["half"]
        band = {"color": "#56b4e9", "alpha": 0.6, "lw": 0.0}
        axes.fill_between(time, np.maximum(low, floor), high, label="mean, 95 %", **band)
        axes.plot(time, study["mean"], color="#0072b2", lw=1.3, label="mean of all runs")
        axes.plot(time, study["expected"], "k--", lw=1.1, label="Theory")
        axes.set_yscale("log")
        axes.set_xlim(time[0], time[-1])
        axes.set_ylim(bottom=max(floor, 0.1 * float(np.median(study["squares"][:, -1]))))
        axes.set_xlabel("time [s]")
        axes.set_ylabel(r"$|p - \bar p|^2$ [m$^2$]")
        place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 0.3}
        axes.legend(ncol=4, **place)
        settle(figure)
        return figure

    return drawn()


def main(argv=None):
    """Run the command ``lossy_edges``; exits with 0 if theory holds, 1 if not, 2 for bad input."""
    from mrs_simulator.study.figures import save

    parser = argparse.ArgumentParser(
        prog="lossy_edges",
        description="Run consensus over lossy edges under many seeds, and compare the mean square of "
        "the disagreement with theory.",
    )
    parser.add_argument("scenario", help="YAML file, or the name of a shipped one")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the figure")
    parser.add_argument("--seeds", type=int, default=SEEDS, metavar="N")
    arguments = parser.parse_args(argv)
    with refusing_bad_input("lossy_edges"):
        if arguments.seeds < 2:
            raise LossyError("--seeds {}: wanted at least 2".format(arguments.seeds))
        study = lossy_study(load_scenario(scenario_path(arguments.scenario)), arguments.seeds)
        os.makedirs(arguments.out, exist_ok=True)
        for kind in ("png", "pdf"):
            save(lossy_figure(study), os.path.join(arguments.out, "mean_square." + kind))
    text = (
        "{}: the expected mean square lies in {:.1%} of the 95 % intervals of {} runs\n"
        "  each command: rho(E[W x W]) = {:.6f}; the median run has {:.6f}\n  figure: {}"
    )
    figure = os.path.join(os.path.abspath(arguments.out), "mean_square.png")
    print(text.format("PASSED" if agrees(study) else "FAILED", study["inside"], arguments.seeds,
                      study["rate"], study["typical"], figure))  # fmt: skip
    sys.exit(0 if agrees(study) else 1)


if __name__ == "__main__":
    main()
