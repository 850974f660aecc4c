"""Snapshots of experiments: a copy of all that has a state, or else the run made again from its start."""

import pickle
import random

import numpy as np

from mrs_simulator.control.law_globals import law_globals
from mrs_simulator.core.snapshots import NotCopied, Snapshot


class NotRepeated(ValueError):
    """A moment of a run that it cannot be taken back to; the message says why."""

    page = "docs/figures.md#what-if-from-any-moment"


def kept_of(experiment):
    """Return what restores ``experiment`` to its last sample: ``Copied`` or, where that cannot be,
    ``Repeated``."""
    try:
        return Copied(experiment)
    except NotCopied as error:
        return Repeated(experiment, str(error))


def global_streams():
    """Return the states of the random streams of numpy and of Python, which a law may draw from."""
    return np.random.get_state(), random.getstate()


def set_global_streams(states):
    """Put the random streams into the ``states`` that :func:`global_streams` returned."""
    np.random.set_state(states[0])
    random.setstate(states[1])


class Copied:
    """The state of an experiment, copied."""

    def __init__(self, experiment):
        """Raises ``NotCopied``."""
        self._globals = law_globals(experiment.control)
        self._snapshot, self._streams = Snapshot(experiment.stateful), global_streams()

    def restore(self, experiment):
        """Put the ``experiment`` back into this state; ``NotRepeated`` if its law has changed variables of
        its module meanwhile."""
        found = law_globals(experiment.control)
        for name, value in self._globals.items():
            if found.get(name) != value:
                text = "{} has changed since, which is no part of a snapshot; wanted it in self"
                raise NotRepeated(text.format(name))
        experiment.world.restore(self._snapshot)
        set_global_streams(self._streams)


class Repeated:
    """A sample of an experiment that is reached by running it again."""

    def __init__(self, experiment, why):
        """``why``: what could not be copied."""
        self._step, self._values, self.why = experiment.step, _values(experiment), why

    def restore(self, experiment):
        """Run the ``experiment`` again to this sample; ``NotRepeated`` if it is not the same then."""
        experiment.world.close()
        set_global_streams(experiment.streams)
        experiment.open()
        samples = experiment.samples()
        while experiment.step < self._step:
            next(samples)
        if _values(experiment) != self._values:
            text = (
                "the run is not the same again at {:.3f} s, and there is no copy of its state: {}"
            )
            raise NotRepeated(text.format(experiment.world.time, self.why))


def _values(experiment):
    """Return what robots do now, and what has happened, as bytes."""
    world = experiment.world
    arrays = world.pose, world.twist, world.command, world.joints, world.estimates.pose()
    spatial = () if world.spatial is None else world.spatial
    happened = experiment.collisions, experiment.incidents
    return pickle.dumps([world.time, *map(np.ascontiguousarray, (*arrays, *spatial)), *happened])
