"""What of a recorded run cannot be, given the robots that its scenario names."""

import numpy as np

from mrs_simulator.core.claims import Condition
from mrs_simulator.scenario.incidents import SATURATED
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.impossible_poses import first_jump, first_overlap


def impossibilities(run):
    """Return a broken ``Condition`` for whatever cannot be in ``run``, none for a run that can be.

    Robots that jump beyond their top speeds; where no collisions are reported, as real robots do not,
    bodies that fill the same place.  Point masses have neither.
    """
    scenario = run.scenario
    if scenario is None or scenario.fidelity == "point_mass" or len(run.robots) != scenario.n:
        return []
    team = Team.from_scenario(scenario)
    found = [_jumps(run, team)]
    if run.meta.get("collisions_unknown"):
        found.append(_overlaps(run, team))
    return [each for each in found if each is not None]


def _jumps(run, team):
    found = first_jump(run.time, _standing(run), team.speeds[:, 0], run.z)
    if found is None:
        return None
    sample, row, distance = found
    why = "at {:.3f} s robot{} by {:.2f} m within {:.3f} s".format(
        run.time[sample], run.robots[row], distance, run.time[sample] - run.time[sample - 1]
    )
    return Condition("no robot jumps", False, why, necessary=True)


def _standing(run):
    """Return the poses (m, n, 3) of ``run``, nan where robots fall, which nothing holds to top speeds."""
    fallen = [each for each in run.meta.get("incidents", ()) if each.what != SATURATED]
    names = ["robot{:g}".format(number) for number in run.robots]
    pose = run.pose.copy() if fallen else run.pose
    for each in fallen:
        if each.robot in names:
            pose[run.time >= each.time, names.index(each.robot)] = np.nan
    return pose


def _overlaps(run, team):
    outline = team.outlines
    inner = np.minimum(np.minimum(outline.front, outline.rear), 0.5 * np.asarray(outline.width))
    inner = np.broadcast_to(inner, (team.n,))
    tall = np.array([kind.body.height for kind in team.kinds])
    found = first_overlap(run.pose, inner, run.z, tall)
    if found is None:
        return None
    sample, i, j, distance = found
    why = "at {:.3f} s robot{} and robot{} were {:.2f} m apart, and fill {:.2f} m".format(
        run.time[sample], run.robots[i], run.robots[j], distance, inner[i] + inner[j]
    )
    return Condition("bodies are apart", False, why, necessary=True)
