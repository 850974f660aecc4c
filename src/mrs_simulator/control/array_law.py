"""Laws in a form that can be compiled with the motion of the robots, whole stretches of a run at once.

``pointMassLaw`` is then a function of arrays alone, without ``self``:

    class Gather(PioneerControl):
        PARAMETERS = (Parameter("gain", 0.5, "1/s"),)

        @array_law
        def pointMassLaw(hand, gain):
            return gain * (hand.sum(axis=0) / len(hand) - hand)

or, of a law that is one sum over edges, a method that returns its ``core.edge_terms.Flow``:

        @flow_law
        def pointMassLaw(self):
            return difference_flow(self.gain, self.topology)
"""

import functools
import inspect

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl

# of the topology: receiver, sender and weight of each arc, (m,) each
ARCS = ("first", "second", "weight")


def array_law(function):
    """Return ``pointMassLaw`` of a ``function`` of the points and of attributes, called by their names.

    ``function(points, ...)`` takes the points (n, d) [m] and returns their velocities (n, d) [m/s]; each
    further argument is the attribute of the control of that name, or one of ``first``, ``second`` and
    ``weight``, the topology's arcs.  It is written with what numba compiles, and keeps nothing.
    """
    names = list(inspect.signature(function).parameters)[1:]

    @functools.wraps(function)
    def pointMassLaw(self, hand):
        return function(hand, *_values(self, names))

    if "time" not in names:  # which stands still within a stretch
        pointMassLaw.form = lambda self: (function, _values(self, names))
    return pointMassLaw


def flow_law(method):
    """Return ``pointMassLaw`` of a ``method`` that returns the law's ``core.edge_terms.Flow``.

    A method that remembers something of the first points takes these as a further argument: None where
    a command has been given already.
    """
    sees = len(inspect.signature(method).parameters) > 1

    @functools.wraps(method)
    def pointMassLaw(self, hand):
        return (method(self, hand) if sees else method(self)).velocity(hand)

    def form(self):
        from mrs_simulator.core.compiled_terms import flow_law as loops

        flow = method(self, None) if sees else method(self)
        n, d = len(self.numbers), self.dimension
        places = np.zeros((n, d)) if flow.places is None else np.ascontiguousarray(flow.places)
        first, second, given = flow.edges()
        rows = map(np.ascontiguousarray, (first, second))
        return loops(flow.term), (places, float(flow.gain), *rows, *given)

    pointMassLaw.form = form
    return pointMassLaw


def of_samples(targets):
    """Return the method ``targets``, which is known to take the points of many samples at once.

    Points are (m, n, d) [m] then, ``self.time`` (m,) [s], and each sample's places those of it alone, to
    the bit.  A ``targets`` without the mark, as one that overrides it, is asked sample by sample.
    """
    targets.of_samples = True
    return targets


def form_of(control):
    """Return ``(function, arguments)`` of the law of ``control``, which :func:`has_form`.

    ``function(points, *arguments)`` is what numba compiles.  A first command has been given.
    """
    return type(control).pointMassLaw.form(control)


def has_form(control):
    """Return whether the law of ``control`` can be compiled, and it alone decides on commands.

    No faults of edges, no safety filter, no method of the loop that a class replaced.
    """
    formed = hasattr(getattr(type(control), "pointMassLaw", None), "form")
    return formed and control.runner.is_by_points and not control.SENSORS and is_bare(control)


def is_bare(control):
    """Return whether a law and limits alone decide on the commands of ``control``."""
    return has_plain_loop(control) and not (control.safety_filter.acts or control.deadband)


def has_plain_loop(control):
    """Return whether neither faults of edges nor methods of a class of its own decide on commands."""
    if not isinstance(control, PioneerControl):
        return False  # a stand-in with commands of its own
    return not (control.runner.replaces_loop or control.runner.network)


def _values(control, names):
    arcs = dict(zip(ARCS, control.topology.arcs))
    return tuple(arcs[name] if name in arcs else getattr(control, name) for name in names)
