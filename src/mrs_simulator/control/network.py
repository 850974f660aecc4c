"""Distributed execution over faulty edges: each robot runs the law on the data that reached it."""

import contextlib
import copy

import numpy as np

from mrs_simulator.core.doc_links import words
from mrs_simulator.core.edge_faults import Channel


class Network:
    """Gives each robot a copy of the control, memory and all, and takes that robot's command alone.

    A copy is given the states (poses, heights and joints) that its robot knows of, its own as it is and
    the others' as they came over the edges, so that laws of whole arrays run without being written anew:
    n laws for n robots.
    A ``neighbourLaw`` is of one robot already, and needs no copies.
    """

    def __init__(self, control, links, seed):
        """``control``: whose law it is; ``links``: the edges' faults, drawn from ``seed``.

        Raises ``ValueError`` if edges are to come and go that the law does not look up.
        """
        if links.changes_edges and not control.TAKES_EDGES:
            text = (
                "links: {} does not take its neighbours from the topology at each command: edges can "
                "be neither switched nor dropped; wanted delay, or loss with on_loss: hold"
            )
            raise ValueError(text.format(type(control).__name__))
        self.copies = ()
        self._control = control
        self._channel = Channel(links, len(control.numbers), control.period, seed)
        self._time, self._begun, self._sent = None, 0.0, 0

    def commands(self, pose):
        """Return what each robot's law wants from what it knows, (n, a).

        Robots send their states once in a command period, however often this is called.  The edges
        begin anew when time does not go on.
        """
        control, state = self._control, self._state(pose)
        if self._time is None or control.time <= self._time:
            self._begin(state)
        self._time = control.time
        sent = int(round((control.time - self._begun) / control.period)) + 1
        self._channel.take(state, sent - self._sent)
        self._sent = sent
        views = self._channel.views(state, self._points)
        graph = self._channel.graph(control.topology)
        if not self.copies:
            return self._by_neighbours(pose, views, graph)
        return np.array([self._of_copy(row, view, graph) for row, view in enumerate(views)])

    def _state(self, pose):
        """Return the states (n, 4 + k) that robots send: pose, height and joints."""
        control = self._control
        heights = np.zeros(len(pose)) if control.runner.heights is None else control.runner.heights
        joints = [control.joints] if control.team.has_joints else []
        return np.column_stack([pose[:, :3], heights, *joints])

    def _parts(self, state):
        """Return poses (..., n, 3), those of points in space with heights (..., n, 4), and joints."""
        control = self._control
        pose = state[..., : control.dimension + 1]
        if not control.team.has_joints:
            return pose, control.joints
        return pose, state[..., 4:].reshape(state.shape[:-1] + control.joints.shape[1:])

    def _points(self, state):
        """Return the controlled points with heights (..., n, 3) [m] of robots in ``state``."""
        pose, joints = self._parts(state)
        points = self._control.team.point(pose, joints, self._control.l)
        return points if points.shape[-1] == 3 else np.concatenate([points, state[..., 3:4]], -1)

    def _begin(self, state):
        self._channel.begin(state)
        self._begun, self._sent = self._control.time, 0
        if not self._control.runner.is_by_neighbours:
            self.copies = [self._copy() for _ in state]

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
            hand = self._points(views)[..., : control.dimension]
            u = np.array([control.runner.seen_by(row, pose, hand[row]) for row in range(len(pose))])
        return control.commands_for(u, pose)

    def _of_copy(self, row, view, graph):
        each = self.copies[row]
        control = self._control
        pose, joints = self._parts(view)
        is_raised = control.runner.heights is not None or pose.shape[1] > 3
        heights = view[:, 3].tolist() if is_raised else None
        with _over(each, graph):
            return each.runner.commands_of_one(row, pose, joints, heights, control)


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
