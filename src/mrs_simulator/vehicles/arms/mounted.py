"""An arm on a base, as the section ``arm`` of a kind's file has it."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, unwanted
from mrs_simulator.vehicles.arms.chain import Chain
from mrs_simulator.vehicles.arms.models import MODELS, ArmModel, arm_model, chain_of
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.quantities import quantity

MOUNT = ("m", "m", "m", "rad")  # units of x, y, z and yaw
FARTHEST = 10.0  # [m] of a mount from the base's centre
BASE_AXES = {"linear.x", "linear.y", "angular.z"}  # which a base obeys apart from each other


class Arm(NamedTuple):
    """An arm of a ``model`` on a base."""

    model: ArmModel
    mount: Tuple[float, ...]  # x, y [m] from the base's centre, z [m] above the ground, yaw [rad]
    home: Tuple[float, ...]  # [rad], one for each joint

    @property
    def chain(self):
        """Return its ``Chain``, read from the user's installed pybullet_data."""
        return chain_of(self.model)

    @property
    def placed(self):
        """Return the transform (4, 4) of the arm's root into the base's frame on the ground."""
        return transform_at(self.mount[:3], (0.0, 0.0, self.mount[3]))


def read_arm(section, drive, module):
    """Return the ``Arm`` in a kind's ``section``, a ``QuantitySection``; ``ScenarioError``.

    ``drive``: the name of the base's drive, ``module`` the drive itself.
    """
    if module.JOINTS or module.MEDIUM != "ground" or not set(module.AXES) <= BASE_AXES:
        text = "{}: drive {}, wanted a wheeled base whose speeds are free of each other"
        raise ScenarioError(text.format(section.at("model"), drive))
    model = arm_model(section.text("model", choices=tuple(MODELS)), section.at("model"))
    mount = _quantities(section, "mount", MOUNT)
    home = model.home
    if section.has("home"):
        home = _quantities(section, "home", ("rad",) * len(model.joints))
    section.take("home")
    section.done()
    if max(map(abs, mount[:3])) > FARTHEST:
        raise unwanted(section.at("mount"), list(mount), "within {:g} m".format(FARTHEST))
    return Arm(model, mount, home)


def _quantities(section, key, units):
    where, given = section.at(key), section.take(key)
    if not isinstance(given, list) or len(given) != len(units):
        raise unwanted(where, given, "a list of {} numbers".format(len(units)))
    return tuple(
        quantity(value, unit, "{}[{}]".format(where, place))
        for place, (value, unit) in enumerate(zip(given, units))
    )


def check_home(arm, where):
    """Raise ``ScenarioError`` that names a joint of ``arm`` which ends before it is at home."""
    chain: Chain = arm.chain
    home = np.array(arm.home)
    bad = np.flatnonzero((home < chain.lower) | (home > chain.upper))
    if len(bad):
        i = bad[0]
        text = "{}: arm.home: {} at {:g} rad, wanted from {:g} to {:g}"
        raise ScenarioError(
            text.format(where, chain.joints[i], home[i], chain.lower[i], chain.upper[i])
        )
