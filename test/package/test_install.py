"""The package built into catkin's install space, without the devel space."""

import os
import shutil
import subprocess
import sys

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ROS_SETUP = "/opt/ros/noetic/setup.sh"
CHECK = """
set -e
[ ! -f {ros} ] || . {ros}
. {install}/setup.sh
test "$(rospack find mrs_simulator)" = {install}/share/mrs_simulator
python3 -c 'import mrs_simulator.core as c; print(c.__file__)' | grep -q ^{install}/
rosmsg show mrs_simulator/TeamState | grep -q 'theta'
rossrv show mrs_simulator/SetTeam | grep -q 'RobotSpec'
roslaunch --nodes mrs_simulator simulation.launch | grep -q pioneer_control
rosrun mrs_simulator experiment {install}/share/mrs_simulator/scenarios/paper_dynamic.yaml \
  --duration 1 --out {out} || test $? = 1
test "$(command -v mrs-simulator)" = {install}/bin/mrs-simulator
mrs-simulator scenarios | grep -q paper_dynamic
test -s {out}/run.csv -a -s {out}/trajectories.pdf
"""


def test_the_command_is_in_the_path_of_the_devel_space():
    found = shutil.which("mrs-simulator")
    assert found and os.path.exists(os.path.join(os.path.dirname(found), "..", ".catkin"))
    listed = subprocess.run([found, "scenarios"], stdout=subprocess.PIPE, timeout=60, check=True)
    assert b"paper_dynamic.yaml" in listed.stdout


@pytest.mark.release
def test_the_install_space_builds_and_runs(tmp_path):
    build, install = str(tmp_path / "build"), str(tmp_path / "install")
    commands = [
        [
            "cmake", "-S", ROOT, "-B", build, "-DCMAKE_INSTALL_PREFIX=" + install,
            "-DPYTHON_EXECUTABLE=" + sys.executable, "-DCATKIN_ENABLE_TESTING=OFF",
        ],
        ["make", "-C", build, "install"],
    ]  # fmt: skip
    # Nothing of the devel space that the tests themselves run in.
    kept = ("HOME", "LANG", "PATH", "TMPDIR")
    environment = {key: os.environ[key] for key in kept if key in os.environ}
    out = str(tmp_path / "out")
    script = CHECK.format(ros=ROS_SETUP, install=install, out=out)
    for command in commands + [["sh", "-c", script]]:
        done = subprocess.run(
            command, env=environment, timeout=240, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        assert done.returncode == 0, done.stdout.decode()[-3000:]
