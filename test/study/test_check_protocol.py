"""``check_protocol``: a sound law is ok, mistakes are noticed, and claims that cannot fail are named."""

import re

import numpy as np
import pytest

from mrs_simulator import Parameter, PioneerControl
from mrs_simulator.core.claims import Condition, converges_to, disagreement, invariant, rate
from mrs_simulator.protocols import shipped
from mrs_simulator.study.check.check_protocol import (
    LIMITED,
    POINTS,
    WHEELS,
    assert_protocol,
    check_protocol,
    main,
)
from mrs_simulator.study.check.mutants import OF_COMMANDS, SLIGHT, mutants_of

SMALL = dict(graphs=["path"], robots=[3], seeds=[1], duration=6.0)


class Agree(PioneerControl):
    """Consensus that claims its limit alone."""

    PARAMETERS = (Parameter("gain", 1.2, "1/s", low=0.0, high=10.0, meaning="of each edge"),)

    def pointMassLaw(self, hand):
        return -self.gain * self.topology.laplacian() @ hand

    def claims(self, start):
        connected = self.topology.has_spanning_tree() and not self.topology.directed
        claims = [converges_to(start.mean(axis=0), free=True)]
        return [Condition("undirected", connected), *claims]


class Careless(Agree):
    """Claims of unlimited inputs, and one that cannot fail."""

    def claims(self, start):
        always = invariant(lambda hand: 0.0 * hand[:, 0, 0], name="nothing at all")
        return super().claims(start)[:1] + [converges_to(start.mean(axis=0), 1e-4), always]


class Meets(Agree):
    """Claims its rate, too, within 5 %, and has a formula in its source."""

    def pointMassLaw(self, hand):
        return np.array([self.sum_of(hand, robot) for robot in self.numbers])

    def sum_of(self, hand, robot):
        ways = [hand[j - 1] - hand[robot - 1] for j in self.topology.neighbours(robot)]
        return self.gain * np.cos(0.0 * hand[0, 0]) * sum(ways)

    def claims(self, start):
        return [*super().claims(start), rate(self.gain, disagreement)]


class Silent(Agree):
    """Claims nothing."""

    def claims(self, start):
        return []


class Wrong(Agree):
    """Does other than it claims."""

    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) + [0.1, 0.0]


def test_a_shipped_law_is_ok_and_each_mistake_noticed():
    report = assert_protocol("consensus", **dict(SMALL, duration=12.0))
    assert not report.survivors and not report.slight_survivors and not report.blind
    assert len(report.caught) == len(OF_COMMANDS) + len(SLIGHT) + 2
    modes = {trial.setting.mode: trial for trial in report.trials}
    assert set(modes) == {POINTS, LIMITED, WHEELS}
    # What meets in one place touches, and is not judged.
    assert modes[WHEELS].touched and not modes[WHEELS].judged
    assert str(report).splitlines()[-1].startswith("OK: ")


def test_mistakes_that_nothing_notices_are_named():
    report = check_protocol(Agree, **SMALL)
    assert not report.failed and not report.ok
    survivors = {"all go at 1.4 of their speed", "gain times 1.4", "all go 30 degrees to the left"}
    assert survivors <= set(report.survivors)
    assert "all go at 1.04 of their speed" in report.slight_survivors
    text = str(report)
    assert re.search(r"all stand still  +final distance from the limit \[m\]", text)
    assert "NOT OK: a law with 'all go" in text and "NOTHING NOTICED IT" in text


def test_a_claim_that_cannot_fail_and_one_for_unlimited_inputs_are_named():
    report = check_protocol(Careless, **dict(SMALL, duration=10.0))
    assert report.blind == ["nothing at all"]
    assert {trial.setting.mode for trial in report.failed} == {LIMITED}
    assert "'nothing at all' could not tell" in str(report) and "take free=True" in str(report)


def test_a_law_without_claims_is_not_ok():
    text = str(check_protocol(Silent, **dict(SMALL, duration=1.0)))
    assert "states no claims: write claims(start)" in text and "no claim was judged" in text
    assert "0 of 0 runs of which theory speaks passed" in text


def test_a_wrong_law_fails_with_its_numbers():
    with pytest.raises(
        AssertionError, match="FAILED on path, 3 robots, seed 1, points:\n.*predicted 0, mea"
    ):
        assert_protocol(Wrong, **SMALL)


def test_where_the_theorem_does_not_speak_runs_are_not_judged():
    report = check_protocol(Agree, **dict(SMALL, graphs=["chain"], duration=2.0))
    assert not report.failed and not report.caught
    assert "3 runs not judged: undirected does not hold" in str(report)


def test_wrong_values_of_each_kind_of_parameter():
    control = shipped("coverage")(range(1, 4))
    names = [mutant.name for mutant in mutants_of(control)]
    assert "gain times 0.7" in names and "density is gaussian" in names
    assert "samples is one more" in names and "centre_x is 0.1 in place of 0" in names
    assert not any(name.startswith("l ") for name in names)


def test_the_command(tmp_path, capsys):
    law = tmp_path / "law.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\n\n\nclass Law(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        return 0.0 * hand\n"
    )
    given = [str(law), "--graphs", "path", "--robots", "2", "--seeds", "1", "--duration", "1"]
    with pytest.raises(SystemExit) as ended:
        main(given)
    assert ended.value.code == 1 and "states no claims" in capsys.readouterr().out
    for wrong, said in (
        ("--robots=two", "wanted whole numbers"),
        ("--set=gain=1", "unknown 'gain'"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(given + [wrong])
        assert ended.value.code == 2 and said in capsys.readouterr().err


def test_a_method_that_raises_is_named_with_its_error(tmp_path):
    law = tmp_path / "law.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\n\n\n"
        "class Agree(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n"
        "        return -self.topology.laplacian() @ hand\n\n"
        "    def claims(self, start):\n"
        "        return [rate(0.5)]\n"
    )
    report = check_protocol(str(law), graphs=["path"], robots=[3], seeds=[0], duration=1.0)
    text = str(report)
    assert not report.ok and "claims(): NameError: name 'rate' is not defined" in text
    assert "states no claims" not in text and "a method of the law raised" in text


@pytest.fixture(scope="module")
def meets():
    methods = Meets.pointMassLaw, Meets.sum_of
    report = check_protocol(Meets, **SMALL)
    assert (Meets.pointMassLaw, Meets.sum_of) == methods
    return report


def test_mistakes_in_the_source_are_noticed(meets):
    found = {name.split(":")[0]: checks for name, checks in meets.caught.items() if ": " in name}
    for kind in ("another sign", "a missing term", "another index", "a missing neighbour"):
        assert any(name.startswith(kind) and checks for name, checks in found.items()), kind
    (degrees,) = [name for name in found if name.startswith("degrees for radians in sum_of")]
    assert found[degrees] is None  # of 0


def test_slight_mistakes_and_claims_whose_number_may_be_wrong_are_named_beforehand(meets):
    assert "commands of one period before" in meets.slight_survivors
    assert meets.ok and "decay rate [1/s]" in meets.confirmed
    text = str(meets)
    assert "OK, but its claims do not tell the law from one with" in text
    assert "decay rate [1/s]: passed with" in text
