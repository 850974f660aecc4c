"""Distributed execution over faulty edges: each robot runs the law on the data that reached it."""

import contextlib
import copy

import numpy as np

from mrs_simulator.core.doc_links import words
from mrs_simulator.core.edge_faults import Channel
from mrs_simulator.sensors.readings import readings_by_number


class Network:
    """Gives each robot a copy of the control, memory and all, and takes that robot's command alone.

    A copy is given the poses that its robot knows of, its own as it is and the others' as they came
    over the edges, so that laws of whole arrays run without being written anew: n laws for n robots.
    A ``neighbourLaw`` is of one robot already, and needs no copies.
    """

    def __init__(self, control, links, seed):
        """``control``: whose law it is; ``links``: the edges' faults, drawn from ``seed``.

        Raises ``ValueError`` if edges are to come and go that the law does not look up.
        """
        if links.changes_edges and not control.TAKES_EDGES:
            raise ValueError(
                "links: {} does not take its neighbours from the topology at each command: edges can "
                "be neither switched nor dropped; wanted delay, or loss with on_loss: hold".format(
                    type(control).__name__
                )
            )
        self.copies = ()
        self._control = control
        self._channel = Channel(links, len(control.numbers), control.period, seed)
        self._time, self._begun, self._sent = None, 0.0, 0

    def commands(self, pose):
        """Return what each robot's law wants from what it knows, (n, a).

        Robots tell each other where they are once in a command period, however often this is called.
        The edges begin anew when time does not go on.
        """
        control = self._control
        if self._time is None or control.time <= self._time:
            self._begin(pose)
        self._time = control.time
        sent = int(round((control.time - self._begun) / control.period)) + 1
        self._channel.take(pose, sent - self._sent)
        self._sent = sent
        views, graph = (
            self._channel.views(pose, control.points),
            self._channel.graph(control.topology),
        )
        rows = range(len(pose))
        if not self.copies:
            return self._by_neighbours(pose, views, graph)
        return np.array([self._of_copy(row, views[row], graph) for row in rows])

    def _begin(self, pose):
        self._channel.begin(pose)
        self._begun, self._sent = self._control.time, 0
        if not self._control.is_by_neighbours:
            self.copies = [self._copy() for _ in pose]

    def _copy(self):
        """Return a copy of the control, without a network of its own."""
        try:
            return copy.deepcopy(self._control, {id(self): None})
        except TypeError as error:
            raise ValueError(
                "links: {} cannot be copied for each robot: {}; wanted plain values in self, or a "
                "neighbourLaw".format(type(self._control).__name__, words(error))
            ) from None

    def _by_neighbours(self, pose, views, graph):
        control = self._control
        with _over(control, graph):
            hand = control.points(views)
            u = np.array([control.seen_by(row, pose, hand[row]) for row in range(len(pose))])
        return control.commands_for(u, pose)

    def _of_copy(self, row, view, graph):
        each = self.copies[row]
        control = self._control
        each._keep(time=control.time, joints=control.joints, _heights=control._heights)
        if control.SENSORS:  # nobody has the sensors of others
            number = control.numbers[row]
            others = readings_by_number(control.numbers, control.SENSORS, {})
            each._keep(readings={**others, number: control.readings[number]})
        with _over(each, graph):
            return each.wanted_commands(view)[row]


@contextlib.contextmanager
def _over(control, graph):
    """Let ``control`` have the edges of ``graph`` meanwhile."""
    usual = control.topology
    if graph is not usual and control.TAKES_EDGES:
        control.topology = graph
    try:
        yield
    finally:
        if control.topology is graph:
            control.topology = usual
