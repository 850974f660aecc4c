#!/usr/bin/env python3
"""Mistakes of benchmarks/mutants.yaml by the theorem's claims alone: one run, then a search.

    python3 benchmarks/mutants_broken.py consensus discrete_consensus --runs 40

A verdict holds commands to the published law, and so notices most mistakes at once.  Here requirements
are all that is known: the claims of the protocol's theorem, on points.  Each mistake first runs the
scenario as it ships.  One that keeps all claims there is searched as ``mrs-simulator break`` does without a
``search``: the law's parameters, up to ``CUT`` edges cut and ``ADDED`` added, and starts, in the theorem's
box of benchmarks/hypotheses.py; where a condition of the theorem does not hold, nothing can be broken.
The right law is searched with the same seed, and has to keep its claims: else nothing that is found in its
group counts.  Exits with 1 where it does not.
"""

import argparse
import contextlib
import io
import json
import multiprocessing
import os
import sys

import hypotheses
import mutants

CUT, ADDED = 1, 2  # [-] edges, at most
RIGHT, NOMINAL = "right law", "nominal run"


def theorem_trial(scenario):
    """Return the ``Trial`` of the theorem's claims in a run of ``scenario``."""
    from mrs_simulator.core.claims import THEOREM
    from mrs_simulator.study.run.experiment import played
    from mrs_simulator.study.search.trials import NEUTRAL, Trial, is_outside, of_checks
    from mrs_simulator.verdict.judging import judged

    verdict, _ = judged(*played(scenario))
    checks = [each for each in verdict["checks"] if each["question"] == THEOREM]
    if any(map(is_outside, checks)):
        return Trial(NEUTRAL)
    if any(each["name"] == "ended" and each["passed"] is False for each in verdict["checks"]):
        return Trial(-NEUTRAL, {"name": verdict["ended"]})
    return of_checks([each for each in checks if each["passed"] is not None])


def content_of(group):
    """Return the scenario of a ``group`` as its content, of points, and the file's path."""
    from mrs_simulator import load_scenario

    path = os.path.join(mutants.ROOT, "scenarios", mutants.groups()[group]["scenario"] + ".yaml")
    scenario = load_scenario(path)
    keys = hypotheses.points(scenario, scenario.control.protocol)
    return scenario.changed(**keys), path


def search_of(scenario, path):
    """Return the search of ``scenario`` for what breaks a claim, in this process."""
    from mrs_simulator.scenario.reading import ScenarioError
    from mrs_simulator.scenario.scenario import scenario_of_file
    from mrs_simulator.scenario.search import search_from
    from mrs_simulator.study.search import breaking, default_space, space, trials

    class ByTheorem(breaking.Search):
        def tried(self, variations, until=None):
            self.runs += len(variations)
            return list(map(self._tried, variations))

        def _tried(self, variation):
            try:
                changed = space.content_with(self.content, variation, self.path)
                return theorem_trial(scenario_of_file(changed, self.path))
            except (ScenarioError, ValueError) as error:
                return trials.Trial(float("inf"), error=str(error))

    box = [float(each) for each in hypotheses.box_of(scenario, scenario.control.protocol)]
    varied = default_space.default_search(scenario)
    varied["poses"] = {"within": box, "apart": default_space.FREE}
    if "edges" in varied:
        varied["edges"] = {"cut": CUT, "add": ADDED}
    what = space.Space(search_from(varied, path), scenario.n, scenario.topology)
    return ByTheorem(scenario.to_dict(), path, what, jobs=1)


def run(task):
    """Return what became of a ``task``, (group, edit or None, runs, seed), a plain mapping."""
    group, edit, runs, seed = task
    if edit:
        finder = mutants.Finder(edit["module"], edit["right"], edit["wrong"])
        sys.meta_path.insert(0, finder)
    found = {"group": group, "edit": edit and edit["wrong"].strip(), "error": "", "after": None}
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        try:
            search = search_of(*content_of(group))
            trial = search.tried([{}])[0]
            by, broken = NOMINAL, trial
            if not trial.is_broken:
                result = search.find(runs, seed, "cma")
                by, broken = "search", result and result.trial
            if broken:
                found.update(by=by, after=search.runs, claim=broken.worst["name"])
        except Exception as error:
            found["error"] = "{}: {}".format(type(error).__name__, error)
    return found


def tasks_of(groups, runs, seed):
    """Return the tasks of ``groups``: the right law's, and those of edits that do change something."""
    known, found = mutants.groups(), []
    for name in groups:
        edits = [each for each in known[name]["mutants"] if "survives" not in each]
        found += [(name, edit, runs, seed) for edit in [None, *edits]]
    return found


def counted(results):
    """Print a line for each group of ``results``, and return whether each right law kept its claims."""
    total, right = [0, 0, 0], True
    for group in dict.fromkeys(each["group"] for each in results):
        own = [each for each in results if each["group"] == group]
        wrong = [each for each in own if each["edit"] and not each["error"]]
        broken = [each for each in own if not each["edit"] and (each["after"] or each["error"])]
        right = right and not broken
        numbers = (
            len(wrong),
            *(sum(each.get("by") == by for each in wrong) for by in (NOMINAL, "search")),
        )
        total = [a + b for a, b in zip(total, numbers)]
        row = "{}: {} mistakes, {} by the nominal run, {} more by the search; right law {}"
        print(row.format(group, *numbers, "BROKEN" if broken else "kept"))
        for each in own:
            if each["error"] or (each["edit"] and each["after"] is None) or each in broken:
                said = each["error"] or each.get("claim") or "not found"
                print("  {}: {}".format(each["edit"] or RIGHT, said))
    print("{} mistakes, {} by the nominal run, {} more by the search".format(*total))
    return right


def main():
    """Search each mistake, and say how many one run shows, and how many more a search."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("groups", nargs="+", help="of benchmarks/mutants.yaml")
    parser.add_argument("--runs", type=int, default=40, help="of each search, at most")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument(
        "--results", default=os.devnull, help="a file to which each result is added"
    )
    arguments = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    results = []
    pool = multiprocessing.get_context("spawn").Pool(arguments.jobs, maxtasksperchild=1)
    with pool, open(arguments.results, "a") as log:
        tasks = tasks_of(arguments.groups, arguments.runs, arguments.seed)
        for result in pool.imap(run, tasks, chunksize=1):
            results.append(result)
            log.write(json.dumps(result) + "\n")
            log.flush()
    return int(not counted(results))


if __name__ == "__main__":
    sys.exit(main())
