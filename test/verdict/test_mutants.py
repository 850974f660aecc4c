"""Wrong laws fail their verdicts: the fast part of the mutation campaign."""

import os
import subprocess
import sys

import pytest
import yaml

from mrs_simulator.protocols import HOMES

BENCHMARKS = os.path.join(
    os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "benchmarks"
)


@pytest.mark.release
def test_a_mistake_in_each_law_fails_its_verdict():
    command = [sys.executable, os.path.join(BENCHMARKS, "mutants.py"), "--fast"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_the_campaign_has_five_mistakes_of_each_protocol():
    with open(os.path.join(BENCHMARKS, "mutants.yaml"), encoding="utf-8") as file:
        groups = yaml.safe_load(file)
    for protocol in [*HOMES, "mapping (7)", "faulty edges"]:
        of_it = [group for name, group in groups.items() if name.startswith(protocol)]
        assert sum(len(group["mutants"]) for group in of_it) >= 5, protocol


def test_each_mistake_is_put_where_its_source_still_is():
    with open(os.path.join(BENCHMARKS, "mutants.yaml"), encoding="utf-8") as file:
        groups = yaml.safe_load(file)
    package = os.path.join(os.path.dirname(BENCHMARKS), "src", "mrs_simulator")
    for name, group in groups.items():
        for edit in group["mutants"]:
            path = os.path.join(package, *edit["module"].split(".")) + ".py"
            with open(path, encoding="utf-8") as source:
                assert edit["right"] in source.read(), (name, edit)
