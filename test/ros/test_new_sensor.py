"""The sensor that the developer's page writes as an example is read, recorded and published."""

import math
import os
import re
from typing import NamedTuple

import numpy as np
import pytest
from geometry_msgs.msg import Vector3Stamped
from std_msgs.msg import Header

from mrs_simulator.core.kinematics import direction_of, wrap_angle
from mrs_simulator.ros.message_forms.sensor_forms.form import Form
from mrs_simulator.ros.message_forms.sensor_messages import FORMS, forms_of
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.number_texts import degrees
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.study.run.sensor_files import FILE
from mrs_simulator.vehicles import Team

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
with open(os.path.join(ROOT, "docs", "development.md"), encoding="utf-8") as page:
    SECTION = page.read().partition("## How to add a sensor")[2]
CODE = re.search(r"```\n(.*?)```", SECTION, re.S).group(1)


class Pointer(Form):
    """A Vector3Stamped of length 1 towards the landmark."""

    TYPE = "landmark"
    MESSAGE = Vector3Stamped

    def message(self, item, header):
        message = Vector3Stamped(header=header)
        message.vector.x, message.vector.y = math.cos(item[0]), math.sin(item[0])
        return message


@pytest.fixture()
def landmark(monkeypatch):
    """Let the type of the page, and its form, be among those that are found."""
    scope = dict(NamedTuple=NamedTuple, np=np, degrees=degrees, Sensor=Sensor)
    scope.update(direction_of=direction_of, wrap_angle=wrap_angle)
    exec(compile(CODE, "development.md", "exec"), scope)
    monkeypatch.setitem(TYPES, "landmark", scope["Landmark"])
    monkeypatch.setattr("mrs_simulator.ros.message_forms.sensor_messages.FORMS", [*FORMS, Pointer])
    return scope["LandmarkReading"]


def test_the_example_is_recorded_and_published(landmark, tmp_path):
    mount = {"type": "landmark", "point": [3.0, 1.0], "noise": {"quantum": 0.25}}
    given = scenario_from_dict({
        "poses": [[2.0, 0.0, 0.5 * math.pi], [-1.0, 1.0, 1.0]], "duration": 0.1,
        "sensors": [{"mounts": {"light": mount}}], "record": ["light"],
    })  # fmt: skip
    perform(given, str(tmp_path))
    name = str(tmp_path / FILE.format("light"))
    rows = np.genfromtxt(name, delimiter=",", names=True)
    assert rows.dtype.names == ("time", "robot", "bearing")
    # Ahead to the left at 45 deg as seen along x: 45 deg to the right; 0 less 1 rad, in quarters.
    assert rows["bearing"][:2].tolist() == [-0.75, -1.0]
    team = Team.from_scenario(given)
    mounts = fitted_mounts(team, given.sensors)[0]
    (form,) = forms_of(next(each for each in mounts if each.name == "light"), team.kinds[0])
    (item,) = form.rows(landmark(2.0, np.array([-0.75])))
    assert form.message(item, Header()).vector.y == pytest.approx(math.sin(-0.75))
    assert landmark(2.0, -0.75).text() == "landmark at \u221243.0\u00b0"
