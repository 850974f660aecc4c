"""Sensor readings as a control law gets them."""

import numpy as np


class Readings:
    """The newest readings of one robot, each an attribute by its sensor's name; None before the first."""

    def __init__(self, number, asked, known=None):
        """``asked``: names of the sensors in the law's ``SENSORS``; ``known``: readings by name."""
        own = self.__dict__
        own.update(dict.fromkeys(asked))
        own.update(known or {})
        own["_number"] = number

    def __getattr__(self, name):
        asked = ", ".join(key for key in self.__dict__ if not key.startswith("_")) or "none"
        text = "readings of robot {}: no {!r}; the law's SENSORS are {}"
        raise AttributeError(text.format(self.__dict__.get("_number", "?"), name, asked))

    def __setattr__(self, name, value):
        raise AttributeError("readings are not to be changed: {!r}".format(name))


def frozen(reading):
    """Return the ``reading`` with its arrays made read-only, since several readers share it."""
    for value in reading:
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return reading


def readings_by_number(numbers, asked, known):
    """Return the ``Readings`` of the robots ``numbers`` by number; ``known``: readings by row and name."""
    return {number: Readings(number, asked, known.get(row)) for row, number in enumerate(numbers)}
