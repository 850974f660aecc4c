"""What benchmarks measured: printed, kept in ``history.csv``, compared with earlier runs of the machine.

    report = Report("headless", keep=True)
    report.note("kinematic, by arrays", 100, 410.0, "x real time")
    report.close()

One machine is faster at one time than at another: figures are compared as multiples of a reference, a
fixed load of numpy and Python that is measured in the same run.
"""

import csv
import os
import platform
import statistics
import subprocess
import time

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PATH = os.path.join(ROOT, "benchmarks", "history.csv")
COLUMNS = (
    "date",
    "commit",
    "cpu",
    "cores",
    "versions",
    "benchmark",
    "case",
    "n",
    "value",
    "unit",
    "reference",
)
# How a value goes with the machine's speed: it grows with it, falls with it, or is what it is.
GROWS = ("x real time", "rows/s", "1/s")
FALLS = ("s", "ms", "us")
PLAIN = ("bytes", "-", "share", "x")
MOST_LOAD = 0.3  # [-] cores that others may use meanwhile
OVERRIDE = "MRS_SIMULATOR_BENCHMARK_LOAD"  # another such bound, for what compares by turns
LAST = 5  # [-] earlier entries whose median is compared with
WORSE = 1.25  # [-] from which on a change is called out


def reference():
    """Return how often a second the fixed load runs, [1/s]: half small numpy calls, half Python."""
    values, best = np.linspace(0.0, 1.0, 200), 0.0
    for _ in range(7):
        begin = time.process_time()
        for _ in range(200):
            for _ in range(20):
                np.maximum(values * values, 0.5 - values).sum()
            sum(x * x for x in range(600))
        best = max(best, 200.0 / (time.process_time() - begin))
    return best


def others_load(seconds=1.0):
    """Return how many cores are in use while this process sleeps for ``seconds``, None if unknown."""
    before = _used()
    time.sleep(seconds)
    after = _used()
    return None if before is None else (after - before) / seconds


def _used():
    """Return the time [s] that all cores together have been in use."""
    if not os.path.exists("/proc/stat"):
        return None
    with open("/proc/stat", encoding="ascii") as file:
        user, nice, system, _, _, *rest = map(int, file.readline().split()[1:9])
    return (user + nice + system + sum(rest)) / os.sysconf("SC_CLK_TCK")


def checked_load():
    """Return in a line how busy the machine is; exit where it is too busy for figures to be compared."""
    text, load = os.environ.get(OVERRIDE), others_load()
    try:
        most = MOST_LOAD if text is None else float(text)
    except ValueError:
        raise SystemExit("{}={}: wanted a number of cores".format(OVERRIDE, text)) from None
    if load is None:
        return "load unknown"
    if not load <= most:
        wanted = "{:.2f} cores are in use by others, wanted at most {:g}; {}=N allows N".format(
            load, most, OVERRIDE
        )
        raise SystemExit(wanted)
    return "load {:.2f}{}".format(load, "" if text is None else " ({}={})".format(OVERRIDE, text))


def cpu_model():
    """Return the name of the processor."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    return names[0] if names else platform.machine()


def commit():
    """Return the short name of the commit checked out, with a + where files were changed since."""
    try:
        name, own = _git("rev-parse", "--short", "HEAD"), os.path.relpath(PATH, ROOT)
        changed = _git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!" + own)
        return name + "+" * bool(changed)
    except (OSError, subprocess.SubprocessError):
        return "unknown"


def _git(*words):
    done = subprocess.run(
        ("git", "-C", ROOT) + words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True
    )
    return done.stdout.decode().strip()


def versions():
    """Return the versions that matter as one text."""
    return "python {} numpy {}".format(platform.python_version(), np.__version__)


def slowness(value, unit, speed):
    """Return ``value`` as a number that falls as the program gets better, on any machine."""
    if unit in GROWS:
        return speed / value
    if unit in FALLS:
        return value * speed
    if unit in PLAIN:
        return value
    raise ValueError("unit {!r}: wanted one of {}".format(unit, ", ".join(GROWS + FALLS + PLAIN)))


class Report:
    """Figures of one benchmark: a table on the terminal and, if wanted, rows of the history."""

    def __init__(self, benchmark, keep=False, path=PATH):
        """``benchmark``: its name; ``keep``: append what is noted to the file at ``path``.

        Exits where others use more than ``MOST_LOAD`` cores; where more are allowed, nothing is kept.
        """
        self.benchmark, self._keep, self._path = benchmark, keep, path
        if keep and OVERRIDE in os.environ:
            raise SystemExit("{}: figures of a busy machine are not kept".format(OVERRIDE))
        load = checked_load()
        machine = {"cpu": cpu_model(), "cores": str(os.cpu_count())}
        self._same = dict(
            machine,
            date=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            commit=commit(),
            versions=versions(),
            benchmark=benchmark,
            reference="{:.1f}".format(reference()),
        )
        self._before = [
            row
            for row in read(path)
            if row["benchmark"] == benchmark and all(row[key] == machine[key] for key in machine)
        ]
        self._rows = []
        text = "{cpu}, {cores} cores, {versions}, reference {reference} /s, {load}"
        print(text.format(load=load, **self._same))
        print("{:44} {:>6} {:>12} {:14} {}".format("case", "n", "value", "unit", "than before"))

    def note(self, case, n, value, unit):
        """Print ``value`` [``unit``] of ``case`` with ``n`` robots, and how it compares; return it."""
        # The best so far: something else may run on the machine for a moment.
        self._same["reference"] = "{:.1f}".format(max(reference(), float(self._same["reference"])))
        row = dict(self._same, case=case, n=str(n), value="{:.6g}".format(value), unit=unit)
        self._rows.append(row)
        line = "{:44} {:>6} {:>12.5g} {:14} {}".format(case, n, value, unit, self._compared(row))
        print(line, flush=True)
        return value

    def _compared(self, row):
        key = ("case", "n", "unit")
        alike = [old for old in self._before if all(old[name] == row[name] for name in key)][-LAST:]
        if not alike:
            return "-"
        now, before = _slowness_of(row), statistics.median(map(_slowness_of, alike))
        factor = now / before if before else 1.0
        said = " WORSE" if factor > WORSE else " better" if factor < 1.0 / WORSE else ""
        return "x {:.2f}{}".format(factor, said)

    def close(self):
        """Append the rows to the history if that was wanted."""
        if not self._keep:
            return
        new = not os.path.exists(self._path)
        with open(self._path, "a", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerows(self._rows)


def read(path=PATH):
    """Return the rows of the history, oldest first; none without a file."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _slowness_of(row):
    return slowness(float(row["value"]), row["unit"], float(row["reference"]))
