"""The documentation's site: all pages are there, the tutorial runs as it stands, no warning."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import pytest
import yaml
from documentation import DOCS, FENCED, ROOT, anchors, loaded, page

from mrs_simulator.__main__ import main
from mrs_simulator.protocols import HOMES

PAGES = sorted(
    os.path.relpath(os.path.join(directory, name), DOCS)
    for directory, _, names in os.walk(DOCS)
    for name in names
    if name.endswith(".md")
)
MKDOCS = shutil.which("mkdocs") or os.path.join(ROOT, "build", "site-environment", "bin", "mkdocs")


def named(entry):
    """Return the pages in an ``entry`` of the navigation."""
    if isinstance(entry, str):
        return [entry]
    return [
        name
        for each in (entry.values() if isinstance(entry, dict) else entry)
        for name in named(each)
    ]


def test_every_page_is_in_the_navigation():
    with open(os.path.join(ROOT, "mkdocs.yml"), encoding="utf-8") as file:
        nav = yaml.safe_load(file)["nav"]
    hook = loaded("tools", "site_links")
    config = hook.on_config({"nav": nav, "docs_dir": DOCS})
    assert sorted(named(config["nav"])) == PAGES


@pytest.mark.parametrize("name", PAGES)
def test_links_of_every_page_lead_somewhere(name):
    for target, anchor in re.findall(r"\]\(([^)#:]*)(?:#([^)]*))?\)", page(name)):
        there = os.path.normpath(os.path.join(os.path.dirname(name), target)) if target else name
        assert os.path.exists(os.path.join(DOCS, there)), target
        assert not anchor or anchor in anchors(there), (target, anchor)


sys.path.insert(0, DOCS)
try:
    import make_examples
    import make_protocols as maker
    import make_references
finally:
    sys.path.remove(DOCS)


@pytest.mark.parametrize("name", sorted(HOMES))
def test_each_protocol_has_a_page_made_from_its_docstring(name):
    """python3 docs/make_protocols.py --text writes the pages anew but for verdicts and pictures."""
    text = page(os.path.join("protocols", name + ".md"))
    verdict = maker.verdict_on(name)
    assert maker.page(name, verdict) == text
    assert ": PASSED" in verdict or name == "reynolds"
    assert 2000 < os.path.getsize(maker.picture_path(name)) < 60000


def test_the_examples_page_is_made_from_the_examples():
    """Else: python3 docs/make_examples.py"""
    assert make_examples.page(make_examples.results()) == page("examples.md")
    for name in make_examples.ORDER:
        assert 2000 < os.path.getsize(make_examples.picture_path(name)) < 60000


def test_references_are_made_from_the_bibliography():
    """Else: python3 docs/make_references.py"""
    assert make_references.page() == page("references.md")
    found = make_references.references()
    assert len({each.key for each in found}) == len(found) > 30
    dois = re.findall(r"doi:(\S+)\]", page("references.md"))
    assert len(dois) > 20 and all(re.match(r"10\.\d{4,}/\S+$", doi) for doi in dois)


@pytest.mark.parametrize("name", sorted(HOMES))
def test_what_a_docstring_cites_is_among_the_references(name):
    law = maker.shipped(name)
    text = "\n".join(maker.paragraphs(law))
    cited = [each for each in make_references.references() if each.is_cited_in(text)]
    years = re.findall(r"\b(?:19|20)\d\d\b", text)
    assert {each.year for each in cited} == set(years), text


def test_the_paper_cites_what_its_bibliography_has():
    with open(os.path.join(ROOT, "paper", "paper.md"), encoding="utf-8") as file:
        text = file.read()
    keys = {each.key for each in make_references.references()}
    assert set(re.findall(r"@(\w+)", text)) <= keys
    for heading in ("Summary", "Statement of need", "State of the field", "References"):
        assert "\n# {}\n".format(heading) in text
    assert yaml.safe_load(text.split("---")[1])["bibliography"] == "paper.bib"


def saved(text, directory):
    """Write the files of a page's ``text`` to ``directory``."""
    for name, content in re.findall(r'```\w+ title="([^"]+)"\n(.*?)```', text, re.S):
        (directory / name).write_text(content)


def headless(text, codes=(), left_out=()):
    """Run the page's commands ``mrs-simulator``, but for those ``left_out``; return their names.

    ``codes``: with which each exits; by default all succeed.
    """
    commands = re.findall(r"^mrs-simulator (.+)$", text, re.M)
    commands = [command for command in commands if command.split()[0] not in left_out]
    for command, code in zip(commands, codes or [0] * len(commands)):
        with pytest.raises(SystemExit) as ended:
            main(shlex.split(command))
        assert ended.value.code == code, command
    return [command.split()[0] for command in commands]


CHECKS = "check_protocol", "sweep"  # of many runs


@pytest.mark.parametrize("left_out", [CHECKS, pytest.param((), marks=pytest.mark.release)])
def test_the_tutorial_runs_as_it_stands(tmp_path, monkeypatch, capsys, left_out):
    monkeypatch.chdir(tmp_path)
    text = page("tutorial.md")
    saved(text, tmp_path)
    names = headless(text, left_out=left_out)
    said = capsys.readouterr().out
    assert "Four Pioneers form a square: PASSED" in said
    made = ["square/trajectories.pdf", "square/verdict.tex", "square/square.gif"]
    if not left_out:
        assert names == ["experiment", *CHECKS, "report"]
        assert "18 mistakes put in" in said and said.count("nothing noticed it") == 3
        assert "3 of 3 runs passed" in said
        made.append("gains/sweep.png")
    for name in made:
        assert (tmp_path / name).stat().st_size > 500, name


@pytest.mark.release
def test_the_tutorial_of_a_law_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = page("tutorial_law.md")
    saved(text, tmp_path)
    names = ["analyse", "experiment", "experiment", "experiment", "check_protocol"]
    assert headless(text) == names
    said = capsys.readouterr().out
    for shown in (block for block in FENCED.findall(text) if block.startswith("```\n")):
        for line in set(shown.splitlines()) - {"  ...", "```"}:
            assert line in said, line
    assert [json.loads((tmp_path / name / "verdict.json").read_text())["outcome"] for name in (
        "meeting", "points", "gathering",
    )] == ["not_judged", "passed", "passed"]  # fmt: skip
    for count in ("15 mistakes put in", "nothing noticed it"):
        assert count in said
    assert said.count("nothing noticed it") == 3


@pytest.mark.release
def test_the_tutorial_of_a_search_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = page("tutorial_search.md")
    saved(text, tmp_path)
    assert headless(text, [0, 1, 0]) == ["experiment", "break", "break"]
    said = capsys.readouterr().out
    for shown in (block for block in FENCED.findall(text) if block.startswith("```\n")):
        for line in set(shown.splitlines()) - {"  ...", "```"}:
            assert line in said, line
    assert (tmp_path / "broken" / "run" / "trajectories.png").stat().st_size > 500


@pytest.mark.release
@pytest.mark.skipif(
    not os.path.exists(MKDOCS), reason="mkdocs is not installed: tools/make_site.sh"
)
def test_the_site_builds_without_a_warning(tmp_path):
    command = [MKDOCS, "build", "--strict", "--quiet", "-d", str(tmp_path / "site")]
    done = subprocess.run(command, cwd=ROOT, stderr=subprocess.PIPE, timeout=240, check=False)
    assert done.returncode == 0, done.stderr.decode()

    def built(name):
        return (tmp_path / "site" / name / "index.html").read_text(encoding="utf-8")

    assert "calculateControlLaw" in built("api") and ":meth:" not in built("api")
    assert 'src="../../images/protocols/consensus.svg"' in built(
        os.path.join("protocols", "consensus")
    )
    assert "<math" in built(os.path.join("protocols", "consensus"))
    assert built("examples").count("The whole file") == 10
    assert "The whole file" in built(os.path.join("protocols", "consensus"))
    index = json.loads((tmp_path / "site" / "search" / "search_index.json").read_text())["docs"]
    for wanted in ("ROS 2", "cite", "Collision"):
        assert any(wanted in each["title"] for each in index), wanted
    # Nothing is loaded from elsewhere: a reader without network sees all.
    for name in ("", "gallery", "shipped_protocols"):
        assert not re.findall(
            r'(?:src|href)="(https?://[^"]+\.(?:js|css|woff2?|png|svg))"', built(name)
        )
