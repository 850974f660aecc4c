"""The program ``analyse``: find out by asking what a law is, and what linear theory says of it."""

import argparse
import json
import os
import sys

import numpy as np

from mrs_simulator.core.linear_theorem import ZERO
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.protocols.loading import located_protocol
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.run.law_process import LawProcess
from mrs_simulator.verdict.derived.asking import FLYING, ideal_scenario
from mrs_simulator.verdict.derived.law_probe import SCALES, Probe, facts_of
from mrs_simulator.verdict.derived.linear_law import weights_of

REPORT = "analysis.json"
ROBOTS, TOPOLOGY, SIZE, APART = 5, "ring", 8.0, 1.0
GRADIENT = {
    True: "yes",
    False: "no",
    None: "not told: velocities jump, and stay the same between jumps",
}
MOST_LISTED = 12  # robots, or eigenvalues, of which each is printed
DIGITS = 9  # of what is printed to be pasted
RESTING = 1e-6  # [-] of the extent, to which a place of rest is found
SHOWN = 1e-9  # [-] of the largest, below which numbers are printed as zero


@printing
def main(argv=None):
    """Analyse as the command line says; exit with 0, or with 2 for bad input."""
    arguments = _arguments(argv)
    with refusing_bad_input("analyse"):
        scenario = scenario_of(arguments)
        facts, probe = analysed(scenario, arguments.seed)
        report = report_of(scenario, facts, probe)
        if arguments.out:
            os.makedirs(arguments.out, exist_ok=True)
            write_text(os.path.join(arguments.out, REPORT), json.dumps(report, indent=2) + "\n")
    print("\n".join(lines_of(scenario, facts, report)))
    sys.exit(0)


def _arguments(argv):
    parser = argparse.ArgumentParser(prog=program("analyse"), description=__doc__.split(": ")[1])
    text = "my_law.py, my_law.py:Class, a shipped protocol, or a scenario (.yaml)"
    parser.add_argument("law", help=text)
    text = "number (of a scenario: its own; else {})".format(ROBOTS)
    parser.add_argument("--robots", type=int, metavar="N", help=text)
    text = "a preset ({}; of a scenario its own)".format(TOPOLOGY)
    parser.add_argument("--topology", metavar="NAME", help=text)
    text = "of the points, unless a scenario says it (2)"
    parser.add_argument("--dimension", type=int, choices=(2, 3), help=text)
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the states (0)")
    parser.add_argument("--out", metavar="DIR", help="directory for {}".format(REPORT))
    return parser.parse_args(argv)


def scenario_of(arguments):
    """Return the ``Scenario`` with the law and the team that the ``arguments`` name."""
    law = arguments.law
    if law.endswith((".yaml", ".yml")):
        scenario = load_scenario(scenario_path(law))
        changes = {} if arguments.robots is None else {"robots": arguments.robots}
        if arguments.topology:
            changes["topology"] = {"preset": arguments.topology}
        return scenario.overridden(**changes)
    n = ROBOTS if arguments.robots is None else arguments.robots
    layout = {"layout": "random", "size": max(SIZE, 2.0 * n), "min_distance": APART}
    content = {
        "robots": n,
        "poses": layout,
        "seed": arguments.seed,
        "topology": {"preset": arguments.topology or TOPOLOGY},
        "control": {"protocol": located_protocol(law, os.getcwd())},
    }
    if arguments.dimension == 3:
        heights = np.random.default_rng(arguments.seed).uniform(APART, layout["size"], n)
        content.update(model=FLYING, altitude=heights.tolist())
        content["control"]["dimension"] = 3
    return scenario_from_dict(content, "its team")


def analysed(scenario, seed=0):
    """Return the ``Facts`` of the scenario's law, and the ``Probe`` that found them.

    The law is asked in a process of its own, without limits, edges' faults and safety filter, of
    Pioneers, in space of Crazyflies.  Raises ``ValueError``.
    """
    process, ideal = LawProcess(), ideal_scenario(scenario)
    try:

        def ask(*what):
            return process.ask("velocities", ideal, *what)

        probe = Probe(ask, process.ask("start_points", ideal), seed)
        return facts_of(probe), probe
    finally:
        process.close()


def report_of(scenario, facts, probe):
    """Return what was found as plain values."""
    report = {
        "law": scenario.control.protocol,
        "robots": scenario.n,
        "states": probe.asked,
        "depends_on": facts.memory or ("headings" if facts.headings else "positions"),
        "receives": facts.receives and _edges(np.any(facts.receives, axis=0)),
        "declared": _edges(_declared(scenario)),
        "translation": facts.translation,
        "rotation": facts.rotation,
        "gradient": facts.gradient,
        "residual": facts.residual,
        "equilibria": [_rest(*each) for each in facts.equilibria or ()],
        "equilibrium": None if facts.equilibrium is None else facts.equilibrium.tolist(),
    }
    if facts.linear is not None:
        report["theory"] = _theory(facts, scenario, probe)
    return report


def _rest(points, theorem):
    """Return an equilibrium as plain values: points [m], whether it is stable, eigenvalues [1/s]."""
    values = theorem.eigenvalues
    pairs = np.column_stack([values.real, values.imag]).tolist()
    return {"points": points.tolist(), "stable": theorem.is_stable, "eigenvalues": pairs}


def _declared(scenario):
    """Return the matrix (n, n) of who receives from whom by the topology."""
    if scenario.topology is None:
        return np.zeros((scenario.n, scenario.n), dtype=bool)
    return scenario.topology.laplacian() != 0.0


def _edges(who):
    """Return the pairs [i, j] of a matrix (n, n) that says whether robot i receives from j."""
    rows, columns = np.nonzero(np.asarray(who) & ~np.eye(len(who), dtype=bool))
    return [[int(i) + 1, int(j) + 1] for i, j in zip(rows, columns)]


def _theory(facts, scenario, probe):
    linear, period = facts.linear, 1.0 / scenario.control.rate
    values = linear.eigenvalues
    size = max(np.abs(values).max(initial=0.0), 1e-300)
    real, imag = (np.where(np.abs(x) <= ZERO * size, 0.0, x) for x in (values.real, values.imag))
    known = linear.is_stable
    return {
        "eigenvalues": np.column_stack([real, imag]).tolist(),
        "stable": known,
        "defective": linear.is_defective,
        "rate": linear.rate,
        "held_rate": linear.held_rate(period) if linear.rate else None,
        "limit": linear.limit(probe.start).tolist() if known else None,
        "drift": linear.drift.reshape(scenario.n, -1).tolist() if known else None,
        "longest_period": _finite(linear.longest_period),
        "longest_delay": _finite(linear.longest_delay),
        "largest_gain": _finite(linear.longest_period / period),
        "noise": linear.noise,
    }


def _finite(value):
    return value if np.isfinite(value) else None


def lines_of(scenario, facts, report):
    """Return the analysis in lines for a terminal."""
    rows = [("depends on", _depends(facts)), ("receives", _receives(facts, report))]
    if facts.translation is not None:
        moved = [name for name in ("translation", "rotation") if report[name]]
        rows.append(
            ("is the same under", " and ".join(moved) or "neither translation nor rotation")
        )
        rows.append(("is a gradient", GRADIENT[facts.gradient]))
        rows.append(("linear", _linear(facts)))
        if facts.equilibria:
            rows.append(("equilibria", _rests(report["equilibria"])))
    lines = ["{}, {} robots: what it is at {} probed states".format(*_subject(report))]
    lines += ["  {:18} {}".format(*row) for row in rows]
    if facts.linear is not None:
        near = "" if facts.equilibrium is None else ", linearised where it comes to rest"
        lines.append("theory derived from the law{}".format(near))
        lines += ["  {:18} {}".format(*row) for row in _theory_rows(scenario, facts, report)]
        lines += _claims(facts, report)
    return lines


def _subject(report):
    return report["law"], report["robots"], report["states"]


def _depends(facts):
    if facts.memory:
        return "{}, besides positions: no theory is derived".format(facts.memory)
    if facts.headings:
        return "headings: no law of points, no theory is derived"
    return "positions alone"


def _receives(facts, report):
    """Return who receives from whom, and where that is not the declared topology."""
    if facts.receives is None:
        return "not told: answers differ whoever moved"
    found, declared = (list(map(tuple, report[key])) for key in ("receives", "declared"))
    if not declared:
        return _pairs(found) or "from nowhere"
    missing = sorted(set(declared) - set(found))
    more = sorted(set(found) - set(declared))
    if not missing and not more:
        text = "from whom the topology declares, {} edges".format(len(found))
    else:
        text = "; ".join(
            "{}: {}".format(what, _pairs(pairs))
            for what, pairs in (("declared and not used", missing), ("used and not declared", more))
            if pairs
        )
    counts = [int(who.sum() - np.trace(who)) for who in facts.receives]
    if len(set(counts)) > 1:
        text += "; by distance: {} edges over {} times the start's extent".format(
            *(", ".join(map("{:g}".format, each)) for each in (counts, SCALES))
        )
    return text


def _pairs(pairs):
    shown = ", ".join("robot{} from robot{}".format(*pair) for pair in pairs[:MOST_LISTED])
    more = len(pairs) - MOST_LISTED
    return shown + (", and {} more".format(more) if more > 0 else "")


def _linear(facts):
    text = "u = c - M x, residual {:.1g}".format(facts.residual)
    if facts.equilibrium is None and facts.linear is not None:
        return "yes: " + text
    if facts.equilibrium is None:
        return "no (residual {:.1g}), and it does not come to rest".format(facts.residual)
    return "no (residual {:.1g})".format(facts.residual)


def _rests(equilibria):
    """Return how many kinds of ``equilibria`` were found and which are stable, in words."""
    stable = sum(each["stable"] for each in equilibria)
    text = "{} found that differ in their eigenvalues, {} of them stable"
    return text.format(len(equilibria), stable)


def _theory_rows(scenario, facts, report):
    theory, linear = report["theory"], facts.linear
    rows = [("eigenvalues of M", _values(theory["eigenvalues"]) + " 1/s")]
    if not linear.is_stable:
        return [*rows, ("stable", "no: some of it grows or goes on for ever")]
    if theory["held_rate"] is not None and not theory["held_rate"] > 0.0:
        text = "no: commands held at {:g} Hz overshoot".format(scenario.control.rate)
        rows.append(("stable", text))
    drift, ends = np.abs(theory["drift"]).max(), _ends(facts, report["robots"])
    # Where a law was linearised it rests, but for rounding.
    if facts.equilibrium is None and drift > SHOWN:
        rows += [("moves for ever", "at up to {:.4g} m/s".format(drift)), ("else ends", ends)]
    else:
        rows.append(("ends", ends))
    if theory["rate"] is None:
        return rows
    text = "{:.6g} 1/s; held at {:g} Hz {:.6g} 1/s"
    text = text.format(theory["rate"], scenario.control.rate, theory["held_rate"])
    if linear.is_defective:
        text += "; M is defective: times a polynomial of t"
    rows += [
        ("slowest decay", text),
        ("command period", "stable below {:.4g} s".format(theory["longest_period"])),
        ("delay of M x", "stable below {:.4g} s".format(theory["longest_delay"])),
        ("gain", "stable below {:.4g} times, held".format(theory["largest_gain"])),
    ]
    if theory["noise"] is not None:
        text = "variance {:.4g} m^2 of a coordinate per m^2/s of velocity noise"
        rows.append(("noise", text.format(theory["noise"])))
    return rows


def _values(values):
    """Return eigenvalues in words, equal ones once with their count."""
    texts = ["{:.4g}".format(a) if not b else "{:.4g}{:+.4g}i".format(a, b) for a, b in values]
    counted = ["{} ({})".format(each, texts.count(each)) for each in dict.fromkeys(texts)]
    more = len(counted) - MOST_LISTED
    return ", ".join(counted[:MOST_LISTED]) + (", and {} more".format(more) if more > 0 else "")


def _ends(facts, n):
    linear = facts.linear
    if not linear.zeros:
        start = "any start" if facts.equilibrium is None else "starts near it"
        return "from {} at {}".format(start, _places(linear.offset.reshape(n, -1)))
    weights = weights_of(linear.projection, n)
    if weights is None or np.ptp(weights, axis=0).max() > SHOWN:
        return "where the start's share in {} modes that stay puts it".format(linear.zeros)
    text = "each robot at {}".format(_sum(weights[0]))
    least = SHOWN * max(1.0, np.abs(linear.projection).max())
    if facts.equilibrium is not None:  # which is known to so much alone
        least = RESTING * max(1.0, np.abs(facts.equilibrium).max())
    return text + ", and its own offset" if np.abs(linear.offset).max() > least else text


def _places(points):
    """Return the ``points`` (n, d) [m] in words."""
    least = SHOWN * max(1.0, np.abs(points).max(initial=0.0))
    rounded = np.where(np.abs(points) <= least, 0.0, points)
    shown = ["({})".format(", ".join(map("{:.4g}".format, each))) for each in rounded]
    more = len(shown) - MOST_LISTED
    return ", ".join(shown[:MOST_LISTED]) + (", and {} more".format(more) if more > 0 else "")


def _sum(weights):
    """Return the sum of robots' places with these ``weights`` in words: "0.5 x1 - 0.2 x2"."""
    terms = [(w, "{:.4g} x{}".format(abs(w), i + 1)) for i, w in enumerate(weights)]
    text = "".join((" - " if w < 0.0 else " + ") + term for w, term in terms if abs(w) > SHOWN)
    return text[3:] if text.startswith(" + ") else text[1:]


def _claims(facts, report):
    """Return the lines of claims that a law may state, from the linear theory."""
    linear, n = facts.linear, report["robots"]
    if facts.equilibrium is not None or not linear.is_stable or n > MOST_LISTED:
        return []
    matrix, constant = (np.asarray(each) for each in (facts.matrix, facts.constant))
    weights = weights_of(matrix, n)
    matrix = matrix if weights is None else weights
    constant = constant if weights is None else constant.reshape(n, -1)
    size = np.abs(matrix).max()
    return [
        "as claims of the law, to be compared with the paper's:",
        "import numpy as np",
        "from mrs_simulator.core.linear_theorem import linear_theorem",
        "",
        "    def claims(self, start):",
        "        M = np.array({})".format(_numbers(matrix, size)),
        "        c = np.array({})".format(_numbers(constant, max(size, np.abs(constant).max()))),
        "        return linear_theorem(M, c).claims(start, self.period)",
    ]


def _numbers(values, size):
    """Return ``values`` in so many digits, those that are zero beside ``size`` as such."""
    rows = np.where(np.abs(values) <= SHOWN * size, 0.0, values) + 0.0
    return np.vectorize(lambda each: float("{:.{}g}".format(each, DIGITS)))(rows).tolist()
