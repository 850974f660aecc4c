"""Claims of shipped protocols about runs that show little or nothing: none raises, each has an outcome."""

import numpy as np
import pytest
from protocol_fixtures import shipped, verdict_of
from test_protocols_mixed import ANYBODY, OTHER_NAMES

from mrs_simulator.protocols import HOMES
from mrs_simulator.record.recording import part_of
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.theory import theorem
from mrs_simulator.verdict.verdict import BROKEN, FAILED, NOT_JUDGED

NO_EDGES = {"topology": {"edges": [], "directed": False}}


def run_of(name, out, **changes):
    scenario = shipped(OTHER_NAMES.get(name, name), **changes)
    return perform(scenario._replace(duration=0.2), str(out))


def placed(run, hand):
    """Return ``run`` with its points at ``hand`` (m, n, d) and its robots as far from them as before."""
    pose = run.pose.copy()
    pose[:, :, :2] += (hand - run.hand)[:, :, :2]
    return run._replace(pose=pose, hand=hand)


def growing(run, factor):
    away = np.geomspace(1.0, factor, len(run.time))[:, np.newaxis, np.newaxis]
    return placed(run, run.hand * away)


def lost(run):
    hand = run.hand.copy()
    hand[len(hand) // 2 :] = np.nan
    return placed(run, hand)


CASES = {
    "one sample": lambda run: part_of(run, slice(0, 1)),
    "two samples": lambda run: part_of(run, slice(0, 2)),
    "robots in one place": lambda run: placed(run, np.repeat(run.hand[:, :1], len(run.robots), 1)),
    "robots at rest": lambda run: placed(run, np.repeat(run.hand[:1], len(run.time), 0)),
    "robots driven apart": lambda run: growing(run, 1e5),
    "points beyond all numbers": lambda run: growing(run, 1e200),
    "points not known": lost,
}
# Of these the law itself is followed until it settles; the others begin where one of them does.
FOLLOWED = "robots in one place", "robots at rest"


def outcomes(run, control, capsys):
    """Return the verdict on ``run``, none of whose claims raised."""
    verdict, _ = judged(run, control)
    wrong = [one for one in verdict["checks"] if one["name"].endswith("() returns")]
    wrong += [one for one in verdict["checks"] if one["note"].startswith(BROKEN)]
    assert not wrong, wrong
    assert "Traceback" not in capsys.readouterr().err
    return verdict


@pytest.mark.parametrize("name", sorted(HOMES))
def test_no_claim_raises_on_a_run_that_shows_nothing(name, tmp_path, capsys, monkeypatch):
    run, control = run_of(name, tmp_path)
    capsys.readouterr()
    most = theorem.MOST_COMMANDS
    for case, change in CASES.items():
        monkeypatch.setattr(theorem, "MOST_COMMANDS", most if case in FOLLOWED else 60)
        verdict = outcomes(change(run), control, capsys)
        if case in ("one sample", "points not known"):
            assert verdict["outcome"] in (NOT_JUDGED, FAILED), case
            assert verdict["reason"] or verdict["outcome"] == FAILED, case


@pytest.mark.parametrize("name", sorted(ANYBODY))
def test_no_claim_raises_for_one_robot_or_without_edges(name, tmp_path, capsys):
    start = shipped(OTHER_NAMES.get(name, name))
    alone = dict(NO_EDGES, robots=1, poses=[start.poses[0].tolist()], model=start.kinds[0])
    if start.altitude is not None:
        alone["altitude"] = float(start.altitude[0])
    if "leaders" in start.control.parameters:
        alone["parameters"] = {"leaders": 1}
    for number, changes in enumerate((NO_EDGES, alone)):
        run, control = run_of(name, tmp_path / str(number), **changes)
        capsys.readouterr()
        outcomes(run, control, capsys)


@pytest.mark.parametrize(
    "links", [{"loss": 0.3, "on_loss": "drop"}, {"switching": {"sets": 2, "dwell": 0.4}}]
)
def test_commands_under_noise_over_edges_that_come_and_go_are_not_judged(links, tmp_path, capsys):
    verdict = verdict_of(shipped("noisy_consensus", links=links, duration=1.0), tmp_path)
    (found,) = [one for one in verdict["checks"] if one["name"].startswith("commands off")]
    assert found["passed"] is None and "edges that come and go" in found["note"]
    assert "Traceback" not in capsys.readouterr().err


def test_poses_over_late_edges_are_not_followed(tmp_path):
    verdict = verdict_of(shipped("leader_follower", links={"delay": 0.2}, duration=2.0), tmp_path)
    assert not [one for one in verdict["checks"] if one["passed"] is False]
