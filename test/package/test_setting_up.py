"""Setting up: places in which nothing can be built are refused in one line, moved ones built anew."""

import os
import subprocess

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PREPARE = os.path.join(ROOT, "tools", "prepare.sh")


def shell(root, command, **environment):
    """Return the finished ``command``, in bash, after ``tools/prepare.sh`` for the checkout ``root``."""
    text = 'root="{}" && . "{}" && {}'.format(root, PREPARE, command)
    return subprocess.run(
        ["bash", "-c", text],
        capture_output=True,
        text=True,
        env=dict(os.environ, **environment),
    )


def refused(root, wanted, **environment):
    result = shell(root, "check_place 400", **environment)
    what, remedy = result.stderr.strip().split("\n")
    assert result.returncode == 2 and what.startswith("Failed: ") and wanted in remedy


def test_places_that_cannot_be_set_up_are_refused(tmp_path):
    (tmp_path / "a b").mkdir()
    refused(tmp_path / "a b", "a path with blanks: move the checkout")
    (tmp_path / "file").write_text("")
    refused(tmp_path / "file", "copy the checkout")
    (tmp_path / "df").write_text("#!/bin/sh\necho head\necho /dev/x 9 9 77 9% /\n")
    (tmp_path / "df").chmod(0o755)
    refused(tmp_path, "77 MB are free there", PATH="{}:{}".format(tmp_path, os.environ["PATH"]))
    (tmp_path / "ü").mkdir()
    assert shell(tmp_path / "ü", "check_place 1").returncode == 0


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_what_another_user_made_is_refused(tmp_path):
    (tmp_path / "build").mkdir(mode=0o555)
    refused(tmp_path, "sudo chown -R")


def test_a_moved_checkout_is_built_anew_and_its_environment_kept(tmp_path):
    programs, build = tmp_path / ".venv" / "bin", tmp_path / "build"
    programs.mkdir(parents=True), build.mkdir()
    (programs / "activate").write_text('VIRTUAL_ENV="/old/place/.venv"\nexport VIRTUAL_ENV\n')
    (programs / "pytest").write_text("#!/old/place/.venv/bin/python\nimport pytest\n")
    (build / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/old/place\n")
    for name in ("setup.log", "prepared"):
        (build / name).write_text("")
    assert "moved or copied: building anew" in shell(tmp_path, "settle").stdout
    assert os.listdir(str(build)) == ["setup.log"]
    assert (programs / "pytest").read_text().startswith("#!{}/python\n".format(programs))
    assert 'VIRTUAL_ENV="{}/.venv"'.format(tmp_path) in (programs / "activate").read_text()
    (build / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL={}\n".format(tmp_path))
    assert shell(tmp_path, "settle").stdout == "" and len(os.listdir(str(build))) == 2


def test_a_display_that_does_not_answer_is_noticed():
    assert shell(ROOT, "display_answers", DISPLAY=":4711", QT_QPA_PLATFORM="xcb").returncode != 0
    assert shell(ROOT, "display_answers", QT_QPA_PLATFORM="offscreen").returncode == 0


def test_the_scripts_run_under_any_shell():
    command = ["sh", os.path.join(ROOT, "demo.sh"), "--help"]
    assert subprocess.check_output(command, text=True).startswith("Usage: ./demo.sh")
