"""Sweeps: one scenario under many values of its keys, run in parallel, as one table and figure."""

import copy
import csv
import itertools
import os
import re
import sys
import time
from collections import Counter

import numpy as np

from mrs_simulator.control.hooks import LawHooks
from mrs_simulator.core import compiling
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.reports import reports_kept
from mrs_simulator.core.writing import naming
from mrs_simulator.protocols.loading import choose_protocol, located_protocol
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.reading import ScenarioError, UnknownKey, load_yaml, parse_yaml
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict, scenario_of_file
from mrs_simulator.study.draw.style import can_draw
from mrs_simulator.study.run.experiment import run_experiment, steps_of
from mrs_simulator.study.run.run_keys import forget, run_key
from mrs_simulator.study.run.workers import SweepError, failed, on_cluster, on_cores
from mrs_simulator.study.search.assurance import interval
from mrs_simulator.verdict.requirements.results import known_bound
from mrs_simulator.verdict.verdict import NOT_JUDGED, PASSED, SELF_CONSISTENT, outcome_of
from mrs_simulator.verdict.verdict_file import read_verdict

TABLE = "sweep.csv"
FIGURE, MAP = "sweep", "stability"  # with the formats' suffixes
FORMATS = ("png", "pdf")
RANGE = re.compile(r"^(-?\d+)\.\.(-?\d+)$")
STEPS = re.compile(r"^([-+.\deE]+?)\.\.([-+.\deE]+)/(\d+)$")
MOST_RUNS = 100000
UNITS = {
    "control.rate": "Hz",
    "record_rate": "Hz",
    "duration": "s",
    "step": "s",
    "links.delay": "s",
    "links.delay.default": "s",
    "links.switching.dwell": "s",
    "mismatch.delay": "s",
}
PART = re.compile(r"^(\d+)/(\d+)$")
# [s] of wall time at least between two writings of the table, which grows with the runs
TABLE_EVERY = 1.0
CONFIDENCE = 0.95  # of intervals
SHOWN = 10  # reasons why runs did not pass
PROTOCOL = "control.protocol"
PARAMETERS = "control.parameters."  # before a parameter of the law
MEASURES = (
    "outcome",
    "passed",
    "settle_time",
    "y_spread",
    "min_distance",
    "stability_margin",
    "growth_rate",
    "real_time_factor",
    "ended",
)


def read_axis(text):
    """Return ``(key, values)`` of ``key=v1,v2,...``, ``key=first..last`` for whole numbers, or
    ``key=first..last/count`` for so many evenly spaced ones.

    ``key`` is the path of a scenario's key, ``control.parameters.k``, where ``sensors[0]`` is the first
    entry of a list; values are YAML, so that ``poses={layout: random, min_distance: 2.0},{layout: circle}``
    is two values.
    """
    key, equals, values = text.partition("=")
    if not equals or not key.strip() or not values.strip():
        raise SweepError(
            "--sweep {!r}: wanted key=value,value,..., key=first..last or key=first..last/count".format(
                text
            )
        )
    steps = STEPS.match(values.strip())
    if steps:
        return key.strip(), _spaced(*steps.groups(), text)
    span = RANGE.match(values.strip())
    if span:
        first, last = map(int, span.groups())
        if last < first or last - first >= MOST_RUNS:
            raise SweepError("--sweep {!r}: wanted an ascending range".format(text))
        return key.strip(), list(range(first, last + 1))
    try:
        return key.strip(), parse_yaml("[{}]".format(values), "--sweep {!r}".format(text))
    except ScenarioError as error:
        raise SweepError(str(error)) from None


def _spaced(first, last, count, text):
    """Return ``count`` numbers from ``first`` to ``last``, of 12 digits."""
    try:
        first, last, count = float(first), float(last), int(count)
    except ValueError:
        raise SweepError("--sweep {!r}: wanted numbers".format(text)) from None
    if not 2 <= count <= MOST_RUNS or not abs(first) + abs(last) < float("inf"):
        raise SweepError("--sweep {!r}: wanted from 2 to {} values".format(text, MOST_RUNS))
    step = (last - first) / (count - 1)
    return [float("{:.12g}".format(first + step * i)) for i in range(count)]


def read_part(text):
    """Return ``(i, n)`` of ``i/n``, the i-th of n parts of a sweep."""
    part = PART.match(text.strip())
    i, n = map(int, part.groups()) if part else (0, 0)
    if not 1 <= i <= n:
        raise SweepError("--part {!r}: wanted I/N, the I-th of N parts, as 1/4".format(text))
    return i, n


def make_runs(path, axes, given=None, report=None):
    """Return the runs of the scenario file ``path`` under all combinations of ``axes``.

    Each is ``(name, values by key, scenario)``; ``given``: values by key that all runs share.  A
    combination that is no scenario is refused before anything runs.  ``report(scenario, robots)`` is called
    where another number of robots is put to those that a scenario lists.  Raises ``ScenarioError``,
    ``ProtocolError`` and ``SweepError``.
    """
    given, axes = given or {}, list(axes)
    content = content_of(path, given)
    keys = [key for key, _ in axes]
    if len(set(keys)) != len(keys):
        raise SweepError("a key is swept twice: {}".format(", ".join(keys)))
    for key in given:
        if key in keys:
            raise SweepError("{} = {} is given and swept, wanted one".format(key, given[key]))
    total = 1
    for _, values in axes:
        total *= len(values)
    if not 0 < total <= MOST_RUNS:
        raise SweepError("{} runs: wanted from 1 to {}".format(total, MOST_RUNS))
    runs = []
    forget()
    for combination in itertools.product(*(values for _, values in axes)):
        values = dict(zip(keys, combination))
        try:
            scenario = _scenario_with(content, path, values, given, report)
        except UnknownKey as error:
            bare = meant(values, parameters_of(content, path))
            raise ScenarioError("{}: {}".format(path, bare) if bare else str(error)) from None
        runs.append((_name(values, scenario), values, scenario))
    _refuse_shared_mistake(runs)
    return runs


def _scenario_with(content, path, values, given, report=None):
    """Return the scenario of a file's ``content`` with ``values`` put in.

    What it lists for each robot is of the file's own number of robots: another number then changes it as
    ``Scenario.with_robots`` does.
    """
    changed, all_values = copy.deepcopy(content), {**given, **values}
    for key, value in values.items():
        put_key(changed, key, value)
    if all_values.get("fidelity", "dynamic") != "dynamic" and "engine" not in all_values:
        changed.pop("engine", None)
    where = "{} with {}".format(path, ", ".join("{}={}".format(*p) for p in all_values.items()))
    try:
        return scenario_from_dict(changed, where)._replace(path=os.path.abspath(path))
    except ScenarioError:
        if type(all_values.get("robots")) is not int or not _is_listed(content):
            raise
    del changed["robots"]
    own = scenario_from_dict(changed, where)._replace(path=os.path.abspath(path))
    if report is not None:
        report(own, all_values["robots"])
    return own.with_robots(all_values["robots"])


def parameters_of(content, path):
    """Return the names of the parameters of the law of a scenario's ``content``, of the file ``path``."""
    return [each.name for each in choose_protocol(scenario_of_file(content, path))[1].PARAMETERS]


def meant(keys, parameters):
    """Return which of the ``keys`` is one of the ``parameters`` of the law, and its path, "" if none is."""
    bare = [key for key in keys if key in parameters]
    text = "{}: wanted {}, a parameter of the law"
    return text.format(bare[0], PARAMETERS + bare[0]) if bare else ""


def _is_listed(content):
    """Return whether the robots of a scenario's ``content`` are listed one by one."""
    return isinstance(content.get("poses"), list) or "groups" in content


def theorem_boundary(path, given=None):
    """Return the boundary that the protocol of the scenario file ``path`` states, for stability maps.

    A function of (x key, y key, x values, y values, values of the other keys) that returns the
    threshold's name and its margins, (rows y, columns x), NaN where there is none.  ``given``: as in
    :func:`make_runs`.
    """
    given = given or {}
    content = content_of(path, given)

    def boundary(x, y, columns, rows, others):
        name, margins = "", np.full((len(rows), len(columns)), np.nan)
        for place in np.ndindex(margins.shape):
            values = {**others, y: rows[place[0]].item(), x: columns[place[1]].item()}
            try:
                scenario = _scenario_with(content, path, values, given)
                control = make_control(scenario)
                if type(control).stability is LawHooks.stability:  # which states none anywhere
                    break
                known = control.stability(control.points(scenario.starts))
            except (ValueError, OSError):  # beyond what the scenario or the protocol allows
                continue
            if known is not None:
                name, margins[place] = known.name, known.margin
        return name, margins

    return boundary


def _refuse_shared_mistake(runs):
    """Raise why no run can begin, if it is so: what the protocol refuses in one, others may do."""
    refused = None
    for _, _, scenario in runs:
        try:
            make_control(scenario)
            return
        except (ValueError, OSError) as error:
            refused = refused or error
    raise SweepError("no run can begin: {}".format(refused))


# no theorem was stated and tested
UNTESTED = {SELF_CONSISTENT: "self-consistent", NOT_JUDGED: "not judged"}


def summary(verdicts, drawn=False):
    """Return in lines how many runs passed, and what kept the others from it, each with a count.

    ``drawn``: whether the runs are draws, as over seeds, so that their share has an interval.
    """
    outcomes, reasons = Counter(map(outcome_of, verdicts)), Counter()
    for verdict in verdicts:
        word = UNTESTED.get(outcome_of(verdict))
        if word:
            reasons["{}: {}".format(word, verdict["reason"])] += 1
            continue
        wrong = [check["name"] for check in verdict["checks"] if check["passed"] is False]
        wrong += ["requirement " + r["name"] for r in _requirements(verdict) if r["met"] is False]
        complete = verdict["ended"] == "complete"
        reasons.update(wrong if complete else [verdict["ended"]])
    lines = ["{} of {} runs passed".format(outcomes[PASSED], len(verdicts))]
    for outcome, word in UNTESTED.items():
        lines[0] += ", {} {}".format(outcomes[outcome], word) if outcomes[outcome] else ""
    if drawn:
        share = interval(outcomes[PASSED], len(verdicts), CONFIDENCE)
        text = "  {:g} % confidence interval of the share: {:.3g} % to {:.3g} %"
        lines.append(text.format(*(100.0 * each for each in (CONFIDENCE, *share))))
    return lines + ["  {} x {}".format(count, why) for why, count in reasons.most_common(SHOWN)]


def read_setting(text):
    """Return ``(key, value)`` of ``key=value``, in YAML; a key without a dot is a parameter's name.

    Parameters are no lists or mappings: with one the key is the scenario's own, such as ``topology``.
    """
    key, equals, value = map(str.strip, text.partition("="))
    if not (key and equals and value):
        raise ScenarioError("--set {!r}: wanted NAME=VALUE or KEY=VALUE".format(text))
    value = parse_yaml(value, "--set {!r}".format(text))
    is_path = set(key) & set(".[") or isinstance(value, (dict, list))
    return key if is_path else PARAMETERS + key, value


def content_of(path, given):
    """Return the content of the scenario file ``path`` with the values ``given``, by the paths of keys.

    Under another protocol only l is left of the control's parameters, as in a single run.
    """
    content = load_yaml(path)
    if not isinstance(content, dict):
        raise ScenarioError("{}: wanted a mapping of keys".format(path))
    if PROTOCOL in given:
        other = load_scenario(path).with_protocol(located_protocol(given[PROTOCOL])).to_dict()
        content.update(title=other["title"], control=other["control"])
    for key in set(given) - {PROTOCOL}:
        put_key(content, key, given[key])
    return content


def put_key(content, key, value):
    """Set what the mapping ``content`` has under the path ``key``, such as ``control.parameters.k``."""
    *parts, last = key.split(".")
    for part in parts:
        content = _entry(content, part, key)
        if not isinstance(content, dict):
            raise SweepError("{}: {} holds no keys".format(key, part))
    if "[" in last:
        content, last = _entry(content, last, key, above=1)
    content[last] = value


def value_under(content, key, missing=None):
    """Return what ``content`` has under a path ``key`` of :func:`put_key`.

    ``missing`` where a mapping lacks it, None where the path goes through what holds no such entry.
    """
    for part in re.findall(r"\[\d+\]|[^.\[]+|\[", key):
        if isinstance(content, dict):
            if part not in content:
                return missing
            content = content[part]
        elif isinstance(content, list) and part[:1] == "[" and part[1:-1].isdigit():
            count = int(part[1:-1])
            content = content[count] if count < len(content) else None
        else:
            return None
    return content


def _entry(content, part, key, above=0):
    """Return what the mapping ``content`` has under ``part`` of a ``key``: ``sensors``, ``sensors[0]``.

    ``above=1``: the list that holds it, and its count there.
    """
    name, *counts = part.split("[")
    found, held = content.setdefault(name, {}), None
    for count in (count.rpartition("]") for count in counts):
        fits = count[1:] == ("]", "") and count[0].isdigit() and isinstance(found, list)
        if not fits or int(count[0]) >= len(found):
            raise SweepError("{}: {} is no entry of a list".format(key, part))
        held, found = (found, int(count[0])), found[int(count[0])]
    return held if above else found


def _name(values, scenario):
    """Return a directory name: readable, and other whenever anything is that decides on the run."""
    shown = "_".join("{}={}".format(k.rpartition(".")[2], v) for k, v in values.items())
    readable = re.sub(r"[^A-Za-z0-9=.+-]+", "-", shown)[:60]
    return "{}_{}".format(readable, run_key(scenario))


def run_one(scenario, out):
    """Run ``scenario`` to ``out`` and return its verdict; what was finished before is read back.

    A ``verdict.json`` that is none, or of a run that was cut short, is of no run that was finished.
    """
    try:
        verdict = read_verdict(os.path.join(out, "verdict.json"))
    except (OSError, ValueError):
        verdict = None
    if verdict is not None and verdict["ended"] == "complete":
        return verdict
    return run_experiment(scenario, out, formats=())


def run_sweep(runs, out, jobs=None, scheduler="", progress=False, boundary=None, part=None):
    """Run ``runs`` in parallel, write ``sweep.csv`` and the figures; return the verdicts.

    Figures, as PNG and PDF: ``sweep``, all checks over the swept keys, and, for two keys of numbers
    and a protocol that states a threshold, ``stability``, with the theorem's ``boundary`` from
    :func:`theorem_boundary` where it is given.

    ``jobs`` processes on this machine (default: its cores), or the Dask cluster at ``scheduler``,
    whose workers see the directory ``out`` under the same name.  Runs that an interrupted sweep has
    finished are not run again.  A run that ends its process fails, and the others go on.

    ``part`` (i, n): only the i-th of n parts, each n-th run, with a table of its own and no figures;
    parts may run at the same time.  Without it what all parts have finished is taken together.
    """
    out = os.path.abspath(out)
    os.makedirs(out, exist_ok=True)
    where = jobs, scheduler, progress, _are_many(runs)
    if part is not None:
        return _run_all(runs[part[0] - 1 :: part[1]], out, table_name(part), *where)
    for path in filter(os.path.exists, _figure_files(out)):
        os.remove(path)  # of an earlier sweep; this one may have nothing to draw
    verdicts = _run_all(runs, out, TABLE, *where)
    if can_draw():
        _write_figures(runs, verdicts, out, boundary)
    return verdicts


def table_name(part=None):
    """Return the file name of the table of a whole sweep, or of its ``part`` (i, n)."""
    return TABLE if part is None else "sweep.part-{}-of-{}.csv".format(*part)


def _are_many(runs):
    """Return whether ``runs`` are compiled, since they pay for it together."""
    many, hint = compiling.pays_together((steps_of(run), run.n) for _, _, run in runs)
    if hint:
        print("sweep: " + hint, file=sys.stderr)
    return many


def _run_all(runs, out, table, jobs, scheduler, progress, many):
    """Run ``runs``, write ``table`` and return the verdicts; ``many``: whether they are compiled."""
    verdicts, due, rows, said = [None] * len(runs), 0.0, {}, Counter()
    for row, (name, _, _) in enumerate(runs):
        rows.setdefault(name, []).append(row)  # runs alike are one
    alike = list(rows.values())
    tasks = [(runs[own[0]][2], os.path.join(out, runs[own[0]][0]), many) for own in alike]
    run = _guarded_run
    done = on_cluster(run, tasks, scheduler) if scheduler else on_cores(run, tasks, jobs)
    try:
        for row, ended in _with_progress(done, len(tasks), progress):
            # Of one whose process died there is the verdict alone.
            verdict, reports = ended if isinstance(ended, tuple) else (ended, ())
            said.update(dict.fromkeys(reports, len(alike[row])))
            for each in alike[row]:
                verdicts[each] = verdict
            if time.monotonic() >= due:  # it grows as runs end
                _write_table(runs, verdicts, out, table)
                due = time.monotonic() + TABLE_EVERY
    finally:  # so that an interruption loses nothing
        if any(verdicts):
            _write_table(runs, verdicts, out, table)
        _tell_reports(said, len(runs))
    return verdicts


def _guarded_run(scenario, out, many):
    """Return the verdict on the run, and what it reported, a list of texts."""
    with reports_kept() as reports:
        try:
            with compiling.of_many(many):
                return run_one(scenario, out), reports
        except Exception as error:  # a law of one's own may raise anything; the other runs go on
            return failed(named(error)), reports


def _tell_reports(said, total):
    """Write to stderr what runs reported, each text once, with how many of the ``total`` did."""
    for text, count in said.most_common(SHOWN):
        print("{} ({} of {} runs)".format(text, count, total), file=sys.stderr)
    if len(said) > SHOWN:
        print("experiment: {} others".format(len(said) - SHOWN), file=sys.stderr)


def _with_progress(done, total, wanted):
    if not wanted:
        return done
    from tqdm import tqdm

    return tqdm(done, total=total, unit="run")


def _write_table(runs, verdicts, out, name=TABLE):
    keys = list(runs[0][1])
    checks = []
    for verdict in filter(None, verdicts):
        checks += [c["name"] for c in verdict["checks"] if c["name"] not in checks]
    checks = [name for name in checks if name != "ended"]
    wanted = [each["name"] for each in _requirements(next(filter(None, verdicts), {}))]
    partial = os.path.join(out, name + ".part")
    path = os.path.join(out, name)
    with naming(path), open(partial, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        spare = ["robustness of " + name for name in wanted]
        table.writerow(["run"] + keys + list(MEASURES) + checks + spare)
        for (run, values, _), verdict in zip(runs, verdicts):
            if verdict is None:
                continue
            measured = {check["name"]: check["measured"] for check in verdict["checks"]}
            spared = {each["name"]: known_bound(each) for each in _requirements(verdict)}
            table.writerow(
                [run]
                + [values[key] for key in keys]
                + [_measure(verdict, key) for key in MEASURES]
                + [measured.get(check) for check in checks]
                + [spared.get(name) for name in wanted]
            )
    os.replace(partial, path)


def _requirements(verdict):
    return verdict.get("requirements", [])


def _measure(verdict, key):
    return outcome_of(verdict) if key == "outcome" else verdict.get(key)


def _write_figures(runs, verdicts, out, boundary):
    from mrs_simulator.study.draw.canvas import save  # matplotlib is slow to import
    from mrs_simulator.study.draw.sweep_figures import stability_figure, sweep_figure
    from mrs_simulator.study.results.stamp import stamp_of_all

    table = [(values, verdict) for (_, values, _), verdict in zip(runs, verdicts)]
    units = units_of(runs)
    drawn = {FIGURE: sweep_figure(table, units), MAP: stability_figure(table, boundary, units)}
    drawn = {name: figure for name, figure in drawn.items() if figure is not None}
    stamp = stamp_of_all([scenario for _, _, scenario in runs]) if drawn else ""
    for name, figure in drawn.items():
        for kind in FORMATS:
            save(figure, os.path.join(out, "{}.{}".format(name, kind)), stamp)


def units_of(runs):
    """Return the unit of each key that varies in ``runs``, "" where it has none."""
    for _, values, scenario in runs:
        try:
            control = make_control(scenario)
        except (ValueError, OSError):
            continue
        own = {"control.parameters." + p.name: p.unit for p in control.PARAMETERS if p.unit}
        return {key: {**UNITS, **own}.get(key, "") for key in values}
    return {}


def _figure_files(out):
    return [os.path.join(out, "{}.{}".format(n, kind)) for n in (FIGURE, MAP) for kind in FORMATS]
