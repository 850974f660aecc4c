"""The program ``requirements``: the signals that formulas may use, and of a scenario those that it has."""

import argparse
import contextlib

import numpy as np

from mrs_simulator.control.user_code import call
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.requirements import CURVE, OPEN, SENSOR, SIGNALS
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run.experiment import Experiment, LawFailed, played
from mrs_simulator.verdict.requirements.signals import Absent, plain_name, signal_of

ROW = "  {:28} {:6} {:8} {}"
NOT_READ = "camera"  # a type of sensors, whose least is of no use
SETTINGS = ("stamp", "place", "places", "most", "cone")  # fields beside what is measured


def listing():
    """Return the signals, their units and domains, as lines of text."""
    rows = [(name, *kind) for name, kind in {**SIGNALS, **OPEN}.items()]
    return "\n".join(_lines(rows))


def _lines(rows):
    head = ROW.format("signal", "unit", "of each", "").rstrip()
    return [head, *(ROW.format(n, unit or "-", of or "-", text) for n, unit, of, text in rows)]


def signals_of(scenario):
    """Return ``(rows, absent)`` of the signals of a ``scenario``, found by its first two samples.

    ``rows``: name, unit, domain and meaning of each that it has; ``absent``: by name why it has others not.
    """
    short = scenario._replace(
        duration=2.0 * scenario.record_period, requirements=(), record=(), events=()
    )
    run, control = played(short)
    run = run.in_space(control.dimension)
    rows, absent = [], {}
    for name, kind in SIGNALS.items():
        try:
            signal_of(name, control, run)
            rows.append((name, *kind))
        except Absent as error:
            absent[name] = str(error)
        except Exception as error:  # of the protocol's methods
            absent[name] = named(error)
    return rows + _curves(control, run, absent) + _readings(short), absent


def _curves(control, run, absent):
    try:
        curves = [each.name for each in call(control.curves, run) if each.across == "time [s]"]
    except Exception as error:  # of the protocol's method
        absent[CURVE] = named(error)
        return []
    text = "the law's curve {!r}; compared with numbers without a unit"
    return [(CURVE + "." + plain_name(each), "", None, text.format(each)) for each in curves]


def _readings(scenario):
    """Return a row of each field with numbers of the readings that all robots have."""
    experiment = Experiment(scenario)
    with contextlib.closing(experiment.world) as world:
        mounts = experiment.sensors.mounts
        experiment.watch(
            {k: [m.name for m in own if m.type != NOT_READ] for k, own in enumerate(mounts)}
        )
        with contextlib.suppress(LawFailed):
            for _ in experiment.samples():
                pass
        readings = experiment.sensors.readings(world.time)
    found = [_fields(readings.get(row, {})) for row in range(scenario.n)]
    text = "the least of it; compared with numbers without a unit"
    shared = [key for key in found[0] if all(key in each for each in found)]
    return [(".".join((SENSOR, *key)), "", OPEN[SENSOR].domain, text) for key in shared]


def _fields(readings):
    """Return the pairs of sensor and field of ``readings``, by sensor, whose values are numbers."""
    found = []
    for name, reading in readings.items():
        for field, value in (reading._asdict() if reading is not None else {}).items():
            with contextlib.suppress(TypeError, ValueError):
                np.asarray(value, dtype=float)
                found += [(name, field)] if field not in SETTINGS else []
    return found


@printing
def main(argv=None):
    """Print the signals, of a scenario those that it has, and its requirements; exit with 2 if bad."""
    parser = argparse.ArgumentParser(
        prog=program("requirements"), description="List the signals of requirements."
    )
    parser.add_argument("scenario", nargs="?", help="whose own signals and requirements are listed")
    parser.add_argument("--list", action="store_true", help="as without it: print the signals")
    arguments = parser.parse_args(argv)
    if not arguments.scenario:
        print(listing())
        return
    with refusing_bad_input("requirements"):
        scenario = load_scenario(scenario_path(arguments.scenario))
        rows, absent = signals_of(scenario)
    known = {name for name, *_ in rows}
    for each in scenario.requirements:
        print("  {}: {}".format(each.name, each.text))
        lacking = sorted(each.signals - known)
        if lacking:
            print("    is left open: the scenario has no {}".format(", ".join(lacking)))
    print("\n".join(_lines(rows)))
    if absent:
        print("not in this scenario")
    for name, why in absent.items():
        print("  {:28} {}".format(name, why))
