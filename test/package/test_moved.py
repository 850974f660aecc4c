"""Modules of earlier versions are found under their old names, with a warning that says where they are."""

import importlib
import sys

import pytest

from mrs_simulator.moved import MOVED, PACKAGE, SPLIT

MODULES = sorted(set(MOVED) - {"control.laws"})  # a package is no module to import from


@pytest.mark.parametrize("old", MODULES)
def test_an_old_name_gives_the_module_itself_and_a_warning(old, monkeypatch):
    new = importlib.import_module(PACKAGE + MOVED[old])
    monkeypatch.delitem(sys.modules, PACKAGE + old, raising=False)
    with pytest.warns(FutureWarning, match=r"is now {}{};".format(PACKAGE, MOVED[old])) as warned:
        assert importlib.import_module(PACKAGE + old) is new
    assert new.__spec__.name == new.__name__ == PACKAGE + MOVED[old]
    own = importlib.import_module("mrs_simulator.protocols.consensus.law")
    assert (
        importlib.import_module("mrs_simulator.protocols.consensus").law is own
    )  # its packages stay
    assert len(warned) == 1


@pytest.mark.parametrize("old", sorted(SPLIT))
def test_names_that_went_elsewhere_are_found_where_they_were(old, monkeypatch):
    monkeypatch.delitem(sys.modules, PACKAGE + old, raising=False)
    with pytest.warns(FutureWarning):
        module = importlib.import_module(PACKAGE + old)
    for home, names in SPLIT[old].items():
        for name in names:
            there = getattr(importlib.import_module(PACKAGE + home), name)
            assert getattr(module, name) is there and there.__module__ == PACKAGE + home


def test_a_law_of_today_with_old_imports_runs(tmp_path, monkeypatch):
    for name in ("mrs_simulator.control.laws", "mrs_simulator.control.laws.consensus"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    law = tmp_path / "mine.py"
    law.write_text("from mrs_simulator.control.laws.consensus import Consensus as Mine\n")
    with pytest.warns(FutureWarning, match="control.laws.consensus is now"):
        content = {}
        exec(compile(law.read_text(), str(law), "exec"), content)
    assert content["Mine"].__module__ == "mrs_simulator.protocols.consensus.law"


def test_a_name_that_never_was_is_not_found():
    with pytest.raises(ModuleNotFoundError, match="control.laws.consensuses"):
        importlib.import_module("mrs_simulator.control.laws.consensuses")
