"""The models of arms: which file of the user's own ``pybullet_data`` describes each, never copied."""

import functools
import importlib.util
import os
from typing import NamedTuple, Tuple

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.vehicles.arms.chain import read_chain

DATA = "pybullet_data"  # the package that comes with pybullet


class ArmModel(NamedTuple):
    """An arm: its description, the joints between its root and its tool, and a posture to work from."""

    name: str
    title: str
    file: str  # in pybullet_data
    joints: Tuple[str, ...]
    tool: str  # the link whose origin is the tool point
    home: Tuple[float, ...]  # [rad] the elbow up, the tool ahead of the base


# The files have no payloads: 3 kg, 5 kg and 7 kg after the makers' data sheets, from memory.
PANDA = ArmModel(
    name="panda",
    title="Panda arm",
    file="franka_panda/panda.urdf",
    joints=tuple("panda_joint{}".format(i) for i in range(1, 8)),
    tool="panda_grasptarget",
    home=(0.0, 0.3, 0.0, -1.9, 0.0, 2.2, 0.785),
)
XARM6 = ArmModel(
    name="xarm6",
    title="xArm 6 arm",
    file="xarm/xarm6_robot.urdf",
    joints=tuple("joint{}".format(i) for i in range(1, 7)),
    tool="link6",
    home=(0.0, -0.2, -0.9, 0.0, 1.1, 0.0),
)
IIWA = ArmModel(
    name="iiwa",
    title="iiwa arm",
    file="kuka_iiwa/model.urdf",
    joints=tuple("lbr_iiwa_joint_{}".format(i) for i in range(1, 8)),
    tool="lbr_iiwa_link_7",
    home=(0.0, 0.5, 0.0, -1.6, 0.0, 1.0, 0.0),
)
MODELS = {model.name: model for model in (PANDA, XARM6, IIWA)}


def arm_model(name, where):
    """Return the ``ArmModel`` called ``name``; ``ScenarioError`` with ``where`` if there is none."""
    if name not in MODELS:
        raise ScenarioError(unknown_name(where, name, MODELS))
    return MODELS[name]


def data_file(file):
    """Return the path of ``file`` in the installed pybullet_data; ``ScenarioError`` if it is not there."""
    found = importlib.util.find_spec(DATA)
    if found is None or not found.origin:
        text = (
            "arm {}: the Python package {} is missing; wanted it installed (pip install pybullet)"
        )
        raise ScenarioError(text.format(file, DATA))
    path = os.path.join(os.path.dirname(found.origin), *file.split("/"))
    if not os.path.isfile(path):
        raise ScenarioError("{}: no such file, wanted it in {}".format(path, DATA))
    return path


@functools.lru_cache(maxsize=None)
def chain_of(model):
    """Return the ``Chain`` of an ``ArmModel``, from the user's installed pybullet_data."""
    return read_chain(data_file(model.file), model.joints, model.tool)
