"""The report of ``check_protocol`` as a page of text, which says what to do next."""

from collections import Counter

from mrs_simulator.verdict.obedience import NAMES
from mrs_simulator.verdict.verdict import HOLDS

POINTS, LIMITED, WHEELS = "points", "points within limits", "robots"
NOT_CLAIMS = ("collisions", "ended", *NAMES)  # checks that are no protocol's
MOST_LINES = 8  # of failures of one kind


def report_text(report):
    """Return ``report`` as text: the law as it is, its claims, the mistakes put in, and a last word."""
    text = "{}: {} runs of the law as it is, {} mistakes put in, {:.1f} s"
    lines = [text.format(report.name, len(report.trials), len(report.caught), report.seconds)]
    lines += _as_it_is(report) + _claims(report) + _mistakes(report) + _false_claims(report)
    lines += ["", _last_word(report)]
    return "\n".join(lines)


def _as_it_is(report):
    spoken = [
        t
        for t in report.trials
        if t.raised or (t.judged and (report.claims_judged(t) or t.failures()))
    ]
    text = "The law as it is: {} of {} runs of which theory speaks passed."
    lines = ["", text.format(len(spoken) - len(report.failed), len(spoken))]
    for trial in report.failed[:MOST_LINES]:
        lines.append("  FAILED on {}:".format(trial.setting))
        lines += [
            "    " + _check_text(check)
            for check in trial.verdict["checks"]
            if check["passed"] is False
        ]
    if len(report.failed) > MOST_LINES:
        lines.append("  ... and {} more".format(len(report.failed) - MOST_LINES))
    reasons = Counter()
    for trial in report.trials:
        if trial.raised:
            continue
        why = ["{} does not hold".format(name) for name in trial.outside]
        if trial.touched:
            why = why or ["bodies touched, and theory speaks of points"]
        if trial.judged and not any(trial is each for each in spoken):
            why = ["no claim applies"]
        reasons.update(why)
    reasons.update("refused: " + why for why in report.refused.values())
    return lines + [
        "  {} runs not judged: {}".format(n, why) for why, n in reasons.most_common(MOST_LINES)
    ]


def _check_text(check):
    if check["predicted"] == HOLDS:
        return "{} does not hold: {}".format(check["name"], check.get("note", ""))
    numbers = [check[key] for key in ("predicted", "measured", "tolerance")]
    predicted, measured, tolerance = (
        "{:.4g}".format(value) if isinstance(value, (int, float)) else str(value)
        for value in numbers
    )
    note = check.get("note", "")
    return "{}: predicted {}{}, measured {}, tolerance {}".format(
        check["name"], note + " " if note.startswith("at ") else "", predicted, measured, tolerance
    )


def _claims(report):
    counts = claim_counts(report.trials)
    raised = sorted({text for trial in report.trials for text in trial.raised})
    if raised:
        return ["", "Methods of the law that raised, mend them first:"] + ["  " + t for t in raised]
    if not counts:
        return [
            "",
            "The law states no claims: write claims(start), else no verdict can say anything.",
        ]
    width = max(map(len, counts))
    row = "  {:" + str(width) + "} {:>7} {:>7} {:>11} {:>18}"
    lines = ["", "Its claims:"]
    lines.append(row.format("", "passed", "failed", "not judged", "mistakes noticed"))
    mattered = sum(checks is not None for checks in report.caught.values())
    for name, numbers in counts.items():
        noticed = sum(name in (checks or ()) for checks in report.caught.values())
        lines.append(row.format(name, *numbers, "{} of {}".format(noticed, mattered)))
    return lines


def _mistakes(report):
    if not report.caught:
        return ["", "No mistakes were put in: no run of points passed."]
    width = max(map(len, report.caught))
    lines = ["", "Mistakes put in, and what noticed them:"]
    for name, checks in report.caught.items():
        if checks is None:
            said = "(changes nothing in these runs)"
        else:
            slight = "nothing noticed it" if name in report.slight else "NOTHING NOTICED IT"
            said = ", ".join(checks) or slight
        lines.append("  {:{}}  {}".format(name, width, said))
    for name in report.blind:
        lines.append(
            "  never failed: {!r} could not tell any of these from the right law".format(name)
        )
    return lines


def _false_claims(report):
    """Return lines on claims whose own numbers may be wrong without any verdict that fails."""
    if not report.confirmed:
        return []
    lines = ["", "Claims that do not fail with a wrong number (rates and times 3 % off, others by"]
    lines.append("three of their tolerances): state a tighter tolerance, or a longer duration:")
    for name, check in report.confirmed.items():
        outcome = "passed" if check["passed"] else "not judged"
        lines.append("  {}: {} with {:.4g}".format(name, outcome, check["predicted"]))
    return lines


def _last_word(report):
    if any(trial.raised for trial in report.trials):
        return "NOT OK: a method of the law raised an error."
    if report.failed and all(trial.setting.mode == LIMITED for trial in report.failed):
        return (
            "NOT OK: only runs within speed limits fail. Claims that are for unlimited inputs take "
            "free=True: such runs are then not judged by them."
        )
    if report.failed:
        return (
            "NOT OK: the law does not do what its claims say, or a claim says more than its theorem. "
            "If only ends are missed, see whether a longer duration helps."
        )
    if not any(map(report.claims_judged, report.trials)):
        return "NOT OK: no claim was judged in any run."
    if report.survivors:
        return (
            "NOT OK: a law with {} would pass too. Add a claim that such a law breaks: the largest "
            "distance from the exact solution, a rate, an invariant.".format(
                " or with ".join(repr(name) for name in report.survivors)
            )
        )
    if report.slight_survivors:
        return (
            "OK, but its claims do not tell the law from one with {}: state the law a second time "
            "(published), and every command is compared with it.".format(
                " or with ".join(repr(name) for name in report.slight_survivors)
            )
        )
    return "OK: the law does what it claims, and every mistake that was put in was noticed."


def claim_counts(trials):
    """Return by claim's name how often it passed, failed and was not judged, [3], in ``trials``."""
    counts = {}
    for trial in trials:
        for check in trial.verdict["checks"]:
            if check["name"] in NOT_CLAIMS or check["predicted"] == HOLDS:
                continue
            passed = check["passed"] if trial.judged else None
            row = counts.setdefault(check["name"], [0, 0, 0])
            row[{True: 0, False: 1, None: 2}[passed]] += 1
    return counts
