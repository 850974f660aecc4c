"""The search for a run that breaks a requirement, and what is left of it when all else is taken away."""

import contextlib
import math
import multiprocessing
import time
import weakref
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.fields import counted
from mrs_simulator.core.writing import MOST_PRINTED
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.search import DEAD, EDGES, POSES, PUSHES, ROBOTS
from mrs_simulator.study.run.workers import Cores, SweepError, on_cluster
from mrs_simulator.study.search.space import varied_scenario
from mrs_simulator.study.search.trials import Trial, try_variation
from mrs_simulator.study.search.whole_steps import grain_of, rounded

SPARE = 1e-3  # [-] by more than which a shrunk run has to break what the found one breaks
RANDOM_SHARE = 0.1  # of the runs are drawn at random before the optimiser begins
SPREAD = 0.3  # [-] of the cube, the optimiser's first standard deviation
NEAR_PENALTY = 10.0  # [1/m] of robots that begin too near, which are not run
THRESHOLD = 1e-3  # [-] of what is bisected, to which the threshold is found
MOST_BISECTIONS = 20
EVERY = 2.0  # [s] of wall time between two words on how many runs there were
FEWEST_ROBOTS = 2


class Found(NamedTuple):
    """A variation that breaks something, its ``trial``, and after how many ``runs``."""

    variation: Any
    trial: Trial
    runs: int
    thresholds: Any = ()  # of (key, value that holds, value that breaks)
    duration: Any = None  # [s] that is enough


class Search:
    """Runs of one scenario's content, counted."""

    def __init__(
        self,
        content,
        path,
        space,
        jobs=None,
        scheduler="",
        report=None,
        within=False,
        kept=None,
    ):
        """``report(text)`` is called with progress; ``jobs`` and ``scheduler`` as of sweeps.

        ``within``: outside of a theorem's hypotheses nothing counts as broken; ``kept``: the ``KeptRuns``
        of an earlier search of the same, which are not run again, and of this one.
        """
        self.content, self.path, self.space, self._within = content, path, space, within
        self._scheduler, self._kept = scheduler, kept
        self._report = report or (lambda text: None)
        self.runs, self.errors, self._told_at = 0, {}, time.monotonic()
        self.printed = multiprocessing.Value("l", MOST_PRINTED)  # of the laws, left to be shown
        self._cores = Cores(jobs, self.printed)
        # Left to the interpreter's end, a pool may write to a pipe that is closed by then.
        weakref.finalize(self, self._cores.close)

    def nominal(self):
        """Return the ``Trial`` of the scenario as it is; ``ScenarioError`` where that is none."""
        trial = self.tried([{}])[0]
        if math.isinf(trial.value):
            raise ScenarioError(trial.error)
        return trial

    def left_open(self, trial):
        """Return the names of requirements that the run of ``trial`` neither met nor broke."""
        wanted = self.content.get("requirements") or ()
        return [name for name in wanted if name not in (trial.spares or {})]

    def tried(self, variations, until=None):
        """Return the ``Trial`` of each of ``variations``, in parallel."""
        trials = [self._kept and self._kept.trial(each, until) for each in variations]
        rows = [row for row, trial in enumerate(trials) if trial is None]
        tasks = [(self.content, self.path, variations[row], until, self._within) for row in rows]
        if self._scheduler and tasks:
            done = on_cluster(try_variation, tasks, self._scheduler)
        else:
            done = self._cores.run(try_variation, tasks)
        with contextlib.closing(done):  # an interruption ends what still runs
            for ended, (task, trial) in enumerate(done, self.runs + len(trials) - len(rows) + 1):
                self._tell(ended)
                dead = isinstance(trial, dict)  # as ``workers.failed`` says it
                trial = Trial(math.inf, error=trial["ended"]) if dead else trial
                trials[rows[task]] = trial
                if self._kept and not trial.error:  # another time it may be none
                    self._kept.keep(variations[rows[task]], until, trial)
        self.runs += len(trials)
        for trial in trials:
            if trial.error:
                self.errors[trial.error] = self.errors.get(trial.error, 0) + 1
        return trials

    def _tell(self, runs):
        """Say now and then how many ``runs`` have ended."""
        if time.monotonic() - self._told_at >= EVERY:
            self._told_at = time.monotonic()
            self._report(counted(runs, "run") + " so far")

    # Searching ----------------------------------------------------------------------------------

    def find(self, runs, seed, optimiser):
        """Return the first ``Found`` within so many ``runs``, None if there is none.

        ``optimiser``: "cma" or "random"; repeatable by ``seed``.
        """
        random = np.random.default_rng(seed)
        share = runs if optimiser == "random" else max(10, int(RANDOM_SHARE * runs))
        best, point, found = math.inf, None, None
        while self.runs < runs and found is None:
            if self.runs < share or point is None:
                batch = min(20, runs - self.runs)
                points = [self.space.draw(random) for _ in range(batch)]
                found, best, point = self._look(points, best, point)
            else:
                found, best, point = self._climb(runs, random, best, point)
                share = self.runs + 20  # a restart begins from other draws, too
                point = None if found is None else point
        return found

    def _look(self, points, best, place):
        """Try ``points``; return what was found, the least value and where it was."""
        variations = [self.space.variation(each) for each in points]
        trials = self.tried(variations)
        least = min(range(len(trials)), key=lambda row: trials[row].objective)
        if trials[least].objective < best:
            best, place = trials[least].objective, points[least]
            self._report("{}, {}".format(counted(self.runs, "run"), trials[least].text))
        for variation, trial in zip(variations, trials):
            if trial.is_broken:
                return Found(variation, trial, self.runs), best, place
        return None, best, place

    def _climb(self, runs, random, best, place):
        """Follow the margins downwards by CMA-ES from ``place`` until it breaks or goes no farther."""
        try:
            import cma  # optional
        except ImportError as error:
            raise SweepError("--optimiser cma: {}".format(error)) from None
        options = {"bounds": [0.0, 1.0], "verbose": -9, "seed": int(random.integers(1, 2**31))}
        options["maxfevals"] = max(1, runs - self.runs)
        strategy = cma.CMAEvolutionStrategy(np.clip(place, 0.01, 0.99), SPREAD, options)
        while not strategy.stop() and self.runs < runs:
            points = strategy.ask()
            near = [self.space.too_near(self.space.variation(each)) for each in points]
            free = [point for point, off in zip(points, near) if off == 0.0]
            before, nearest = best, None
            variations = [self.space.variation(each) for each in free]
            trials = self.tried(variations) if free else []
            for point, variation, trial in zip(free, variations, trials):
                if trial.objective < best:
                    best, place, nearest = trial.objective, point, trial
                if trial.is_broken:
                    self._report("{}, {}".format(counted(self.runs, "run"), trial.text))
                    return Found(variation, trial, self.runs), best, place
            if best < before:
                self._report("{}, {}".format(counted(self.runs, "run"), nearest.text))
            values = iter(trials)
            worst = max(
                [each.objective for each in trials if math.isfinite(each.value)], default=1.0
            )
            scores = [worst + NEAR_PENALTY * off if off else next(values).objective for off in near]
            strategy.tell(
                points, [value if math.isfinite(value) else worst + 1.0 for value in scores]
            )
        return None, best, place

    # Shrinking ----------------------------------------------------------------------------------

    def shrunk(self, found):
        """Return ``found`` with fewer robots, fewer variations, rounder numbers and a shorter run.

        Each step is kept only if the run still breaks the same by more than ``SPARE``.
        """
        name = found.trial.worst["name"]
        variation = self._smaller(found.variation, name, self._with_one_robot_less)
        variation = self._fewer_keys(variation, name)
        variation = self._smaller(variation, name, _with_one_edit_less)
        variation = self._rounder(variation, name)
        duration = self._shorter(variation, name)
        thresholds = [self._threshold(variation, key) for key in self._numbers(variation)]
        trial = self.tried([variation], duration)[0]
        kept = trial if trial.is_broken else found.trial
        return found._replace(
            variation=variation,
            trial=kept,
            thresholds=tuple(each for each in thresholds if each),
            duration=duration,
        )

    def _breaks(self, variation, name, until=None):
        if self.space.too_near(variation) > 0.0:
            return False
        trial = self.tried([variation], until)[0]
        return trial.value < -SPARE and trial.worst["name"] == name

    def _smaller(self, variation, name, all_smaller):
        """Return the first of ``all_smaller(variation)`` that breaks, made as small as it goes itself."""
        for less in all_smaller(variation):
            if self._breaks(less, name):
                return self._smaller(less, name, all_smaller)
        return variation

    def _with_one_robot_less(self, variation):
        robots, poses = self.space.search.robots, variation.get(POSES, [])
        if robots and len(poses) > max(FEWEST_ROBOTS, robots.low):
            for row in range(len(poses)):
                fewer = poses[:row] + poses[row + 1 :]
                yield {**variation, POSES: fewer, ROBOTS: len(fewer)}

    def _fewer_keys(self, variation, name):
        for key in [key for key in variation if key not in (POSES, ROBOTS)]:
            less = {other: value for other, value in variation.items() if other != key}
            if self._breaks(less, name):
                variation = less
        return variation

    def _rounder(self, variation, name):
        for key in variation:
            for digits in range(4):
                rounder = {**variation, key: _rounded(variation[key], digits)}
                if rounder[key] == variation[key]:
                    break
                if self._is_within(rounder, key) and self._breaks(rounder, name):
                    variation = rounder
                    break
        return variation

    def _is_within(self, variation, key):
        """Return whether what is rounded under ``key`` still lies within its range."""
        search, value = self.space.search, variation[key]
        if key == POSES:
            box, places = search.poses.within, np.array(value)[:, :2]
            return bool((places >= box[:2]).all() and (places <= box[2:]).all())
        if key == PUSHES:
            _, within, until = search.pushes
            return all(t <= until and max(abs(x), abs(y)) <= within for t, _, x, y in value)
        spans = {each.key: each for each in search.ranges if not each.choices}
        return key not in spans or spans[key].low <= value <= spans[key].high

    def _shorter(self, variation, name):
        """Return the shortest duration [s] of a second's digits with which it still breaks, or None."""
        trial = self.tried([variation])[0]
        decided = trial.worst and trial.worst.get("decided_at")
        if decided is None:
            return None
        duration = float(self.content.get("duration", 60.0))
        first = float(math.ceil(decided))
        for wanted in (first, first + 1.0, float(math.ceil(1.1 * decided + 1.0))):
            if 0.0 < wanted < duration and self._breaks(variation, name, wanted):
                return wanted
        return None

    def _numbers(self, variation):
        ranges = [each for each in self.space.search.ranges if each.key in variation]
        return [each.key for each in ranges if not each.choices and not each.whole]

    def _threshold(self, variation, key):
        """Return ``(key, value that holds, value that breaks)``, None where no end of the range holds."""
        span = next(each for each in self.space.search.ranges if each.key == key)
        breaks = variation[key]
        holds = [
            end
            for end in (span.low, span.high)
            if end != breaks and not self.tried([{**variation, key: end}])[0].is_broken
        ]
        if not holds:
            return None
        held = min(holds, key=lambda end: abs(end - breaks))
        grain = grain_of(key, varied_scenario(self.content, self.path, variation))
        held, breaks = rounded(held, grain), rounded(breaks, grain)
        for _ in range(MOST_BISECTIONS):
            if abs(breaks - held) <= THRESHOLD * max(abs(breaks), abs(held)):
                break
            middle = rounded(0.5 * (held + breaks), grain)
            if middle in (held, breaks):
                break
            if self.tried([{**variation, key: middle}])[0].is_broken:
                breaks = middle
            else:
                held = middle
        return key, held, breaks


def _with_one_edit_less(variation):
    """Yield ``variation`` without one of its edited edges, dead robots or pushes; one of a key is left."""
    edges = variation.get(EDGES, {})
    if sum(map(len, edges.values())) > 1:
        for key, pairs in edges.items():
            for pair in pairs:
                rest = [each for each in pairs if each != pair]
                yield {**variation, EDGES: {**edges, key: rest}}
    for key in (DEAD, PUSHES):
        own = variation.get(key, [])
        for row in range(len(own) if len(own) > 1 else 0):
            yield {**variation, key: own[:row] + own[row + 1 :]}


def _rounded(value, digits):
    if isinstance(value, list):
        return [_rounded(each, digits) for each in value]
    if isinstance(value, bool) or not isinstance(value, float):
        return value
    return round(value, digits) + 0.0
