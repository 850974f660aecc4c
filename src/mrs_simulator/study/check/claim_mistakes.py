"""Mistakes put into the claims of a law: theorems with other numbers, which no run should confirm."""

import copy
import re

from mrs_simulator.core.claims import Claim

SHARE = 0.03  # [-] by which rates and times are off
TOLERANCES = 3.0  # [-] of its own, by which any other prediction is off
TIMES = re.compile(r"\brate\b|\[(1|rad)/s\]$|\[s\]$")  # in names of claims about rates and times


def shift_of(claim):
    """Return by how much the prediction of ``claim`` is to be wrong, 0 for bounds, which may be wide."""
    if (
        not isinstance(claim, Claim)
        or claim.relation != "equal"
        or isinstance(claim.predicted, bool)
    ):
        return 0.0
    if TIMES.search(claim.name) and claim.predicted:
        return SHARE * abs(claim.predicted)
    return TOLERANCES * claim.tolerance


def mistaken(control, sign):
    """Return a copy of ``control`` whose claims are all wrong by :func:`shift_of`, up or down by ``sign``.

    What measures them stays as it is.
    """
    law, other = type(control), copy.copy(control)

    def all_claims(self, start):
        claims = super(wrong, self).all_claims(start)
        return [_shifted(claim, sign) for claim in claims]

    wrong = type(law.__name__, (law,), {"all_claims": all_claims, "__module__": law.__module__})
    object.__setattr__(other, "__class__", wrong)
    return other


def _shifted(claim, sign):
    shift = shift_of(claim)
    return claim._replace(predicted=claim.predicted + sign * shift) if shift else claim


def confirmed(right, wrong):
    """Return the checks, by name, of wrong claims that do not fail: they pass, or are not judged.

    ``right``: the verdict by the claims as they are, of which those are looked at that passed; ``wrong``:
    verdicts by :func:`mistaken` ones.
    """
    own = {check["name"]: check["predicted"] for check in right["checks"] if check["passed"]}
    found = {}
    for verdict in wrong:
        failed = {check["name"] for check in verdict["checks"] if check["passed"] is False}
        for check in verdict["checks"]:
            name = check["name"]
            if name in own and check["predicted"] != own[name] and name not in failed:
                found[name] = check
    return found
