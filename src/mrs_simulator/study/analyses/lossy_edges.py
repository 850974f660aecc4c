"""Consensus over lossy edges: many seeds against the expected square of the disagreement.

A single run decays faster than the mean square, which a few unlucky ones carry: one seed proves nothing.
"""

import argparse
import os
import sys

import numpy as np

from mrs_simulator.core.claims import disagreement
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.protocols.consensus.mean_square import confidence, mean_square_rate, mean_squares
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.log_ticks import label_log
from mrs_simulator.study.run.experiment import Experiment

SEEDS = 200
# [-] standard errors that a sample's mean may be off: samples hang together, so that a share of them
# inside their intervals would say little.
CERTAIN = 4.0
PROTOCOL = "consensus"
MEAN = "#0072b2"  # colour


class LossyError(ValueError):
    """A scenario of which no mean square is known; the message says what was wanted."""

    page = "docs/edges.md#edges-with-faults"


def lossy_study(scenario, seeds=SEEDS):
    """Run ``scenario`` under the first ``seeds`` seeds; return what is measured and what is expected.

    A mapping: ``time`` (m,) [s], ``squares`` (seeds, m) ``|p - mean|^2`` [m^2], their ``mean`` and
    ``half`` width of its 95 % interval, ``expected`` (m,), ``rate`` ``rho(E[W (x) W])`` for each command,
    ``typical`` the same of the median run, ``inside``, the share of samples whose interval holds the
    expected value, and ``off``, the most standard errors that one is off.  Raises ``LossyError``
    unless the scenario is of point masses under consensus over edges that drop what is lost.
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
    off = deviations(mean, half, expected)[later]
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
        "inside": float((off <= 1.96).mean()),
        "off": float(off.max(initial=0.0)),
    }


def deviations(mean, half, expected):
    """Return by how many standard errors each ``mean`` is off what is ``expected``, (m,) [-].

    Differences of 1e-12 of the first value are rounding.
    """
    error = np.abs(mean - expected)
    return np.where(error <= 1e-12 * expected[0], 0.0, 1.96 * error / np.maximum(half, 1e-300))


def agrees(study):
    """Return whether no mean is off by more than ``CERTAIN`` standard errors."""
    return study["off"] <= CERTAIN


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
    """Return the figure: all runs faint, their mean, theory dashed; below, the mean over theory."""
    from mrs_simulator.study.draw.canvas import WIDTH, new_figure, settle, styled

    @styled
    def drawn():
        figure = new_figure(WIDTH, 4.6)
        above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2]})
        _draw_runs(above, study)
        _draw_ratio(below, study)
        below.set_xlabel("time [s]")
        handles = {}
        for axes in (above, below):
            handles.update(dict(zip(*reversed(axes.get_legend_handles_labels()))))
        place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 0.3}
        above.legend(handles.values(), handles.keys(), ncol=4, **place)
        settle(figure)
        return figure

    return drawn()


def _draw_runs(axes, study):
    time, floor = study["time"], 1e-12 * study["expected"][0]
    for row, square in enumerate(study["squares"][:100]):
        label = "one run" if row == 0 else "_nolegend_"
        axes.plot(time, np.maximum(square, floor), color="0.8", lw=0.5, label=label)
    axes.plot(time, study["mean"], color=MEAN, lw=1.3, label="mean of all runs")
    axes.plot(time, study["expected"], "k--", lw=1.1, label="Theory")
    axes.set_yscale("log")
    label_log(axes.yaxis)
    axes.set_xlim(time[0], time[-1])
    axes.set_ylim(bottom=max(floor, 0.1 * float(np.median(study["squares"][:, -1]))))
    axes.set_ylabel(r"$|p - \bar p|^2$ [m$^2$]")


def _draw_ratio(axes, study):
    time, expected = study["time"], study["expected"]
    known = expected > 1e-12 * expected[0]
    low, mean, high = (
        (study["mean"] + share * study["half"])[known] / expected[known] for share in (-1, 0, 1)
    )
    band = {"color": "#56b4e9", "alpha": 0.6, "lw": 0.0}
    axes.fill_between(time[known], low, high, label="its 95 % interval", **band)
    axes.plot(time[known], mean, color=MEAN, lw=1.3, label="mean of all runs")
    axes.plot(time[known], np.ones(int(known.sum())), "k--", lw=1.1, label="Theory")
    axes.set_ylabel("mean over\ntheory [-]")


@printing
def main(argv=None):
    """Run the command ``lossy_edges``; exits with 0 if theory holds, 1 if not, 2 for bad input."""
    from mrs_simulator.study.draw.canvas import save

    parser = argparse.ArgumentParser(
        prog=program("lossy_edges"),
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
        "{}: the mean square of {} runs is within {:.1f} standard errors of theory (wanted {:g})\n"
        "  theory lies in {:.0%} of the 95 % intervals, which hang together\n"
        "  each command: rho(E[W x W]) = {:.6f}; the median run has {:.6f}\n  figure: {}"
    )
    figure = os.path.join(os.path.abspath(arguments.out), "mean_square.png")
    said = "PASSED" if agrees(study) else "FAILED"
    print(text.format(said, arguments.seeds, study["off"], CERTAIN, study["inside"],
                      study["rate"], study["typical"], figure))  # fmt: skip
    sys.exit(0 if agrees(study) else 1)
