"""Choice of a team's motion, by fidelity, medium and engine."""

from mrs_simulator.scenario.scenario import ENGINES, FIDELITIES
from mrs_simulator.vehicles import Team
from mrs_simulator.world.arms.armed import ArmedForcedMotion, ArmedMotion
from mrs_simulator.world.checks import WorldError
from mrs_simulator.world.contact.flight_contact import is_available
from mrs_simulator.world.motion.airborne import AirborneMotion, ForcedAirborneMotion
from mrs_simulator.world.motion.forced import ForcedMotion
from mrs_simulator.world.motion.kinematic import KinematicMotion, PointMassMotion

NO_SOLVER = (
    "fidelity 'dynamic': the Python package pybullet is missing; wanted it installed "
    "(pip install pybullet), or fidelity kinematic"
)


class NoSolver(WorldError):
    """Motion with forces is asked for, and pybullet is not installed."""

    page = "docs/without_ros.md"


def new_motion(team, poses, z, settings):
    """Return the motion of ``team`` from ``poses`` (n, 3) and heights ``z`` (n,) or None, all at rest.

    ``settings``: the ``WorldSettings``.  Raises ``WorldError`` where there is no such motion.
    """
    if team.has_arms:
        return _armed(team, poses, z, settings)
    if settings.fidelity == "point_mass":
        return _of_points(team, poses, z, settings)
    if settings.fidelity == "kinematic":
        return _kinematic(team, poses, z, settings)
    if settings.fidelity == "dynamic":
        return _dynamic(team, poses, z, settings)
    text = "fidelity {!r}: wanted one of {}"
    raise WorldError(text.format(settings.fidelity, ", ".join(FIDELITIES)))


def _of_points(team, poses, z, settings):
    return PointMassMotion(
        Team(team.kinds, None),
        poses,
        settings.hand_length,
        settings.step,
        mirrored=settings.mirrored,
        period=settings.command_period,
        environment=settings.environment,
        z=z,
    )


def _kinematic(team, poses, z, settings):
    bodies, more = _bodies(team, poses, settings), _moved_through(settings)
    if team.is_spatial:
        return AirborneMotion(*bodies, **more, z=z)
    return KinematicMotion(*bodies, **more)


def _dynamic(team, poses, z, settings):
    bodies, more = _bodies(team, poses, settings), _moved_through(settings)
    media = {group.drive.MEDIUM for group in team.groups}
    more.update(seed=settings.seed, engine=settings.engine)
    if settings.engine != ENGINES[0] and "ground" not in media:
        text = "engine {!r}: no robot stands on wheels; wanted it left out"
        raise WorldError(text.format(settings.engine))
    if "air" in media:
        _refuse_forceless(team)
        _need_solver()
        return ForcedAirborneMotion(*bodies, **more, z=z)
    if "water" in media:
        return ForcedMotion(*bodies, **more)
    try:
        from mrs_simulator.world.motion.wheeled import motion_of  # pybullet only where it is used
    except ModuleNotFoundError as error:
        if error.name != "pybullet":
            raise
        raise NoSolver(NO_SOLVER) from None
    return motion_of(settings.engine)(
        *bodies, mirrored=settings.mirrored, errors=settings.odometry_errors
    )


def _armed(team, poses, z, settings):
    _refuse_armed(team, settings.fidelity)
    if settings.engine != ENGINES[0] and settings.fidelity == "dynamic":
        text = "engine {!r}: robots with arms and what they carry; wanted engine {}"
        raise WorldError(text.format(settings.engine, ENGINES[0]))
    if settings.fidelity != "dynamic":
        return ArmedMotion(
            team, new_motion(team.bases, poses, z, settings), mirrored=settings.mirrored
        )
    _need_solver()
    if any(group.drive.MEDIUM != "ground" for group in team.groups):
        bases = new_motion(team.bases, poses, z, settings)
        return ArmedForcedMotion(team, bases, mirrored=settings.mirrored)
    from mrs_simulator.world.arms.dynamic_arms import ArmedDynamicMotion  # pybullet, as above

    more = {"mirrored": settings.mirrored, "errors": settings.odometry_errors}
    return ArmedDynamicMotion(*_bodies(team, poses, settings), **more)


def _bodies(team, poses, settings):
    return team, poses, settings.obstacles, settings.limits, settings.step


def _moved_through(settings):
    return {
        "mirrored": settings.mirrored,
        "encoders": settings.has_encoders,
        "environment": settings.environment,
        "errors": settings.odometry_errors,
    }


def _need_solver():
    if not is_available():
        raise NoSolver(NO_SOLVER)


def _refuse_forceless(team):
    """Raise ``WorldError`` that names the first robot that flies without a motion with forces."""
    for row, each in enumerate(team.kinds):
        if each.module.MEDIUM == "air" and not hasattr(each.module, "WITH_FORCES"):
            text = "fidelity 'dynamic': robot{}, {}, has no motion with forces; wanted kinematic"
            raise WorldError(text.format(row + 1, each.title))


def _refuse_armed(team, fidelity):
    """Raise ``WorldError`` that names the first robot whose arm has no motion of this ``fidelity``."""
    if fidelity in ("kinematic", "dynamic"):
        return
    for row, each in enumerate(team.kinds):
        if each.arm is not None:
            text = "fidelity {!r}: robot{}, {}, has an arm; wanted kinematic"
            raise WorldError(text.format(fidelity, row + 1, each.title))
