"""What a run without arms, imported robots, requirements and estimates need not import."""

import subprocess
import sys
from importlib.util import find_spec

COMMAND = "study.run.command", "study.results.report", "study.run.experiment"
UNUSED = (
    "core.temporal_logic.robustness",
    "sensors.pose_filter",
    "vehicles.importing.assembling",
    "vehicles.importing.description",
    "vehicles.importing.named_drives",
    "verdict.requirements.signals",
)
OF_ROS = ("control.twist_message",) if find_spec("geometry_msgs") else ()


def test_a_plain_run_imports_only_what_it_needs():
    code = "import sys, {}; print(*sys.modules)".format(
        ", ".join("mrs_simulator." + each for each in COMMAND)
    )
    imported = subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.PIPE)
    names = imported.stdout.decode().split()
    assert "mrs_simulator.study.run.experiment" in names
    assert [each for each in UNUSED + OF_ROS if "mrs_simulator." + each in names] == []
