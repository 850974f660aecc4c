"""What a world refuses: robots, places, loads and events that cannot be."""

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.uneven_wheels import UnevenWheels
from mrs_simulator.scenario.incidents import PUSHED
from mrs_simulator.scenario.scenario import FARTHEST
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.arms.team import ArmedTeam, has_arms
from mrs_simulator.world.contact.bodies import Bodies


class WorldError(ValueError):
    """Something the world cannot be; the message names it, what came and what was wanted."""

    page = "docs/scenarios.md#where-robots-begin"


def checked_team(kinds, poses, limits):
    """Return the ``Team`` of ``kinds``, and ``poses`` (n, 3) floats; ``WorldError`` if they are not."""
    kinds = kinds if isinstance(kinds, Team) else tuple(kinds)
    count = kinds.n if isinstance(kinds, Team) else len(kinds)
    poses = np.array(poses, dtype=float)
    if poses.shape != (count, 3) or not count:
        text = "poses of shape {}: wanted one [x, y, theta] for each of {} robots, at least one"
        raise WorldError(text.format(poses.shape, count))
    refuse_places(range(count), poses)
    try:
        team = Team.of(kinds, limits)
        if has_arms(team.kinds) and not team.has_arms:
            team = ArmedTeam(team.kinds, limits)
        return team, poses
    except ValueError as error:
        raise WorldError(str(error)) from None


def checked_heights(team, z):
    """Return the heights ``z`` (n,) as floats, None for a team on the ground; ``WorldError`` names a robot
    that cannot be there."""
    z = np.zeros(team.n) if z is None else np.array(z, dtype=float)
    if z.shape != (team.n,):
        raise WorldError("heights of shape {}: wanted one of {} robots".format(z.shape, team.n))
    bad = np.flatnonzero(~((z >= 0.0) & (z <= FARTHEST)))
    if len(bad):
        text = "robot{}: height {} m, wanted from 0 to {:g} m"
        raise WorldError(text.format(bad[0] + 1, z[bad[0]], FARTHEST))
    stuck = np.flatnonzero((z != 0.0) & ~team.airborne)
    if len(stuck):
        text = "robot{}: height {:g} m, but a {} stays on the ground; wanted 0"
        row = stuck[0]
        raise WorldError(text.format(row + 1, z[row], team.kinds[row].title))
    return z if team.is_spatial else None


def refuse_mirrored(mirrored, n):
    """Raise ``WorldError`` if a row of ``mirrored``, sorted, is none of a team of ``n`` robots."""
    if len(mirrored) and not 0 <= mirrored[0] <= mirrored[-1] < n:
        text = "real robots {}: wanted numbers from 1 to {}, the size of the team"
        raise WorldError(text.format((mirrored + 1).tolist(), n))


def refuse_places(rows, poses, twists=0.0):
    """Raise ``WorldError`` that names the first of robots ``rows`` that can be at no such pose."""
    # A comparison with nan is false.
    fits = (np.abs(poses) <= FARTHEST).all(axis=1) & np.isfinite(poses + twists).all(axis=1)
    bad = np.flatnonzero(~fits)
    if len(bad):
        text = "robot{}: pose {}, wanted finite numbers within {:g} m"
        raise WorldError(text.format(rows[bad[0]] + 1, poses[bad[0]].tolist(), FARTHEST))


def refuse_overlaps(kinds, poses, obstacles, mirrored=(), z=None):
    """Raise ``WorldError`` that names the first robots, or robot and obstacle, that overlap.

    Two ``mirrored`` rows may, since real robots are where they are.
    """
    bodies = Bodies(kinds, obstacles, mirrored)
    first, second, depth, _ = bodies.overlaps(poses, z)
    put = ~(bodies.mirrored[first] & bodies.mirrored[second])
    first, second, depth = first[put], second[put], depth[put]
    if len(first):
        i, j = first[0], second[0]
        raise WorldError(
            "robot{} and robot{} overlap: centres {:.3f} m apart, bodies {:.3f} m into each other; "
            "wanted them apart".format(
                i + 1, j + 1, np.linalg.norm(poses[i, :2] - poses[j, :2]), depth[0]
            )
        )
    refuse_in_obstacles(bodies, poses, z)


def refuse_in_obstacles(bodies, poses, z=None):
    """Raise ``WorldError`` that names the first robot and obstacle of ``bodies`` that overlap."""
    for obstacle, rows, _, _ in bodies.obstacle_overlaps(poses, z):
        raise WorldError(
            "robot{} overlaps obstacle {}; wanted them apart".format(rows[0] + 1, obstacle.name)
        )


def count_wheels(mounts, fidelity):
    """Return whether any of ``mounts``, of each robot, are encoders.

    ``WorldError`` names those of a point mass, which would count nothing.
    """
    for row, own in enumerate(mounts):
        for mount in own:
            if mount.type == "encoders":
                if fidelity == "point_mass":
                    text = "robot{}: {} are encoders, but point masses have no wheels; wanted {}"
                    wanted = "fidelity kinematic or dynamic"
                    raise WorldError(text.format(row + 1, mount.name, wanted))
                return True
    return False


def refuse_uneven_wheels(team, errors):
    """Raise ``WorldError`` for unequal wheels, of ``OdometryErrors``, of robots without a left and a
    right one."""
    if UnevenWheels.of(errors) is None:
        return
    for group in team.groups:
        drive = group.drive
        if drive.ENCODERS and (drive.SECTION != "wheels" or drive.JOINTS or drive.ENCODERS != 2):
            raise WorldError(
                "odometry_errors: Ed = {:g}, Eb = {:g}, but a {} has no left and right wheel to "
                "move by; wanted 1".format(errors.Ed, errors.Eb, group.kinds[0].title)
            )


def _refuse_push(team, event, fidelity):
    why = ""
    if fidelity == "dynamic":
        why = "fidelity dynamic; wanted kinematic or point_mass"
    elif team.has_arms:
        why = "a team with arms; wanted robots without"
    elif fidelity != "point_mass" and event.robot <= team.n and team.airborne[event.robot - 1]:
        why = "which flies; wanted one on the ground or in the water, or fidelity point_mass"
    if why:
        raise WorldError("events: {} of robot{}, {}".format(event.event, event.robot, why))


@explained_by("docs/scenarios.md#faults-and-pushes")
def refuse_events(team, events, fidelity):
    """Raise ``WorldError`` that names the first of ``events`` that cannot happen to the ``team``."""
    for event in events:
        kind = team.kinds[event.robot - 1] if event.robot <= team.n else None
        if event.event == PUSHED:
            _refuse_push(team, event, fidelity)
        elif kind is not None and (not hasattr(kind.module, "lost") or fidelity == "point_mass"):
            why = "a {} without rotors".format(kind.title)
            if fidelity == "point_mass":
                why = "in fidelity point_mass, which has none"
            text = "events: {} of robot{}, {}; wanted a robot that flies"
            raise WorldError(text.format(event.event, event.robot, why))
