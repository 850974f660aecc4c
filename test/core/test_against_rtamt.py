"""Robustness is that of rtamt, an evaluator by other authors."""

import sys
from importlib.util import find_spec

import pytest
from clean_wheel import StepFailed, ran
from documentation import loaded

FORMULAS = 10000


@pytest.fixture
def rtamt(tmp_path, monkeypatch):
    """Have rtamt, installed apart: its ANTLR runtime is a source package, which may fail to build."""
    if find_spec("rtamt") is None:
        if sys.version_info >= (3, 13):
            pytest.skip("Python 3.13 lacks typing.io, which the ANTLR runtime 4.7 of rtamt imports")
        install = "install", "-q", "--target", tmp_path, "rtamt==0.4.10"
        try:
            ran(sys.executable, "-m", "pip", "--disable-pip-version-check", *install)
        except StepFailed as error:
            pytest.skip("pip cannot install rtamt: {}".format(str(error).strip()[-300:]))
        monkeypatch.syspath_prepend(tmp_path)
    return pytest.importorskip("rtamt")


@pytest.mark.release
@pytest.mark.usefixtures("rtamt")
def test_random_formulas_have_the_robustness_of_rtamt():
    assert loaded("benchmarks", "formulas").farthest_off(FORMULAS) <= 1e-9
