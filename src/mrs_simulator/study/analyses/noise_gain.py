"""Noise gain of consensus: the steady variance against each kind of noise and against the gain.

Each point is the mean of several seeds, in runs as long as a variance needs, beside the theorem's curve.
"""

import argparse
import csv
import math
import os
import sys
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.claims import Condition
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.protocols.consensus.noise_equations import mode_variances, modes, sampling_error
from mrs_simulator.protocols.consensus.noisy import CERTAIN, steady_variance
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run.experiment import Experiment

PROTOCOL = "noisy_consensus"
KINDS = {"velocity": ("m/s^0.5", 0.1), "robot": ("m", 0.1), "listener": ("m", 0.1)}  # unit, level
LEVELS = (0.25, 0.5, 1.0, 1.5, 2.0)  # [-] of a kind's level
GAINS = (0.1, 0.25, 0.5, 0.75, 0.9)  # [-] of the largest stable gain, 2/(lambda_max Tc)
SEEDS = 4
TRANSIENT, MEASURED = 6.0, 200.0  # [-] time constants of the slowest mode
DENSE = 101  # points of a curve of theory


class NoiseError(ValueError):
    """A scenario whose noise gain is not known; the message says what was wanted."""

    page = "docs/edges.md#noise"


class Point(NamedTuple):
    """The steady variance of the disagreement per axis, of one kind of noise alone."""

    kind: str  # velocity, robot or listener
    swept: str  # "level" or "gain"
    level: float  # [m/s^0.5] or [m]
    gain: float  # [1/s]
    predicted: float  # [m^2]
    measured: float  # [m^2], mean over the seeds
    error: float  # [m^2], its standard deviation by theory

    @property
    def agrees(self):
        """Return whether it lies within ``CERTAIN`` standard deviations."""
        return abs(self.measured - self.predicted) <= CERTAIN * self.error


def noise_gain_study(scenario, seeds=SEEDS, levels=LEVELS, gains=GAINS):
    """Return the list of ``Point`` of ``scenario`` under each kind of noise alone.

    The level is swept at the scenario's gain, in shares ``levels`` of ``KINDS``; the gain at that level,
    in shares ``gains`` of the largest stable one.  Raises ``NoiseError`` unless the scenario is of point
    masses without limits under ``noisy_consensus`` on a connected undirected graph.
    """
    _refuse(scenario)
    values, _ = modes(scenario.topology)
    own = make_control(scenario).gain
    most = 2.0 * scenario.control.rate / values[-1]
    cases = []
    for kind, (_, level) in KINDS.items():
        cases += [(kind, "level", share * level, own) for share in levels]
        cases += [(kind, "gain", level, share * most) for share in gains]
    first = [1 + seeds * row for row in range(len(cases))]  # no two points share a seed
    return [
        _measured(scenario, *case, range(seed, seed + seeds)) for case, seed in zip(cases, first)
    ]


def _refuse(scenario):
    wanted = {
        "control.protocol: noisy_consensus": scenario.control.protocol == PROTOCOL,
        "fidelity: point_mass": scenario.fidelity == "point_mass",
        "limits: none": scenario.limits is None,
        "perfect links": not scenario.links.faults,
    }
    for name, holds in wanted.items():
        if not holds:
            raise NoiseError("{}: wanted {}".format(scenario.path or "scenario", name))
    start = hand_points(scenario.poses, scenario.hand_length)
    for claim in make_control(scenario).claims(start):
        if isinstance(claim, Condition) and not claim.holds:
            text = "{}: wanted {}: {}"
            raise NoiseError(text.format(scenario.path or "scenario", claim.name, claim.why))


def predicted_variance(scenario, kind, level, gain):
    """Return the steady variance [m^2] that theory gives the disagreement per axis."""
    period = 1.0 / scenario.control.rate
    return float(mode_variances(scenario.topology, gain, period, **{kind: level}).sum())


def _measured(scenario, kind, swept, level, gain, seeds):
    period = 1.0 / scenario.control.rate
    values, _ = modes(scenario.topology)
    kept = np.abs(1.0 - gain * period * values)
    slowest = max(float(kept.max()), 1e-12)
    commands = -1.0 / math.log(slowest)  # of the slowest mode's time constant
    begin = math.ceil(TRANSIENT * commands)
    count = max(math.ceil(MEASURED * commands), 200)
    parameters = {**scenario.control.parameters, "gain": gain}
    parameters.update({name + "_noise": level if name == kind else 0.0 for name in KINDS})
    control = scenario.control._replace(parameters=parameters)
    run = scenario._replace(
        control=control, duration=(begin + count) * period, record_rate=scenario.control.rate
    )
    found = [_variance(run, seed, begin) for seed in seeds]
    variances = mode_variances(scenario.topology, gain, period, **{kind: level})
    # Two axes and all seeds are trials of their own.
    error = sampling_error(variances, kept, count) / math.sqrt(2.0 * len(seeds))
    return Point(kind, swept, level, gain, float(variances.sum()), float(np.mean(found)), error)


def _variance(scenario, seed, begin):
    """Return the variance measured from command ``begin`` on in the run of a ``seed``."""
    parameters = {**scenario.control.parameters, "seed": seed}
    scenario = scenario._replace(control=scenario.control._replace(parameters=parameters))
    experiment = Experiment(scenario)
    pose = np.array([pose for _, pose, _ in experiment.samples()])
    experiment.world.close()
    return steady_variance(hand_points(pose, scenario.hand_length)[begin:])


def noise_figure(scenario, points):
    """Return the figure: a column for each kind of noise, variance over its level and over the gain."""
    from mrs_simulator.study.draw.canvas import WIDTH, new_figure, settle, styled

    @styled
    def drawn():
        figure = new_figure(WIDTH, 4.6)
        panels = figure.subplots(2, len(KINDS), squeeze=False)
        for column, (kind, (unit, _)) in zip(panels.T, KINDS.items()):
            for axes, swept in zip(column, ("level", "gain")):
                chosen = [p for p in points if p.kind == kind and p.swept == swept]
                _draw(axes, scenario, chosen, swept)
            column[0].set_title("noise of a {}".format(kind) if kind != "velocity" else
                                "noise on velocities", fontsize=9)  # fmt: skip
            column[0].set_xlabel("{} noise [{}]".format(kind, _unit(unit)))
            column[1].set_xlabel(r"gain $\kappa$ [1/s]")
        for axes in panels[:, 0]:
            axes.set_ylabel("steady variance [m$^2$]")
        panels[0, 0].legend(loc="upper left", fontsize=8)
        settle(figure)
        return figure

    return drawn()


def _unit(unit):
    return unit.replace("s^0.5", r"$\sqrt{\mathrm{s}}$")


def _draw(axes, scenario, points, swept):
    at = np.array([getattr(point, swept) for point in points])
    first = points[0]._asdict()
    dense = np.linspace(0.0 if swept == "level" else 0.5 * at.min(), 1.03 * at.max(), DENSE)
    theory = [
        predicted_variance(
            scenario, first["kind"], **{"level": first["level"], "gain": first["gain"], swept: x}
        )
        for x in dense
    ]
    axes.plot(dense, theory, "k--", lw=1.1, label="Theory")
    bars = [1.96 * point.error for point in points]
    style = {"fmt": "o", "ms": 4, "color": "#0072b2", "capsize": 2.5, "lw": 1.0}
    measured = [point.measured for point in points]
    axes.errorbar(at, measured, yerr=bars, label="Measured, 95 %", **style)
    axes.set_ylim(bottom=0.0)


def write_points(points, path):
    """Write ``points`` as CSV to ``path``."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*Point._fields, "agrees"])
        table.writerows([*point, point.agrees] for point in points)


@printing
def main(argv=None):
    """Run the command ``noise_gain``; exits with 0 if theory holds, 1 if not, 2 for bad input."""
    from mrs_simulator.study.draw.canvas import save

    parser = argparse.ArgumentParser(
        prog=program("noise_gain"),
        description="Measure the steady variance of consensus against each kind of noise and against "
        "the gain, and compare it with theory.",
    )
    parser.add_argument("scenario", help="YAML file, or the name of a shipped one")
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="directory for figure and table"
    )
    parser.add_argument("--seeds", type=int, default=SEEDS, metavar="N", help="runs of each point")
    arguments = parser.parse_args(argv)
    with refusing_bad_input("noise_gain"):
        if arguments.seeds < 1:
            raise NoiseError("--seeds {}: wanted at least 1".format(arguments.seeds))
        scenario = load_scenario(scenario_path(arguments.scenario))
        points = noise_gain_study(scenario, arguments.seeds)
        os.makedirs(arguments.out, exist_ok=True)
        write_points(points, os.path.join(arguments.out, "noise_gain.csv"))
        for form in ("png", "pdf"):
            save(noise_figure(scenario, points), os.path.join(arguments.out, "noise_gain." + form))
    wrong = [point for point in points if not point.agrees]
    text = "{}: {} of {} variances lie within {:g} standard deviations of theory"
    said = "FAILED" if wrong else "PASSED"
    print(text.format(said, len(points) - len(wrong), len(points), CERTAIN))
    for point in wrong:
        text = "  {0.kind} noise {0.level:g}, gain {0.gain:g}: {0.measured:.4g}, theory {0.predicted:.4g}"
        print(text.format(point) + " +- {:.2g} m^2".format(CERTAIN * point.error))
    print("  figure: {}".format(os.path.join(os.path.abspath(arguments.out), "noise_gain.png")))
    sys.exit(1 if wrong else 0)
