"""Laws from files: each has the helpers that lie beside it, as they are now."""

import sys

import pytest

from mrs_simulator.protocols.loading import ProtocolError, choose_protocol, load_protocol
from mrs_simulator.scenario.scenario import scenario_from_dict

LAW = (
    "from mrs_simulator import PioneerControl\nfrom parts import gain\nimport own_helper\n\n\n"
    "class Law(PioneerControl):\n    K = gain.K, own_helper.K\n\n"
    "    def pointMassLaw(self, hand):\n        import own_helper\n\n        return own_helper.K * hand\n"
)


def write(directory, value):
    (directory / "parts").mkdir(parents=True, exist_ok=True)
    (directory / "parts" / "__init__.py").write_text("")
    (directory / "parts" / "gain.py").write_text("K = {}\n".format(value))
    (directory / "own_helper.py").write_text("K = {}\n".format(10 * value))
    (directory / "law.py").write_text(LAW)
    return str(directory / "law.py")


@pytest.fixture(autouse=True)
def untouched():
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_helpers_of_equal_names_are_each_law_s_own(tmp_path):
    first, second = write(tmp_path / "a", 1), write(tmp_path / "b", 222)
    path = list(sys.path)
    assert load_protocol(first).K == (1, 10) and load_protocol(second).K == (222, 2220)
    assert load_protocol(first).K == (1, 10) and sys.path == path


def test_helpers_are_read_again(tmp_path):
    assert load_protocol(write(tmp_path, 1)).K == (1, 10)
    assert load_protocol(write(tmp_path, 3333)).K == (3333, 33330)


def test_parameters_are_those_of_a_law_that_is_named_by_its_file_alone(tmp_path):
    text = "from mrs_simulator import Parameter, PioneerControl\n\n\n"
    text += "class Own(PioneerControl):\n    PARAMETERS = (Parameter('gain', 1.0),)\n"
    (tmp_path / "own.py").write_text(text)
    for name in ("own.py", "own.py:Own"):
        control = {"protocol": name, "parameters": {"gain": 24.0}}
        scenario = scenario_from_dict({"poses": [[0, 0, 0]], "control": control})
        given, law = choose_protocol(scenario._replace(path=str(tmp_path / "a.yaml")))
        again, same = choose_protocol(given, law)
        assert same is law and again.control == given.control
        assert again.control.parameters["gain"] == 24.0

    class Other(law):
        """Of another name, and file."""

    other = choose_protocol(given, Other)[0].control
    assert "gain" not in other.parameters and other.protocol.endswith("test_loading.py:Other")


def test_a_law_finds_no_helpers_of_another_directory(tmp_path):
    load_protocol(write(tmp_path / "a", 1))
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "law.py").write_text(LAW)
    with pytest.raises(ProtocolError, match="law.py, line 2: ModuleNotFoundError.*parts"):
        load_protocol(str(tmp_path / "b" / "law.py"))


def test_a_law_imports_its_helpers_late_after_another_was_loaded(tmp_path):
    law = load_protocol(write(tmp_path / "a", 1))
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "law.py").write_text(LAW.replace("from parts import gain\n", ""))
    with pytest.raises(ProtocolError):
        load_protocol(str(tmp_path / "b" / "law.py"))
    assert law([1]).pointMassLaw(2.0) == 20.0
