"""Each example is one short file that runs, draws its picture and comes to a verdict."""

import importlib.util
import os
import runpy
import sys

import pytest

from mrs_simulator.verdict.verdict import FAILED, NOT_JUDGED, PASSED, outcome_of

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXAMPLES = os.path.join(ROOT, "examples")
NAMES = sorted(name[:-3] for name in os.listdir(EXAMPLES) if name.endswith(".py"))
MOST_LINES = 60
SHORTER = {"lossy_sweep": {"axes": ("links.loss=0.0,0.4",), "jobs": 1}}


@pytest.mark.parametrize("name", NAMES)
def test_an_example_runs(name, tmp_path, capsys):
    path = os.path.join(EXAMPLES, name + ".py")
    with open(path, encoding="utf-8") as file:
        assert len(file.readlines()) < MOST_LINES
    if name == "reading_runs":
        pytest.importorskip("pandas")
    spec = importlib.util.spec_from_file_location("example_" + name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert "python3 examples/{}.py".format(name) in module.__doc__
    run = module.study(str(tmp_path), duration=1.0, **SHORTER.get(name, {}))
    for verdict in run if isinstance(run, list) else [run.verdict]:
        assert outcome_of(verdict) in (PASSED, FAILED, NOT_JUDGED)
        assert verdict["ended"] == "complete"
    assert any(file.endswith(".png") for file in os.listdir(str(tmp_path)))


def test_there_are_ten_and_the_docs_list_them():
    with open(os.path.join(ROOT, "docs", "examples.md"), encoding="utf-8") as file:
        page = file.read()
    assert len(NAMES) == 10
    assert all("examples/{}.py".format(name) in page for name in NAMES)


def test_an_example_without_pandas_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(SystemExit, match="reading_runs.py: pandas is missing"):
        runpy.run_path(os.path.join(EXAMPLES, "reading_runs.py"))
