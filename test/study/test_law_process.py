"""A user's law is asked in a process of its own, whatever it does there."""

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.study.run import law_answers
from mrs_simulator.study.run.law_process import LawError, LawProcess

LAW = """
import os, sys, time
from mrs_simulator import PioneerControl
class Law(PioneerControl):
    def pointMassLaw(self, hand): return 0.0 * hand
    def targets(self, hand):
        {}
        return hand
"""


@pytest.fixture
def laws():
    laws = LawProcess(limit=60.0)
    yield laws
    laws.close()


def of(path, line):
    path.write_text(LAW.format(line))
    return shipped("paper_four").with_protocol(str(path))


def test_a_users_law_answers_as_a_shipped_one_does(laws, tmp_path):
    scenario = of(tmp_path / "law.py", "pass")
    facts = laws.ask("facts", scenario)
    assert facts.protocol == "Law" and facts.targets.shape == (4, 2)
    assert [parameter.name for parameter in facts.parameters] == ["l"]
    assert laws.ask("errors", scenario, scenario.poses[np.newaxis]).tolist() == [0.0]
    assert laws.ask("prediction", scenario).time is None
    assert laws.ask("facts", shipped("paper_four")).protocol == "Formation"


def test_predictions_of_shipped_laws_are_not_computed_in_this_process(laws, monkeypatch):
    scenario = shipped("paper_four")
    expected = law_answers.prediction(scenario)
    for function in ("prediction", "facts"):
        monkeypatch.setitem(law_answers.ANSWERS, function, lambda _: "in this process")
    found = laws.ask("prediction", scenario)
    np.testing.assert_array_equal(found.error, expected.error)
    assert found.settling == expected.settling
    assert laws.ask("facts", scenario) == "in this process"  # somebody waits for these


def test_an_error_names_the_users_line_and_the_process_goes_on(laws, tmp_path):
    scenario = of(tmp_path / "law.py", "len(3)")
    with pytest.raises(LawError, match=r"TypeError.*\n.*law.py:7, in targets: len\(3\)"):
        laws.ask("facts", scenario)
    with pytest.raises(LawError, match="SystemExit"):
        laws.ask("facts", of(tmp_path / "exits.py", "sys.exit(3)"))
    assert laws.ask("facts", of(tmp_path / "law.py", "pass")).protocol == "Law"
    broken = tmp_path / "broken.py"
    broken.write_text("x = 1\nraise KeyError(x)\n")
    with pytest.raises(LawError, match=r"KeyError.*\n.*broken.py:2: raise KeyError"):
        laws.ask("facts", shipped("paper_four").with_protocol(str(broken)))


def test_a_law_that_ends_its_interpreter_ends_that_alone(laws, tmp_path):
    with pytest.raises(LawError, match="its process ended .exit code 7"):
        laws.ask("facts", of(tmp_path / "law.py", "os._exit(7)"))
    assert laws.ask("facts", of(tmp_path / "law.py", "pass")).protocol == "Law"


def test_a_law_that_never_finishes_importing_is_given_up(laws, tmp_path):
    laws.ask("facts", of(tmp_path / "law.py", "pass"))
    hangs = tmp_path / "hangs.py"
    hangs.write_text(
        "import time\n\ndef rest():\n    while True:\n        time.sleep(0.01)\n\n\nrest()\n"
    )
    laws.limit = 2.0
    with pytest.raises(
        LawError, match="hangs.py: no answer within 2 s, it is at hangs.py:[45], in rest"
    ):
        laws.ask("facts", shipped("paper_four").with_protocol(str(hangs)))
    laws.limit = 60.0
    assert laws.ask("facts", of(tmp_path / "law.py", "pass")).protocol == "Law"


def test_one_who_waits_can_do_something_else_and_give_up(tmp_path):
    waited = []

    def waiting(seconds):
        waited.append(seconds)
        with pytest.raises(LawError, match="another law"):
            laws.ask("facts", scenario)
        if len(waited) > 3:
            raise KeyboardInterrupt

    laws = LawProcess(limit=60.0)
    laws.waiting, laws.waited = waiting, lambda: waited.append("over")
    hangs = tmp_path / "hangs.py"
    hangs.write_text("import time; time.sleep(1000)")
    scenario = shipped("paper_four").with_protocol(str(hangs))
    with pytest.raises(KeyboardInterrupt):
        laws.ask("facts", scenario)
    assert laws._worker.given_up and waited.pop() == "over" and waited == sorted(waited)


def test_once_closed_it_starts_no_other_process(laws):
    """As for a prediction that has waited for another one while a window was closed."""
    laws.close()
    with pytest.raises(LawError, match="not asked any more"):
        laws.ask("prediction", shipped("paper_four"))
