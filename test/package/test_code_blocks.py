"""Every block of code in the documentation and in README runs, or is read by what would read it."""

import os
import re
import shlex
import xml.etree.ElementTree as ElementTree

import pytest
import yaml
from documentation import DOCS, ROOT, page

from mrs_simulator.__main__ import COMMANDS, main
from mrs_simulator.ros.node.unknown_parameters import PARAMETERS
from mrs_simulator.scenario.reading import Section
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.scenario.surroundings.maps import read_map
from mrs_simulator.vehicles.drives import DRIVES
from mrs_simulator.vehicles.registry import kind

BLOCK = re.compile(r"^```(\w+)(?: [^\n]*)?\n(.*?)^```$", re.M | re.S)
TITLED = re.compile(r'^```python title="([^"]+)"\n(.*?)^```$', re.M | re.S)
NAMES = sorted(name for name in os.listdir(DOCS) if name.endswith(".md")) + ["README.md"]
OWN = re.compile(r"my_\w+\.\w+|(ours|square)\.\w+|FILE|SCENARIO")


def blocks(*languages):
    """Return ``(page, number, code)`` of all blocks in these languages."""
    found = []
    for name in NAMES:
        codes = [code for language, code in BLOCK.findall(page(name)) if language in languages]
        found += [
            pytest.param(name, code, id="{}-{}".format(name, i)) for i, code in enumerate(codes)
        ]
    assert found
    return found


@pytest.mark.parametrize("name, code", blocks("python", "py"))
def test_python_runs(name, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if "import pandas" in code:
        pytest.importorskip("pandas")
        recorded = "time,robot,alpha_x\n0.0,1,1.0\n0.0,2,2.0\n"
        (tmp_path / "run.csv").write_text(recorded)
    for title, content in TITLED.findall(page(name)):  # a law may import another of its page
        (tmp_path / title).write_text(content)
    monkeypatch.syspath_prepend(str(tmp_path))
    # What a file ends with would start a node here.
    code = re.sub(r"^run\(\w+\)$", "", code, flags=re.M)
    if "from history import" in code:
        monkeypatch.syspath_prepend(os.path.join(ROOT, "benchmarks"))
        monkeypatch.setenv("MRS_SIMULATOR_BENCHMARK_LOAD", "1000")  # other tests run beside
        code = code.replace("keep=True", "keep=False")
    exec(compile(code, name, "exec"), {"__name__": "of_the_page"})


SIX = {"poses": {"layout": "line", "spacing": 3.0}, "robots": 6, "topology": {"preset": "ring"}}
OF_A_KIND = {"drive", "base", "import", "mounts", "shape"}


@pytest.mark.parametrize("name, code", blocks("yaml"))
def test_yaml_is_read(name, code, tmp_path):
    if re.match("map:", code):
        for line in code.splitlines():  # the same key, in several ways
            assert read_map(Section(yaml.safe_load(line), name)).file
        return
    content = yaml.safe_load(code)
    if not OF_A_KIND & set(content):
        base = {} if {"poses", "groups"} & set(content) else dict(SIX)
        if "load" in content:
            base["robots"] = len(content["load"]["grasps"])
        scenario_from_dict({**base, **content}, name)
    elif "import" in content:
        assert set(content["import"]) <= {"urdf", "drive"}  # a checkout of somebody else's
    elif content.get("drive", "differential") in DRIVES:  # else it is the page's own
        base = {} if "drive" in content else {"base": "pioneer3dx"}
        assert kind("of_the_page", own={"of_the_page": {**base, **content}}).title


def commands():
    """Return ``(page, words)`` of each command in the blocks of a shell."""
    for block in blocks("sh"):
        name, code = block.values
        for line in code.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            for at, word in enumerate(words):
                if word == "--wrap":
                    yield name, shlex.split(words[at + 1])
            if words:
                yield name, words


COMMAND_LINES = list(commands())


def programs(words):
    """Return the program of this package that the ``words`` start, and its arguments, or None."""
    if words[0] == "mrs-simulator":
        return words[1], words[2:]
    if words[:2] == ["rosrun", "mrs_simulator"]:
        return words[2], words[3:]
    return None


@pytest.mark.parametrize("name, words", COMMAND_LINES, ids=lambda value: " ".join(value)[:40])
def test_commands_name_what_there_is(name, words, capsys):
    if words[0] == "python3" and words[1].endswith(".py"):
        assert OWN.match(words[1]) or os.path.exists(
            os.path.join(ROOT, words[1].replace("$CLONE/", ""))
        )
    if words[0].startswith("./"):
        assert os.path.exists(os.path.join(ROOT, words[0]))
    if words[:2] == ["roslaunch", "mrs_simulator"]:
        tree = ElementTree.parse(os.path.join(ROOT, "launch", words[2]))
        declared = {arg.get("name") for arg in tree.getroot().iter("arg")}
        assert {word.partition(":=")[0] for word in words[3:] if ":=" in word} <= declared
    if programs(words):
        program, arguments = programs(words)
        told = help_of(program, capsys)
        for word in arguments:
            if word.startswith("--"):
                assert word.partition("=")[0] in told, word
            elif word.startswith("_"):
                assert word[1:].partition(":=")[0] in PARAMETERS, word
            elif word.endswith(".yaml") and not OWN.match(word):
                assert scenario_path(word.replace("scenarios/", ""))


def help_of(program, capsys):
    """Return what ``program`` says of its options."""
    if program not in COMMANDS:  # nodes
        assert os.path.exists(os.path.join(ROOT, "src", "mrs_simulator", "scripts", program))
        return ["--" + argument for argument in PARAMETERS] + ["--help"]
    with pytest.raises(SystemExit):
        main([program, "--help"])
    return re.findall(r"--[a-z_-]+", capsys.readouterr().out)
