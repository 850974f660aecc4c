"""What a visitor of the repository finds first is valid, and says one version."""

import os
import re

import pytest
import yaml
from documentation import ROOT

from mrs_simulator import __version__
from mrs_simulator.protocols import HOMES
from mrs_simulator.vehicles.registry import shipped_kinds

FORGE = os.path.join(ROOT, ".github")


def text(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def test_one_version_everywhere():
    assert yaml.safe_load(text("CITATION.cff"))["version"] == __version__
    assert "<version>{}</version>".format(__version__) in text("package.xml")
    assert re.search(r"version = \{(.+)\}", text("README.md")).group(1) == __version__
    assert "## {}\n".format(__version__) in text("CHANGELOG.md")


def test_the_citation_has_what_its_format_wants():
    cited = yaml.safe_load(text("CITATION.cff"))
    assert cited["cff-version"] == "1.2.0" and cited["type"] == "software"
    assert cited["message"] and cited["title"] and cited["authors"][0]["name"]
    assert cited["license"] == "BSD-3-Clause"
    assert '    license="BSD-3-Clause",\n' in text("setup.py")
    preferred = cited["preferred-citation"]
    assert preferred["version"] == cited["version"] and preferred["authors"] == cited["authors"]
    assert "Redistributions in binary form" in text("LICENSE")


def test_versions_of_the_changelog_are_newest_first():
    versions = re.findall(r"^## (.+)$", text("CHANGELOG.md"), re.M)
    assert versions[0] == "Unreleased"
    numbers = [tuple(map(int, version.split("."))) for version in versions[1:]]
    assert numbers == sorted(set(numbers), reverse=True) and numbers


def test_speeds_on_the_first_page_are_those_of_the_table_of_speeds():
    """All of README's are made of what was measured last, and comparison.md tells none by hand."""
    speed = re.search(r"<!-- table speed,.*?<!-- end -->", text("README.md"), re.S).group(0)
    ours = [line.split("|")[2:5] for line in speed.splitlines() if "this package" in line]
    told = text("docs", "benchmarks.md")
    assert len(ours) > 1
    for cells in ours:
        assert all(re.fullmatch(r" [\d,.]+ ", cell) for cell in cells), cells
        assert "|{}|".format("|".join(cells)) in told, cells
    rest = text("README.md").replace(speed, "")
    assert not re.search(r"times as fast|times real time|x real time", rest)
    better = text("docs", "comparison.md").partition("## Where another")[2]
    assert not re.search(r"(?:beside|does|do) \d", better)


def test_what_the_first_page_counts_is_there():
    readme = text("README.md")
    assert len(HOMES) == 32 and "**Thirty-two laws**" in readme
    assert len(shipped_kinds()) == 16 and "**Sixteen kinds of robots**" in readme
    assert os.path.getsize(os.path.join(ROOT, "docs", "images", "teams.gif")) < 1.5e6


@pytest.mark.parametrize("name", ["bug.md", "idea.md"])
def test_templates_of_issues_have_a_name(name):
    front = text(".github", "ISSUE_TEMPLATE", name).split("---")[1]
    assert set(yaml.safe_load(front)) >= {"name", "about"}


def test_the_forge_runs_what_there_is():
    jobs = yaml.safe_load(text(".github", "workflows", "test.yml"))["jobs"]
    assert set(jobs) == {"test", "site", "wheel"}
    steps = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    assert "./test.sh all" in steps
    for command in ("./test.sh", "tools/make_site.sh"):
        assert any(step.startswith(command) for step in steps)
        assert os.access(os.path.join(ROOT, command), os.X_OK)
