"""Setting up: places in which nothing can be built are refused in one line, moved ones built anew."""

import os
import shutil
import subprocess

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PREPARE = os.path.join(ROOT, "tools", "prepare.sh")
# To root a file's permissions mean nothing, but without these capabilities.
AS_OTHERS = ("setpriv", "--bounding-set", "-dac_override,-dac_read_search")


def shell(root, command, **environment):
    """Return the finished ``command``, in bash, after ``tools/prepare.sh`` for the checkout ``root``."""
    text = 'root="{}" && . "{}" && {}'.format(root, PREPARE, command)
    return subprocess.run(
        [*(AS_OTHERS if os.geteuid() == 0 and shutil.which("setpriv") else ()), "bash", "-c", text],
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


@pytest.mark.skipif(
    os.geteuid() == 0 and shutil.which("setpriv") is None, reason="root may write anywhere"
)
def test_what_may_not_be_written_is_refused_by_its_owner(tmp_path):
    (tmp_path / "build").mkdir(mode=0o555)
    refused(tmp_path, "chmod -R u+w")
    (tmp_path / "stat").write_text("#!/bin/sh\necho alice\n")
    (tmp_path / "stat").chmod(0o755)
    refused(tmp_path, "alice's: copy", PATH="{}:{}".format(tmp_path, os.environ["PATH"]))


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
    asked = shell(ROOT, "display_answers; exit $?", DISPLAY=":4711", QT_QPA_PLATFORM="xcb")
    assert asked.returncode != 0 and asked.stderr == ""
    assert shell(ROOT, "display_answers", QT_QPA_PLATFORM="offscreen").returncode == 0


def test_the_scripts_run_under_any_shell():
    command = ["sh", os.path.join(ROOT, "demo.sh"), "--help"]
    assert subprocess.check_output(command, text=True).startswith("Usage: ./demo.sh")


def found_ros(folder, release, in_archive):
    """Return what ``find_ros`` does on a system of that ``release``, whose archive has ROS or not."""
    (folder / "os-release").write_text(release)
    (folder / "build").mkdir()
    for name, code in (("apt-cache", not in_archive), ("apt-get", 0)):
        (folder / name).write_text("#!/bin/sh\nexit {:d}\n".format(code))
        (folder / name).chmod(0o755)
    command = "os_release={}/os-release; install_packages() {{ echo $*; }}; find_ros".format(folder)
    return shell(folder, command, PATH="{}:{}".format(folder, os.environ["PATH"]))


@pytest.mark.skipif(os.path.exists("/opt/ros/noetic"), reason="Noetic is taken where it is")
@pytest.mark.parametrize(
    "release, in_archive, has, lacks",
    [
        ("ID=debian\nVERSION_ID=12\n", False, "python3-python-qt-binding", "python3-dev"),
        ("ID=debian\nVERSION_ID=13\n", False, "python3-dev", "python3-python-qt-binding"),
        ("ID=debian\n", False, "ros-environment", "python3-python-qt-binding"),  # testing
        ("ID=ubuntu\nVERSION_CODENAME=jammy\n", True, "python3-rospy", "python3-dev"),
    ],
)
def test_a_system_gets_the_packages_that_it_has(tmp_path, release, in_archive, has, lacks):
    result = found_ros(tmp_path, release, in_archive)
    names = result.stdout.split()
    assert result.returncode == 0 and "python3-rospy" in names
    assert has in names and lacks not in names


@pytest.mark.skipif(os.path.exists("/opt/ros/noetic"), reason="Noetic is taken where it is")
def test_on_a_system_without_ros_the_front_door_says_what_works(tmp_path):
    noble = "ID=ubuntu\nVERSION_CODENAME=noble\nPRETTY_NAME='Ubuntu 24.04 LTS'\n"
    result = found_ros(tmp_path, noble, False)
    what, remedy = result.stderr.strip().split("\n")
    assert result.returncode == 2 and what.endswith("Ubuntu 24.04 LTS has no packages of it")
    assert "pip install . && mrs-simulator experiment paper.yaml" in remedy


def installed(folder, sudo):
    """Return what ``install_packages`` does for a user on a system with that ``sudo``."""
    (folder / "build").mkdir()
    programs = {
        "id": "echo 1000",
        "sudo": sudo,
        "dpkg-query": "exit 1",
        # As apt does, which takes a lock even where it only asks.
        "apt-get": '[ "$ROOT" ] && echo Need to get 306 MB of archives.',
    }
    for name, text in programs.items():
        (folder / name).write_text("#!/bin/sh\n{}\n".format(text))
        (folder / name).chmod(0o755)
    path = "{}:{}".format(folder, os.environ["PATH"])
    return shell(folder, "install_packages python3-rospy", PATH=path)


def test_a_user_reads_the_size_before_packages_are_installed(tmp_path):
    assert "\n   306 MB to download\n" in installed(tmp_path, 'ROOT=1 exec "$@"').stdout


def test_progress_is_shown_while_apt_works(tmp_path):
    os.mkfifo(str(tmp_path / "seen"))
    apt = "{ echo dlstatus:1:25.5:Retrieving; timeout 5 cat $root/seen >&2; }"
    reader = "timeout 10 sh -c 'read line; echo $line >$0/seen' $root"
    result = shell(tmp_path, apt + " | apt_progress | " + reader)
    assert result.stderr == "downloading 25 %\n"


def test_a_user_whom_sudo_refuses_is_told_so(tmp_path):
    result = installed(tmp_path, "echo you are not in the sudoers file >&2; exit 1")
    assert result.returncode == 2 and "as a user whom sudo lets" in result.stderr
    assert "306 MB" not in result.stdout


def test_what_ships_is_compiled_once_beside_the_demo(tmp_path):
    programs, motion = tmp_path / ".venv" / "bin", tmp_path / "src/mrs_simulator/world/motion"
    for folder in (programs, motion, tmp_path / "build"):
        folder.mkdir(parents=True)
    for name in ("stretches.py", "fused_stepping.py"):
        (motion / name).write_text("")
    (tmp_path / "requirements.txt").write_text("numba==1\n")
    (programs / "python").write_text('#!/bin/sh\necho "$@"\n')
    (programs / "python").chmod(0o755)
    log = tmp_path / "build" / "compiled.log"
    assert shell(tmp_path, "compile_ahead && wait").stdout == ""
    assert log.read_text() == "-m mrs_simulator.study.run.compile_ahead\n"
    log.unlink()
    assert shell(tmp_path, "compile_ahead && wait").returncode == 0 and not log.exists()
    (tmp_path / "requirements.txt").write_text("numba==2\n")
    assert shell(tmp_path, "compile_ahead && wait").returncode == 0 and log.exists()
