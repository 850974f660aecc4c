"""A load: a box that several robots carry together, each at its own grasp."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core import grasps
from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, number_list, shown

GRAVITY = 9.81  # [m/s^2]
LARGEST = 100.0  # [m] of a side, and of a grasp from the centre
MASSES = 0.01, 1e5  # [kg]


class Load(NamedTuple):
    """A homogeneous box that robot i holds at ``grasps[i]``."""

    mass: float  # [kg]
    size: Tuple[float, ...]  # [m] length, width, height
    grasps: Tuple[Tuple[float, ...], ...]  # (n, 3) [m] from its centre, along its axes
    stiffness: float = 1000.0  # [N/m] of each grip
    grip: float = np.inf  # [N] that a grip holds at most

    @property
    def weight(self):
        """Return the wrench (6,) [N, N m] about the centre that robots exert against its weight."""
        return np.array([0.0, 0.0, self.mass * GRAVITY, 0.0, 0.0, 0.0])

    @property
    def inertia(self):
        """Return the moments (3,) [kg m^2] about its axes: ``m (b^2 + c^2)/12``."""
        a, b, c = np.square(self.size)
        return self.mass / 12.0 * np.array([b + c, a + c, a + b])

    def with_robots(self, n):
        """Return the load that the first n robots carry; ``ScenarioError`` if they cannot."""
        if n > len(self.grasps) or not grasps.are_noncollinear(self.grasps[:n]):
            text = "load with {} robots: {} grasps, wanted one for each, at least three and not on a line"
            raise ScenarioError(text.format(n, len(self.grasps)))
        return self._replace(grasps=self.grasps[:n])

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        plain = {"mass": self.mass, "size": list(self.size), "stiffness": self.stiffness}
        plain["grasps"] = [list(grasp) for grasp in self.grasps]
        return plain if np.isinf(self.grip) else dict(plain, grip=self.grip)


@explained_by("docs/manipulators.md#carrying-together")
def read_load(top, n):
    """Return the ``Load`` of a scenario's ``Section``, None without one; ``ScenarioError``."""
    if not top.has("load"):
        return top.take("load")
    section = Section(top.take("load"), top.at("load"))
    low, high = MASSES
    size = section.numbers("size", 3)
    if not all(0.0 < side <= LARGEST for side in size):
        text = "{}: {}, wanted three sides above 0, at most {:g} m"
        raise ScenarioError(text.format(section.at("size"), size, LARGEST))
    load = Load(
        mass=section.number("mass", low=low, high=high),
        size=tuple(size),
        grasps=_read_grasps(section, n),
        stiffness=section.number("stiffness", 1000.0, above=0.0),
        grip=section.number("grip", above=0.0) if section.has("grip") else np.inf,
    )
    section.take("grip")
    section.done()
    return load


def _read_grasps(section, n):
    where, given = section.at("grasps"), section.take("grasps")
    if not isinstance(given, list) or len(given) != n:
        text = "{}: {}, wanted [x, y, z] for each of {} robots"
        raise ScenarioError(text.format(where, shown(given), n))
    found = tuple(
        tuple(number_list(grasp, 3, "{}[{}]".format(where, row))) for row, grasp in enumerate(given)
    )
    if np.abs(found).max() > LARGEST or not grasps.are_noncollinear(found):
        text = "{}: {}, wanted at least three within {:g} m, not on a line"
        raise ScenarioError(text.format(where, shown(given), LARGEST))
    return found
