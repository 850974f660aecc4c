"""A load: a box that several robots carry together, each at its own grasp."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core import grasps
from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBER, NUMBERS, POSITIVE, REQUIRED, Field
from mrs_simulator.scenario.reading import ScenarioError, Section, number_list, unwanted

GRAVITY = 9.81  # [m/s^2]
LARGEST = 100.0  # [m] of a side, and of a grasp from the centre


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
def read_load(top, others):
    """Return the ``Load`` of a scenario's ``Section``, None without one; ``ScenarioError``."""
    if not top.has("load"):
        return top.take("load")
    section = Section(top.take("load"), top.at("load"), top.n)
    return Load(**section.values(LOAD))


def _read_grasps(section, others):
    where, given, n = section.at("grasps"), section.take("grasps"), section.n
    if not isinstance(given, list) or len(given) != n:
        raise unwanted(where, given, "[x, y, z] for each of {} robots".format(n))
    found = tuple(
        tuple(number_list(grasp, 3, "{}[{}]".format(where, row))) for row, grasp in enumerate(given)
    )
    if np.abs(found).max() > LARGEST or not grasps.are_noncollinear(found):
        raise unwanted(where, given, "at least three within {:g} m, not on a line".format(LARGEST))
    return found


LOAD = (
    Field("mass", unit="kg", low=0.01, high=1e5, type=NUMBER, rule=REQUIRED, meaning="of the box"),
    Field(
        "size",
        unit="m",
        **POSITIVE,
        high=LARGEST,
        type=NUMBERS,
        sizes=(3,),
        rule=REQUIRED,
        meaning="`[x, y, z]`: its length, width and height",
    ),
    Field(
        "grasps",
        unit="m",
        read=_read_grasps,
        rule=REQUIRED,
        meaning="`[x, y, z]` of each robot's grasp from the box's centre; at least three, not on a line",
    ),
    Field("stiffness", 1000.0, "N/m", **POSITIVE, meaning="of a grip"),
    Field(
        "grip",
        np.inf,
        "N",
        **POSITIVE,
        rule="without end, in N",
        meaning="that a grip holds at most",
    ),
)
