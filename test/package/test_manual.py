"""``mrs-simulator docs`` prints what errors name, in a clone and in an installed package."""

import os
import re
import subprocess
import sys

import pytest
from documentation import DOCS, ROOT, anchors, page
from test_pages import named_in_code

from mrs_simulator.__main__ import main
from mrs_simulator.core import doc_pages


def test_all_that_errors_name_is_printed():
    for _, name, anchor in named_in_code():
        link = "docs/" + name + ("#" + anchor if anchor else "")
        text = doc_pages.text_of(link)
        assert text == page(name) or text.startswith("#") and text in page(name) + "\n", link


def test_a_section_ends_where_the_next_begins(capsys):
    main(["docs", "docs/verdict.md#why-a-claim-is-not-judged"])
    said = capsys.readouterr().out
    assert re.match("#+ Why a claim is not judged\n", said)
    depth = said.index(" ")
    assert not re.search("^#{{1,{}}} ".format(depth), said[depth:], re.M)
    main(["docs", "consensus"])  # a protocol's page
    assert capsys.readouterr().out == page(os.path.join("protocols", "consensus.md"))


def test_headings_are_found_by_the_anchors_of_the_site():
    for name in ("protocols.md", "scenarios.md", "robots.md"):
        for anchor in anchors(name):
            assert doc_pages.text_of("{}#{}".format(name, anchor)).startswith("#")


def test_without_a_page_all_are_listed(capsys):
    main(["docs"])
    names = capsys.readouterr().out.split()
    assert {"verdict", "scenarios", "protocols/consensus"} <= set(names)
    assert all(os.path.exists(os.path.join(DOCS, name + ".md")) for name in names)


@pytest.mark.parametrize(
    "wanted, said",
    [
        ("verdit.md", "docs: page 'verdit': there is none; did you mean 'verdict'?\n"),
        (
            "verdict.md#whi-a-claim",
            "docs: heading 'whi-a-claim': there is none; did you mean 'why-a-",
        ),
    ],
)
def test_what_is_not_there_is_named_with_the_nearest(wanted, said, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["docs", wanted])
    assert ended.value.code == 2 and capsys.readouterr().err.startswith(said)


def test_an_installed_package_names_the_command(tmp_path):
    assert doc_pages.reference("docs/verdict.md#x", installed=False) == "docs/verdict.md#x"
    assert (
        doc_pages.reference("docs/verdict.md#x", installed=True)
        == "mrs-simulator docs verdict.md#x"
    )
    # As pip builds it: the pages lie in the package.
    build = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", str(tmp_path / "lib")]
    subprocess.run(build, cwd=ROOT, check=True, timeout=120, stderr=subprocess.DEVNULL)
    held = tmp_path / "lib" / "mrs_simulator" / "docs"
    assert (held / "protocols" / "consensus.md").exists() and not (held / "images").exists()
    code = "from mrs_simulator.core.doc_links import OF_FAILED; print(OF_FAILED)"
    environment = dict(os.environ, PYTHONPATH=str(tmp_path / "lib"))
    said = subprocess.check_output([sys.executable, "-c", code], env=environment, timeout=60)
    assert said == b"mrs-simulator docs verdict.md\n"
