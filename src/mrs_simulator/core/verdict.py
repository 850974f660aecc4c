"""The verdict on a run: what theory predicts, what was measured, and whether they agree."""

import json
import math
import os
import platform
import sys
from typing import Any, Dict, NamedTuple, Optional

import numpy as np

from mrs_simulator.core import formation
from mrs_simulator.core.parameters import checked_values
from mrs_simulator.core.recording import closest_approach
from mrs_simulator.core.scenario import DEFAULT_PROTOCOL
from mrs_simulator.version import __version__

SETTLED = 0.02  # [-] settled once the largest target error stays below this share of its start
VERSIONED = ("numpy", "matplotlib", "pybullet")


class Check(NamedTuple):
    """One comparison: passed if ``|measured - predicted| <= tolerance``."""

    name: str
    predicted: Any
    measured: Any
    tolerance: Optional[float]
    passed: bool


class Tolerances(NamedTuple):
    """How far a run may be from theory, by what moves the robots."""

    gap: float  # [m]
    spread: float  # [m]
    place: float  # [m] of each final hand point from its predicted place
    settling: float  # [-] of the predicted settling time


TOLERANCES = {
    "point_mass": Tolerances(1e-3, 1e-3, 1e-2, 0.05),
    "kinematic": Tolerances(0.01, 0.01, 0.1, 0.05),
    "dynamic": Tolerances(0.05, 0.05, 0.25, 0.25),
}
SETTLE_STEPS = 20  # [-] steps T by which settling may differ in any case


def close_check(name, predicted, measured, tolerance):
    """Return the check that ``measured`` is within ``tolerance`` of ``predicted``."""
    passed = measured is not None and abs(measured - predicted) <= tolerance
    return Check(name, predicted, measured, tolerance, bool(passed))


def judge(run, claims=()):
    """Return the verdict on ``run`` as the plain mapping that ``verdict.json`` holds.

    ``claims`` are further ``Check``s that a protocol makes of its own run.  The paper's law is
    judged where the run's scenario uses it.
    """
    checks = [close_check("collisions", 0, len(run.collisions), 0)]
    measures = {"settle_time": None, "final_gaps": None, "y_spread": None}
    scenario = run.scenario
    if scenario is not None and scenario.control.protocol == DEFAULT_PROTOCOL:
        formed, measures = _judge_formation(run)
        checks = formed + checks
    checks += list(claims)
    ended = run.meta.get("ended", "complete")
    if scenario is not None and run.time[-1] < scenario.duration - 1.0 / scenario.record_rate:
        ended = "cut short" if ended == "complete" else ended
    checks.append(Check("ended", "complete", ended, None, ended == "complete"))
    closest = closest_approach(run.pose)
    if "closest_approach" in run.meta:
        closest = min(closest, run.meta["closest_approach"])
    return {
        "passed": all(check.passed for check in checks),
        "checks": [check._asdict() for check in checks],
        **measures,
        "min_distance": closest if math.isfinite(closest) else None,
        "real_time_factor": run.meta.get("real_time_factor"),
        "seed": scenario.seed if scenario is not None else run.meta.get("seed"),
        "title": scenario.title if scenario is not None else "",
        "robots": len(run.robots),
        "duration": float(run.time[-1] - run.time[0]),
        "ended": ended,
        "warnings": list(run.meta.get("warnings", [])),
        "versions": versions(),
    }


def _judge_formation(run):
    scenario = run.scenario
    law = checked_values(formation.PARAMETERS, scenario.control.parameters, "control.parameters")
    n = len(run.robots)
    topology = formation.closure_topology(law["closure"], n, scenario.topology)
    offsets = formation.line_offsets(n, law["c"])
    start, end = run.hand[0], run.hand[-1]
    tolerance = TOLERANCES[scenario.fidelity]
    gaps, spread = formation.line_gaps(end), formation.y_spread(end)
    checks = [close_check("y spread [m]", 0.0, spread, tolerance.spread)]
    if n > 1:
        worst = float(gaps[np.argmax(np.abs(gaps - law["c"]))])
        checks.insert(0, close_check("final gap, the worst [m]", law["c"], worst, tolerance.gap))
    settle_time = _settling(run, offsets, topology)
    predicted = formation.predicted_settling(start, offsets, topology, law["k"], SETTLED)
    if predicted is not None:
        allowed = max(tolerance.settling * predicted, SETTLE_STEPS) * law["T"]
        checks.append(close_check("settling time [s]", predicted * law["T"], settle_time, allowed))
    if _keeps_its_place(scenario, law["closure"]):
        place = formation.limit(start, offsets, topology, law["k"])
        away = float(np.max(np.linalg.norm(end - place, axis=1)))
        checks.append(close_check("distance from final place [m]", 0.0, away, tolerance.place))
    measures = {"settle_time": settle_time, "final_gaps": gaps.tolist(), "y_spread": spread}
    return checks, measures


def _keeps_its_place(scenario, closure):
    # Robot n anchors the chain whatever the limits; the other closures keep a mean of all robots,
    # which limits on each robot do not.
    return closure == "chain" or scenario.limits is None or scenario.fidelity == "point_mass"


def _settling(run, offsets, topology):
    errors = [formation.error_norm(hand, offsets, topology) for hand in run.hand]
    index = formation.settling_index(errors, SETTLED)
    return None if index >= len(errors) else float(run.time[index] - run.time[0])


def versions() -> Dict[str, str]:
    """Return the versions of what makes a run what it is."""
    from importlib import metadata  # slow to import, wanted once a run

    found = {"mrs_simulator": __version__, "python": platform.python_version()}
    for name in VERSIONED:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def write_verdict(verdict, path):
    """Write ``verdict`` as JSON to ``path``, whole or not at all."""
    partial = path + ".part"
    with open(partial, "w", encoding="utf-8") as file:
        json.dump(verdict, file, indent=2, allow_nan=False)
        file.write("\n")
    os.replace(partial, path)


def verdict_text(verdict):
    """Return the verdict as a short table for a terminal."""
    lines = ["{}: {}".format(verdict["title"] or "run", _word(verdict["passed"]))]
    lines.append("  {:32} {:>12} {:>12} {:>10}".format("", "predicted", "measured", "tolerance"))
    for check in verdict["checks"]:
        cells = [_cell(check[key]) for key in ("predicted", "measured", "tolerance")]
        lines.append(
            "  {:32} {:>12} {:>12} {:>10}  {}".format(check["name"], *cells, _word(check["passed"]))
        )
    if verdict["final_gaps"]:
        gaps = verdict["final_gaps"]
        shown = ", ".join("{:.4f}".format(gap) for gap in gaps[:12])
        lines.append("  final gaps [m]: {}{}".format(shown, ", ..." if len(gaps) > 12 else ""))
    if verdict["min_distance"] is not None:
        lines.append("  closest approach of two centres: {:.3f} m".format(verdict["min_distance"]))
    if verdict["real_time_factor"]:
        lines.append("  achieved real-time factor: {:.1f}".format(verdict["real_time_factor"]))
    lines += ["  warning: " + warning for warning in verdict["warnings"]]
    return "\n".join(lines)


def _word(passed):
    return "PASSED" if passed else "FAILED"


def _cell(value):
    if value is None:
        return "-"
    return "{:.4f}".format(value) if isinstance(value, float) else str(value)


def main():
    """Print the verdict in the file that the command line names; exits with 0 passed, 1 failed."""
    with open(sys.argv[1], encoding="utf-8") as file:
        verdict = json.load(file)
    print(verdict_text(verdict))
    sys.exit(0 if verdict["passed"] else 1)


if __name__ == "__main__":
    main()
