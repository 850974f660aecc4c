"""What is said of refused requests: what failed and why, in the words of the window."""

import re

import pytest

from mrs_simulator.rqt_plugin.local_side.engine import Engine
from mrs_simulator.rqt_plugin.ros_side.service_calls import SERVICES
from mrs_simulator.rqt_plugin.run.answers import REFUSED, refused, without_own_files
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.study_run import StudyRun
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.world.world import World

OWN = "/tmp/mrs_simulator_gui_ab12"
LOCAL = {name[4:] for name in vars(Engine) if name.startswith("_on_")} - {"control", "hold"}


@pytest.mark.parametrize("name", sorted(LOCAL | set(SERVICES) | {"parameters", "simulated_time"}))
def test_every_request_has_words_of_the_windows(name):
    text = refused(name, "why", OWN)
    assert text == "{}: why".format(REFUSED[name])
    assert not re.search(r"[a-z]_[a-z]|failed|service", text)


def test_a_team_that_overlaps_is_refused_without_a_name_of_the_guis_own_files():
    scenario = load_scenario(scenario_path("paper_four"))._replace(path=OWN + "/scenario.yaml")
    poses = scenario.poses.copy()
    poses[0] = poses[1]
    with pytest.raises(ValueError) as raised:
        World.from_scenario(scenario._replace(poses=poses))
    assert OWN in str(raised.value)

    class Programs:
        directory = OWN

        def take_ended(self):
            text = "[INFO] begins\nsimulation: {}\n".format(raised.value)
            return [("stage", 2, text)]

        def is_running(self, _):
            return False

    class Link:
        def forget(self, _):
            pass

    run = StudyRun(Link(), Programs(), scenario)
    try:
        answer = run.take_result("set_team", False, raised.value)
        ended, *_ = run.ended_processes()
    finally:
        run.edited.close()
    for said in (answer, ended):
        assert isinstance(said, ErrorMessage) and "/tmp" not in said
        assert "robot1 and robot2 overlap" in said
    assert answer.startswith("the simulation does not take the team as edited, and keeps its own: ")


def test_what_is_said_of_other_files_stays():
    text = "a: {0}/one.yaml: no key, and {0}/two.yaml: no value in /home/me/three.yaml: x".format(
        OWN
    )
    assert without_own_files(text, OWN) == "a: no key, and no value in /home/me/three.yaml: x"
    assert without_own_files("{}/one.yaml".format(OWN), OWN) == "{}/one.yaml".format(OWN)
