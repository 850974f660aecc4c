#!/usr/bin/env python3
"""Tables of what benchmarks/history.csv has measured last, and the one command that measures.

    source build/devel/setup.bash
    python3 docs/make_speeds.py                # measures all anew, on an idle machine, and makes the pages
    python3 docs/make_speeds.py growth peers   # these programs of benchmarks/ alone

Without anything measured, ``python3 docs/make_tables.py`` makes the tables.  Rows and columns of which
nothing was measured on the machine are left out.
"""

import argparse
import os
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "benchmarks"))
import history  # noqa: E402, beside what it kept
import peers  # noqa: E402

# What is measured: programs of benchmarks/ with their arguments.
PROGRAMS = {
    "headless": (),
    "peers": (),
    "growth": (),
    "vehicles": (),
    "safety": ("--ring", "10", "30", "100"),
    "sensors": (),
    "mixed_teams": (),
    "recording": (),
    "startup": (),
    "ros_transport": ("--all",),
    "gui": ("7", "100", "1000", "--seconds", "5", "--no-stage"),
}
MACHINE = ("cpu", "cores", "versions")
WHOLE = "a run from its start, recorded"
HOOK, CROWD_RUN, LASER_RUN, PLANAR_RUN = (
    run + WHOLE[len("a run") :]
    for run in ("a law robot by robot", "a crowd", "a law that reads lasers", "the fast engine")
)
PYBULLET = "dynamic, by arrays, recorded, by wall time"
COMPILED = ", compiled"
SIZES = (7, 100, 1000)
NOT_YET = "Not measured yet on this machine."


def number(value):
    """Return ``value`` as a text of three digits, or of all of a whole number."""
    return "{:,.0f}".format(value) if abs(value) >= 99.5 else "{:.3g}".format(value)


def percent(value):
    """Return a share as a text in percent; what is below nothing by the clocks' grain as nothing."""
    return "{:.2f}".format(max(0.0, 100.0 * value))


def millions(value):
    """Return ``value`` in millions as a text."""
    return "{:.3g}".format(1e-6 * value)


def by_size(what, benchmark, sizes, lines):
    """Return a table with a column of each size: its header, and rows of a text and their cells.

    ``lines``: texts with a case each.  A cell: the key of its figure in ``newest()``, and how it is told.
    """
    header = [what, *("{:,} robots".format(n) for n in sizes)]
    return header, [(text, [((benchmark, case, n), number) for n in sizes]) for text, case in lines]


def by_measure(what, benchmark, columns, lines):
    """Return a table as ``by_size`` does, with a column of each measure.

    ``columns``: headers with the case, in which ``{}`` is the row's, and how a figure is told; ``lines``:
    texts with a case and a number of robots each.
    """
    return [what, *(header for header, _, _ in columns)], [
        (text, [((benchmark, pattern.format(case), n), told) for _, pattern, told in columns])
        for text, case, n in lines
    ]


FACTOR = "simulated seconds a second"
ROS_LINES = (
    *(("a topic of each robot, {:,}".format(n), "topics of each robot", n) for n in (7, 100, 200)),
    *(("one topic for all, {:,}".format(n), "topics of the team", n) for n in (100, 1000)),
    ("the same with recorder and GUI", "topics of the team with recorder and GUI", 1000),
)  # fmt: skip
GUI_LINES = (
    *(("{:,} robots, the map alone".format(n), "curves hidden", n) for n in SIZES),
    *(("{:,} robots, with curves".format(n), "curves visible", n) for n in SIZES),
    ("1,000 robots, 100,000 points of trails", "trails", 1000),
    ("the same, view dragged", "dragged", 1000),
    ("the same, while a run is saved", "saving", 1000),
)
COMMAND_LINES = (
    ("`mrs-simulator experiment scenarios/paper.yaml`", "the same without rosrun", 7),
    ("the same by `rosrun`", "experiment on paper.yaml", 7),
    ("110 s of 100 robots in a line", "experiment of 110 s in a line", 100),
    ("110 s of 1,000", "experiment of 110 s in a line", 1000),
    ("110 s of 100 robots in a crowd", "experiment of 110 s in a crowd", 100),
    ("110 s of 1,000", "experiment of 110 s in a crowd", 1000),
    ("an hour of 100 robots in a line", "experiment of an hour in a line", 100),
    ("an hour of 1,000", "experiment of an hour in a line", 1000),
    ("2 s of 10,000 robots in a crowd", "experiment of 2 s", 10000),
    ("a sweep of 1,000 runs of `paper.yaml` on all cores", "a sweep of 1,000 runs", 7),
)
# The tables by page and name.
TABLES = {
    "benchmarks.md": {
        "whole": by_size(
            FACTOR,
            "headless",
            (*SIZES, 10000),
            (
                ("a law robot by robot, `calculateControlLaw`, numpy alone", HOOK),
                ("a law robot by robot, `calculateControlLaw`, compiled", HOOK + COMPILED),
                ("a law in arrays, numpy alone", WHOLE),
                ("a law in arrays, compiled", WHOLE + COMPILED),
                ("a crowd that touches all the time, numpy alone", CROWD_RUN),
                ("a crowd that touches all the time, compiled", CROWD_RUN + COMPILED),
                ("lasers of 360 rays at 10 Hz that a law reads, numpy alone", LASER_RUN),
                ("lasers of 360 rays at 10 Hz that a law reads, compiled", LASER_RUN + COMPILED),
                ("wheels with forces, pybullet", PYBULLET),
                ("wheels with forces, planar engine, numpy alone", PLANAR_RUN),
                ("wheels with forces, planar engine, compiled", PLANAR_RUN + COMPILED),
            ),
        ),
        "vehicles": by_size(
            FACTOR,
            "vehicles",
            (10, 100, 1000),
            (
                (
                    "quadrotors: a run of 110 s from its start, recorded, compiled",
                    "a recorded run of quadrotors with forces",
                ),
                (
                    "quadrotors: the world in which they hover, compiled, nothing recorded",
                    "quadrotors in the world with forces",
                ),
                (
                    "vessels: the world with current, wind, gusts and waves, nothing recorded",
                    "vessels with forces",
                ),
            ),
        ),
        "commands": by_measure(
            "whole command",
            "startup",
            (
                ("wall time [s]", "{}, wall time", number),
                ("processor time [s]", "{}, processor time", number),
                ("memory [MB]", "{}, memory", millions),
            ),
            COMMAND_LINES,
        ),
        "filter": by_measure(
            "robots that cross a ring, 30 s",
            "safety",
            (
                ("with the filter [s]", "with the filter", number),
                ("without [s]", "without the filter", number),
                ("times", "with over without", number),
            ),
            [(str(n), "", n) for n in (10, 30, 100)],
        ),
        "mixed": by_measure(
            "team of 100",
            "mixed teams",
            (
                ("share by processor time", "{}, share by cpu time", number),
                ("share by wall time", "{}, share by wall time", number),
            ),
            (
                ("four kinds of one drive", "four kinds of one drive", 100),
                ("three drives: differential, omnidirectional, car", "three drives", 100),
                ("omnidirectional robots alone", "omnidirectional alone", 100),
                ("cars alone", "cars alone", 100),
            ),
        ),
        "files": by_measure(
            "run.csv of 1,000 robots",
            "recording",
            (("million rows a second", "{}", millions),),
            (
                ("written by Python alone", "written by Python alone", 1000),
                ("written with orjson", "written with orjson", 1000),
                ("read back to arrays", "read", 1000),
            ),
        ),
        "ros": by_measure(
            "robots at 50 Hz",
            "ros_transport",
            (
                ("missed periods [%]", "{}: missed periods", percent),
                ("round trip, median [ms]", "{}: round trip, median", number),
                ("99th percentile [ms]", "{}: round trip, p99", number),
                ("times a plain pair's median", "{}: round trip, median, over the echo's", number),
                ("times its 99th percentile", "{}: round trip, p99, over the echo's", number),
                ("stage's share of a core", "{}: stage's core", number),
                ("control's", "{}: control's core", number),
            ),
            ROS_LINES,
        ),
        "gui": by_measure(
            "shown",
            "gui",
            (
                ("pictures a second", "{}: pictures", number),
                ("share of a core", "{}: CPU", number),
                ("longest at work [ms]", "{}: longest at work", number),
            ),
            GUI_LINES,
        ),
    },
    "sensors.md": {
        "rays": by_measure(
            "robots x rays",
            "sensors",
            (
                ("millions of rays a second, numpy alone", "{} rays, numpy alone", millions),
                ("compiled", "{} rays, compiled", millions),
            ),
            [("{} x {}".format(n, k), str(k), n) for n in (7, 100) for k in (16, 181)],
        ),
        "pictures": by_measure(
            "picture and depth",
            "sensors",
            (
                ("picture [ms]", "picture of {}", number),
                ("its messages [ms]", "messages of a picture of {}", number),
            ),
            [(size.replace("x", " x "), size, 7) for size in ("160x120", "320x240")],
        ),
    },
}  # fmt: skip


def newest():
    """Return the newest row of each ``(benchmark, case, n)``, on the machine of the newest of all."""
    rows = history.read()
    machine = [rows[-1][key] for key in MACHINE]
    alike = [row for row in rows if [row[key] for key in MACHINE] == machine]
    return {(row["benchmark"], row["case"], int(row["n"])): row for row in alike}


def table_of(header, lines, rows):
    """Return the text of a table: ``header``, ``lines`` of a text and cells (``by_size``), of ``rows``."""
    found = [
        (text, [(rows.get(key), told) for key, told in cells])
        for text, cells in lines
        if any(key in rows for key, _ in cells)
    ]
    columns = [k for k in range(len(header) - 1) if any(cells[k][0] for _, cells in found)]
    if not found:
        return NOT_YET
    told = [["", *(header[k + 1] for k in columns)]]
    told[0][0] = header[0]
    for text, cells in found:
        values = [(cells[k][0], cells[k][1]) for k in columns]
        told.append([text, *(tell(float(row["value"])) if row else "" for row, tell in values)])
    rule = "|" + "---|" * len(told[0])
    head, *body = (
        "|{}|".format("|".join(" {} ".format(c) if c else " " for c in row)) for row in told
    )
    return "\n".join([head, rule, *body, "", conditions([r for _, c in found for r, _ in c if r])])


def conditions(used):
    """Return when, of which commits and on which machine the rows ``used`` were measured."""
    of = sorted({"{} of {}".format(row["date"][:10], row["commit"]) for row in used})
    text = "Measured on {}: {cpu}, {cores} cores, {versions}."
    return text.format(", ".join(of), **used[-1])


def newest_peers(rows):
    """Return ``{name: (case with version, sizes)}`` of the peers that were measured, newest versions."""
    found = {}
    of_peers = [key for key in rows if key[0] == "peers"]
    for _, case, n in sorted(of_peers, key=lambda key: rows[key]["date"]):
        for name in peers.ROWS:
            if case == name or case.startswith(name + " "):
                same = found.get(name, (case, ()))
                found[name] = (case, (*(same[1] if same[0] == case else ()), n))
    return found


def peer_lines(rows, size):
    """Return lines for ``by_size`` of the peers that were measured with ``size`` robots."""
    found = newest_peers(rows)
    return [
        ("{}: {}".format(found[name][0], row.included), found[name][0])
        for name, row in peers.ROWS.items()
        if name in found and size in found[name][1]
    ]


def vehicles(rows):
    """Return the table of robots in air and water, and of another simulator's."""
    header, lines = TABLES["benchmarks.md"]["vehicles"]
    sizes = (10, 100, 1000)
    of_peers = by_size(FACTOR, "peers", sizes, peer_lines(rows, sizes[0]))[1]
    return table_of(header, [*lines, *of_peers], rows)


def growth(rows):
    """Return in words how costs grow with robots and with simulated time."""
    cost = {n: row for (_, case, n), row in rows.items() if case == "a robot-step of a run"}
    if not cost:
        return NOT_YET
    value = {n: float(row["value"]) for n, row in cost.items()}
    text = "A robot-step costs {} us with 100 robots and {} us with 10,000."
    words = [text.format(*(number(value[n]) for n in (100, 10000)))]
    used = list(cost.values())
    for n in SIZES:
        start, end = "a simulated second of {} robots after ".format(n), " s"
        spans = {
            float(case[len(start) : -len(end)]): row
            for (_, case, _), row in rows.items()
            if case.startswith(start)
        }
        longest = max(spans)
        ratio = float(spans[longest]["value"]) / float(spans[600.0]["value"])
        text = (
            "A simulated second of {:,} robots costs {:.2f} times as much in {:g} h as in 10 min."
        )
        words.append(text.format(n, ratio, longest / 3600.0))
        used += spans.values()
    return "{}\n\n{}".format("\n".join(words), conditions(used))


def headline(rows):
    """Return what README says of speed."""
    ours = (
        ("this package, compiled: a law robot by robot", HOOK + COMPILED),
        ("this package: a law in arrays, numpy alone", WHOLE),
        ("**this package, compiled: a law in arrays**", WHOLE + COMPILED),
        ("this package, compiled: wheels with forces", PLANAR_RUN + COMPILED),
    )
    header, lines = by_size("times real time", "headless", SIZES, ours)
    of_peers = by_size(FACTOR, "peers", SIZES, peer_lines(rows, SIZES[0]))[1]
    return table_of(header, [*lines, *of_peers], rows)


def tables():
    """Return the text of each table: ``{page: {name: text}}``."""
    rows = newest()
    made = {
        page: {name: table_of(*table, rows) for name, table in named.items()}
        for page, named in TABLES.items()
    }
    of_peers = table_of(*by_size(FACTOR, "peers", SIZES, peer_lines(rows, SIZES[0])), rows)
    made["benchmarks.md"].update(peers=of_peers, growth=growth(rows), vehicles=vehicles(rows))
    made[os.path.join("..", "README.md")] = {"speed": headline(rows)}
    return made


def measured(program):
    """Let one program of benchmarks/ measure and keep; tell its time; return whether it did."""
    path = os.path.join(ROOT, "benchmarks", program + ".py")
    begin = time.monotonic()
    done = subprocess.run([sys.executable, path, *PROGRAMS[program], "--keep"])
    took = "{}: exit code {} after {:.0f} s".format(
        program, done.returncode, time.monotonic() - begin
    )
    print(took, flush=True)
    return done.returncode == 0


def main():
    """Measure all or what is named anew, and make tables and figure."""
    parser = argparse.ArgumentParser(description="Measure anew, and make the tables.")
    parser.add_argument("programs", nargs="*", metavar="PROGRAM", help=", ".join(PROGRAMS))
    named = parser.parse_args().programs
    unknown = sorted(set(named) - set(PROGRAMS))
    if unknown:
        parser.error("{}: wanted {}".format(", ".join(unknown), ", ".join(PROGRAMS)))
    wrong = [program for program in named or PROGRAMS if not measured(program)]
    growth_py = os.path.join(ROOT, "benchmarks", "growth.py")
    subprocess.run([sys.executable, growth_py, "--draw"], check=True)
    subprocess.run([sys.executable, os.path.join(ROOT, "docs", "make_tables.py")], check=True)
    if wrong:
        sys.exit("not measured: {}".format(", ".join(wrong)))


if __name__ == "__main__":
    main()
