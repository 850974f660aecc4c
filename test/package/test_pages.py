"""Errors name the page that explains them; every page and heading named is there."""

import os
import re

import pytest
from documentation import DOCS, ROOT, anchors, page

from mrs_simulator.__main__ import main
from mrs_simulator.core.doc_links import explained_by, page_of, with_page
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.verdict.verdict import verdict_text

PACKAGE = os.path.join(ROOT, "src", "mrs_simulator")
NAMED = re.compile(r"docs/(\w+\.md)(?:#([\w-]+))?")


def named_in_code():
    for directory, _, files in os.walk(PACKAGE):
        for name in files:
            if name.endswith((".py", ".launch")):
                with open(os.path.join(directory, name), encoding="utf-8") as file:
                    for found in NAMED.findall(file.read()):
                        yield (os.path.relpath(os.path.join(directory, name), PACKAGE), *found)


def test_every_page_and_heading_that_the_code_names_is_there():
    named = list(named_in_code())
    assert len(named) > 30
    for module, name, anchor in named:
        assert os.path.exists(os.path.join(DOCS, name)), (module, name)
        assert not anchor or anchor in anchors(name), (module, name, anchor)


def test_the_nearest_page_is_kept():
    class Told(ValueError):
        page = "class.md"

    @explained_by("outer.md")
    def outer():
        try:
            inner()
        except ValueError as error:
            raise Told("seen from outside") from error

    @explained_by("inner.md")
    def inner():
        raise ValueError("the cause")

    with pytest.raises(Told) as caught:
        outer()
    assert with_page(caught.value) == "seen from outside (see outer.md)"
    assert page_of(caught.value.__cause__) == "inner.md"
    assert with_page(Told("alone")) == "alone (see class.md)"
    with pytest.raises(ValueError) as caught, explained_by("outer.md"):
        inner()
    assert page_of(caught.value) == "inner.md"
    assert with_page(ValueError("nobody knows")) == "nobody knows"
    # The GUI's messages, too.
    assert reason(Told("alone")) == "alone (see class.md)"
    assert reason(KeyError("x")) == "KeyError: 'x'"


ROBOTS = "poses: [[0, 0, 0], [3, 0, 0]]\nduration: 0.1\n"


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("poses: [[0, 0]]", "scenarios.md"),
        (ROBOTS + "topology: {preset: cycel}", "scenarios.md#graphs"),
        (ROBOTS + "obstacles: [{type: ball}]", "scenarios.md#obstacles"),
        (ROBOTS + "map: missing.yaml", "scenarios.md#maps"),
        (ROBOTS + "environment: {tide: 1}", "scenarios.md#current-wind-and-waves"),
        (ROBOTS + "links: {loss: 2}", "scenarios.md#edges-with-faults"),
        (ROBOTS + "events: [{at: x}]", "scenarios.md#faults-and-pushes"),
        (ROBOTS + "load: {mass: x}", "manipulators.md#carrying-together"),
        (ROBOTS + "estimates: {ekf: x}", "sensors.md#estimated-poses"),
        (ROBOTS + "sensors: {sonnar: {}}", "sensors.md"),
        (ROBOTS + "model: pioner3dx", "kinds.md"),
        (ROBOTS + "model: cart.yaml", "robots_of_your_own.md#from-dimensions"),
        (ROBOTS + "control: {safety: {areena: 1}}", "safety_filter.md#safety-filter"),
        (ROBOTS + "control: {protocol: concensus}", "protocols.md#where-a-protocol-is-named"),
        (ROBOTS + "control: {parameters: {kk: 1}}", "protocols.md#parameters-and-topology"),
        (ROBOTS + "control: {protocol: law.py}", "protocols.md#where-a-protocol-is-named"),
        ("poses: [[0, 0, 0], [0.1, 0, 0]]", "scenarios.md#where-robots-begin"),
    ],
)
def test_what_is_wrong_with_a_scenario_is_said_with_its_page(text, wanted, tmp_path, capsys):
    (tmp_path / "lab.yaml").write_text(text)
    (tmp_path / "cart.yaml").write_text("drive: differential\nmass: 3 m\n")
    (tmp_path / "law.py").write_text("nothing = 0\n")
    said = refused(["experiment", tmp_path / "lab.yaml", "--out", tmp_path / "out"], capsys)
    assert said.endswith(" (see docs/{})".format(wanted)), said


TABLES = "scenarios.md#tables-for-papers-and-other-programs"


@pytest.mark.parametrize(
    "command, wanted",
    [
        ("experiment papr.yaml --out OUT", "scenarios.md#shipped-scenarios"),
        ("experiment paper.yaml --out OUT --width 1km", "figures.md"),
        ("experiment paper.yaml --out OUT --video run.avi", "figures.md"),
        ("experiment paper.yaml --out OUT --table xls", TABLES),
        ("sweep paper.yaml --out OUT seed", "sweeps.md#sweeps"),
        ("report OUT/lab.csv --out OUT", "scenarios.md#columns-of-runcsv"),
        ("view OUT/lab.csv", "scenarios.md#columns-of-runcsv"),
        ("noise_gain paper.yaml --out OUT", "edges.md#noise"),
        ("lossy_edges paper.yaml --out OUT", "edges.md#edges-with-faults"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_command_is_said_with_its_page(command, wanted, tmp_path, capsys):
    (tmp_path / "lab.csv").write_text("a,b\n")
    said = refused(command.replace("OUT", str(tmp_path)).split(), capsys)
    assert said.endswith(" (see docs/{})".format(wanted)), said


def refused(command, capsys):
    """Return the one line with which ``command`` is refused."""
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in command])
    assert ended.value.code == 2
    (said,) = capsys.readouterr().err.strip().split("\n")
    return said


def test_a_verdict_that_is_not_passed_names_its_page():
    verdict = dict(title="", outcome="not_judged", reason="no claims", checks=[], final_gaps=None)
    verdict.update(min_distance=None, real_time_factor=None, warnings=[])
    assert verdict_text(verdict).endswith("docs/verdict.md#why-a-claim-is-not-judged")
    assert verdict_text(dict(verdict, outcome="failed")).endswith("docs/verdict.md")
    assert "docs" not in verdict_text(dict(verdict, outcome="passed"))


ROWS = re.findall(r"^\| (`.+?) \| (.+) \|$", page("troubleshooting.md"), re.M)


def source():
    """Return the package's text, strings that are broken over lines joined."""
    texts = []
    for directory, _, files in os.walk(PACKAGE):
        for name in files:
            if name.endswith(".py"):
                with open(os.path.join(directory, name), encoding="utf-8") as file:
                    texts.append(file.read())
    for name in ("demo.sh", os.path.join("tools", "prepare.sh")):
        with open(os.path.join(ROOT, name), encoding="utf-8") as file:
            texts.append(file.read())
    text = re.sub(r'"\s*\n\s*(?:b|f)?"', "", "\n".join(texts))
    return re.sub(r"\{[^{}\n]*\}", "...", text.replace("{{", "{").replace("}}", "}"))


def test_the_messages_on_the_page_are_those_of_the_code():
    text = source()
    assert len(ROWS) > 50
    for messages, _ in ROWS:
        for message in re.findall(r"`([^`]+)`", messages):
            for part in re.split(r"\.\.\.|[A-Z]{4,}", message):
                part = part.strip(" ':;,[]()")
                wanted = part.replace("wanted ", '"', 1)  # as ``unwanted`` is given it
                assert len(part) < 3 or part in text or wanted in text, (message, part)


def test_a_missing_pybullet_leads_to_its_installation():
    from mrs_simulator.world.motion.motions import NO_SOLVER, NoSolver

    page = page_of(NoSolver(NO_SOLVER))
    with open(os.path.join(ROOT, page)) as file:
        assert "pybullet" in file.read()
