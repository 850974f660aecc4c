"""The program ``margins``: measure how far robots may differ before a scenario's requirements break."""

import argparse
import contextlib
import json
import math
import os

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.scenario.reading import ScenarioError, load_yaml
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.draw.style import add_look, look_of
from mrs_simulator.study.results.stamp import stamp_of
from mrs_simulator.study.search.break_command import add_runs, exit_with, tell
from mrs_simulator.study.search.breaking import Search
from mrs_simulator.study.search.kept_runs import KeptRuns, search_of
from mrs_simulator.study.search.margins import Margins, acts, axes_of, refuse_impossible
from mrs_simulator.study.search.space import check_keys

REPORT, FIGURE = "margins.json", "margins"
HOLDS, IDLE = "holds", "no effect"
WIDEST = 100  # columns of a table; a wider one is listed axis by axis


@printing
def main(argv=None):
    """Measure as the command line says; exit with 0, or with 2 for bad input."""
    exit_with("margins", margins, _arguments(argv))


def _arguments(argv):
    parser = argparse.ArgumentParser(prog=program("margins"), description=__doc__.split(": ")[1])
    add_runs(parser)
    text = (
        "an axis, from the scenario's value to END: mismatch.delay=0.5; instead of the usual ones"
    )
    parser.add_argument("--along", action="append", metavar="KEY=END", help=text)
    add_look(parser)
    return parser.parse_args(argv)


def margins(arguments):
    """Run, write table and figure, print the table; return the exit code."""
    look, formats = look_of(arguments)
    path = os.path.abspath(scenario_path(arguments.scenario))
    content = load_yaml(path)
    scenario = scenario_of_file(content, path)
    wanted = None if arguments.along is None else [_along(text) for text in arguments.along]
    check_keys(dict(wanted or ()), content, path, "--along")
    axes = axes_of(scenario, content, wanted)
    if wanted:
        refuse_impossible(axes, content, path)
    kept = KeptRuns(arguments.out, search_of(content, path), tell)
    search = Search(content, path, None, arguments.jobs, arguments.scheduler, tell, kept=kept)
    found = Margins(search, axes, scenario.n).found()
    stamp = stamp_of(scenario)
    report = {"scenario": path, "stamp": stamp, "runs": search.runs, **found}
    write_text(os.path.join(arguments.out, REPORT), json.dumps(report, indent=2) + "\n")
    _draw(report, arguments.out, look._replace(stamp=stamp), formats)
    print("\n".join(lines_of(report)))
    return 0


def _along(text):
    key, _, end = text.partition("=")
    with contextlib.suppress(ValueError):
        if math.isfinite(float(end)):
            return key.strip(), float(end)
    raise ScenarioError("--along {!r}: wanted KEY=END, END a number".format(text))


def _draw(report, out, look, formats):
    if not formats:
        return
    from mrs_simulator.study.draw import canvas, margins_figure  # slow to import

    with canvas.in_style(look.style):
        figure = margins_figure.margins_figure(report, look.width)
        for kind in formats:
            path = os.path.join(out, "{}.{}".format(FIGURE, kind))
            canvas.save(figure, path, look.stamp)


def lines_of(report):
    """Return the table and what it says of dead robots and of all axes together, in lines."""
    names = list(report["nominal"])
    rows = [["", *names]] + [_cells(axis, names) for axis in report["axes"]]
    if report["dead"]:
        rows.append(["dead robot", *(_dead(report["dead"], name) for name in names)])
    lines = _table(rows)
    if max(map(len, lines)) > WIDEST:
        lines = _listed(rows)
    lines += [
        "{}: refused at some values: {}".format(axis["key"], axis["refused"])
        for axis in report["axes"]
        if axis["refused"]
    ]
    idle = list(dict.fromkeys(axis["key"] for axis in report["axes"] if not acts(axis)))
    if idle:
        text = "no effect: all have the same to spare, to the bit, at each value tried of {}"
        lines.append(text.format(", ".join(idle)))
    if report["together"]:
        lines.append(_together(report["together"]))
    if report.get("open"):  # older reports have none
        text = "not measured, since the scenario as it stands leaves it open: {}"
        lines.append(text.format(", ".join(report["open"])))
    if report["failed"]:
        lines.append("the law ended some of the runs, for one: {}".format(report["failed"]))
    return [*lines, "{} runs".format(report["runs"])]


def _table(rows):
    widths = [max(map(len, column)) for column in zip(*rows)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _listed(rows):
    """Return below the label of each row what does not hold, by name, and how many others hold."""
    (_, *names), *rows = rows
    width, lines = max(map(len, names)), []
    for label, *cells in rows:
        if set(cells) == {IDLE}:
            lines.append("{}: {}".format(label, IDLE))
            continue
        broken = [pair for pair in zip(names, cells) if pair[1] != HOLDS]
        rest = "" if broken else ": all {} hold".format(len(names))
        if broken and len(broken) < len(names):
            rest = ": {} of {} hold".format(len(names) - len(broken), len(names))
        lines.append(label + rest)
        lines += ["  {}  {}".format(name.ljust(width), cell) for name, cell in broken]
    return lines


def _cells(axis, names):
    unit = " [{}]".format(axis["unit"]) if axis["unit"] else ""
    label = "{}{} {:.4g} to {:.4g}".format(axis["key"], unit, axis["nominal"], axis["end"])
    if not axis["tried"]:
        return [label, *("refused" for _ in names)]
    if not acts(axis):
        return [label, *(IDLE for _ in names)]
    cells = [
        "breaks at {:.4g}".format(axis["breaks"][name][1]) if axis["breaks"][name] else HOLDS
        for name in names
    ]
    return [label, *cells]


def _dead(dead, name):
    """Return which robots ``name`` does not do without."""
    if all(broken is None for broken in dead.values()):
        return "not possible"
    needed = [number for number, broken in dead.items() if broken and name in broken]
    if len(needed) == len(dead):
        return "breaks, any"
    return "breaks, {}".format(" ".join(needed)) if needed else HOLDS


def _together(together):
    if together["corner"] is None:
        return "together: all hold at {} corners of these margins".format(together["corners"])
    values = ", ".join("{} {:.4g}".format(*pair) for pair in together["corner"].items())
    text = "together: {:.0f} % of each margin hold at {} corners; beyond, {} breaks first at {}"
    share = 100.0 * together["share"]
    return text.format(share, together["corners"], together["breaks"], values)
