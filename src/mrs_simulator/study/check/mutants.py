"""Mistakes that are put into a law on purpose, to see whether a verdict notices them."""

from typing import Any, Callable, NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import point_mass_from_unicycle, unicycle_from_point_mass
from mrs_simulator.study.check.source_mutants import source_edits

SHARES = (0.7, 1.4)  # [-] by which numbers among the parameters are multiplied
WIND = 0.05  # [m/s] that blows one robot away
TURN = np.radians(30.0)
CUBIC = 0.1  # [s^2/m^2] of a term with the third power of a velocity
SEED = "seed"  # a parameter that theory says nothing of


class Mutant(NamedTuple):
    """A mistake: other ``parameters``, an ``edit`` of the law's source, or a ``change`` of commands.

    ``change(command (n, 2), theta (n,), l)`` returns the wrong commands (n, 2); ``late``: the commands of
    one period before are.  ``slight``: claims about ends and rates may well not notice it.
    """

    name: str
    parameters: dict = {}
    change: Callable = None
    edit: Any = None
    late: bool = False
    slight: bool = False


class Mutated:
    """A control whose commands are changed by ``mutant`` before they reach the robots."""

    def __init__(self, control, mutant):
        self._control, self._mutant, self._before = control, mutant, None

    def start(self):
        """Begin anew."""
        self._before = None
        self._control.start()

    def commands(self, pose, time=0.0, joints=None):
        """Return the wrong commands, (n, 2) [m/s, rad/s]."""
        command = np.array(self._control.commands(pose, time, joints))
        if self._mutant.late:
            before, self._before = self._before, command
            return command if before is None else before
        return self._mutant.change(command, np.asarray(pose)[:, 2], self._control.l)


def _one_stands(command, *_):
    command[0] = 0.0
    return command


def _by_velocity(change):
    """Return the change of commands that changes the hand points' velocities (n, 2) by ``change``."""

    def changed(command, theta, l):
        velocity = change(point_mass_from_unicycle(command, theta, l))
        return unicycle_from_point_mass(velocity, theta, l)

    return changed


def _blown(velocity):
    velocity[-1, 0] += WIND
    return velocity


def _turned(velocity):
    cos, sin = np.cos(TURN), np.sin(TURN)
    return velocity @ np.array([[cos, sin], [-sin, cos]])


def _faster_along_y(velocity):
    velocity[:, 1] *= 1.1
    return velocity


def _with_cubic_term(velocity):
    return velocity * (1.0 + CUBIC * np.sum(velocity**2, axis=1, keepdims=True))


OF_COMMANDS = (
    Mutant("all stand still", change=lambda command, *_: 0.0 * command),
    Mutant("all go the other way", change=lambda command, *_: -command),
    Mutant("all go at 0.7 of their speed", change=lambda command, *_: 0.7 * command),
    Mutant("all go at 1.4 of their speed", change=lambda command, *_: 1.4 * command),
    Mutant("the first robot stands still", change=_one_stands),
    Mutant("the last robot drifts at 5 cm/s", change=_by_velocity(_blown)),
    Mutant("all go 30 degrees to the left", change=_by_velocity(_turned)),
)
SLIGHT = (
    Mutant("all go at 1.04 of their speed", change=lambda command, *_: 1.04 * command),
    Mutant("all go at 1.1 of their speed along y", change=_by_velocity(_faster_along_y)),
    Mutant("a cubic term, u (1 + 0.1 u^2)", change=_by_velocity(_with_cubic_term)),
    Mutant("commands of one period before", late=True),
)


def mutants_of(control):
    """Return the mutants of ``control``: of its commands, its source, and one or two for each parameter.

    A number is multiplied by ``SHARES``, a whole one goes up and down by one, true becomes false, and a
    choice each other one.  ``l`` and ``seed`` are no part of what theory says, and values that the law
    refuses no mistakes.
    """
    found = [*OF_COMMANDS, *(mutant._replace(slight=True) for mutant in SLIGHT)]
    found += [Mutant(name, edit=edit) for name, edit in source_edits(type(control)).items()]
    for parameter in control.PARAMETERS:
        if parameter.name in ("l", SEED):
            continue
        for value, words in _others(parameter, control.parameters[parameter.name]):
            given = dict(control.parameters, **{parameter.name: value})
            try:
                control.checked_parameters(given)
            except ValueError:
                continue
            found.append(Mutant("{} {}".format(parameter.name, words), given))
    return found


def _others(parameter, value):
    """Return ``(value, words)`` of the wrong values that stand in for ``value``."""
    if parameter.choices:
        return [(other, "is " + other) for other in parameter.choices if other != value]
    if isinstance(value, bool):
        return [(not value, "is {}".format("false" if value else "true"))]
    if isinstance(value, int):
        return [(value + 1, "is one more"), (value - 1, "is one less")]
    if isinstance(value, float):
        if value == 0.0:
            return [(0.1, "is 0.1 in place of 0")]
        return [(share * value, "times {:g}".format(share)) for share in SHARES]
    return []
