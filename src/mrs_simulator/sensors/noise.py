"""One vocabulary of noise for all sensors, and the random streams that it is drawn from.

A measured value ``v`` at sample k, taken every ``period``, becomes

    q * round((v + bias + b + w_k + stddev * e_k) / q),   w_k = bias_walk * sqrt(period) * (f_1 + ... + f_k)

with ``e``, ``f`` standard normal, ``b`` normal of ``bias_stddev``, drawn once, and ``q`` the quantum; then
it is lost with probability ``dropout``.  Every draw is a function of the seed, the robot's number, the
sensor's name and k: it depends neither on the rest of the team nor on who subscribes.
"""

import zlib
from typing import NamedTuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.sensors import seeds
from mrs_simulator.vehicles.quantities import QuantitySection

KEYS = ("stddev", "bias", "bias_walk", "quantum", "dropout", "latency")
BLOCK = 1024  # [-] numbers that are drawn at a time of each robot's stream, at least one sample's
# [-] samples that are drawn at a time where there is a value for each robot of the team
SAMPLES = 16
STATES = 1024  # [-] of generators that are found at a time, at least one block's
MOST = 1e9  # [SI] of every number of noise
FINEST = 1e-12  # [SI] of a quantum


class Noise(NamedTuple):
    """The noise of one quantity, in its unit."""

    stddev: float = 0.0  # of each value
    bias: float = 0.0  # the same for all robots
    bias_stddev: float = 0.0  # of a bias that each robot draws once for each value
    bias_walk: float = 0.0  # [unit/sqrt(s)] of a random walk of the bias
    quantum: float = 0.0  # values are whole multiples of it, 0: any
    dropout: float = 0.0  # [-] probability that a value is lost
    latency: float = 0.0  # [s] from the measurement until it is available


NOISELESS = Noise()


def read_noise(section, unit, default=NOISELESS):
    """Return the ``Noise`` of a quantity with SI ``unit`` in a mapping's ``section``.

    What is left out is that of ``default``.  Raises ``ScenarioError``.
    """
    bias, bias_stddev = _read_bias(section, unit, default)
    noise = Noise(
        stddev=section.quantity("stddev", unit, default.stddev, low=0.0),
        bias=bias,
        bias_stddev=bias_stddev,
        bias_walk=section.quantity("bias_walk", unit + "/sqrt(s)", default.bias_walk, low=0.0),
        quantum=section.quantity("quantum", unit, default.quantum, low=0.0),
        dropout=section.quantity("dropout", "", default.dropout, low=0.0, high=1.0),
        latency=section.quantity("latency", "s", default.latency, low=0.0),
    )
    section.done()
    _check_sizes(noise, section)
    return noise


def _check_sizes(noise, section):
    """Raise ``ScenarioError`` for numbers that are too large or too small to compute with."""
    for key in KEYS:
        value = abs(getattr(noise, key))
        if key == "bias":
            value = max(value, noise.bias_stddev)
        if value > MOST or key == "quantum" and 0.0 < value < FINEST:
            wanted = (
                "at most {:g}".format(MOST) if value > MOST else "0 or at least {:g}".format(FINEST)
            )
            raise ScenarioError("{}: {:g}, wanted {}".format(section.at(key), value, wanted))


def _read_bias(section, unit, default):
    """Return the fixed bias, and the standard deviation of a drawn one."""
    given = section.take("bias")
    if not isinstance(given, dict):
        return section.quantity("bias", unit, default.bias), default.bias_stddev
    drawn = QuantitySection(given, section.at("bias"))
    result = 0.0, drawn.quantity("stddev", unit, low=0.0)
    drawn.done()
    return result


class Streams:
    """Random numbers of m robots for one sensor, any sample at any time.

    Each robot has a generator for each purpose, such as ``"range.stddev"``, and block of samples.
    """

    def __init__(self, seed, numbers, sensor, grows=False):
        """``numbers``: of the m robots in the team; ``sensor``: the name of the mount.

        ``grows``: a sample has a value for each robot of the team, and a larger team leaves the first as
        they are.
        """
        self._seed, self._numbers, self._sensor = seeds.words_of(seed), tuple(numbers), sensor
        self._grows = grows
        self._blocks, self._states = {}, {}

    def normal(self, purpose, width, sample):
        """Return standard normal numbers (m, width) of the whole number ``sample`` >= 0."""
        return self._of("standard_normal", purpose, width, sample)

    def uniform(self, purpose, width, sample):
        """Return numbers in [0, 1), (m, width), of ``sample``."""
        return self._of("random", purpose, width, sample)

    def _of(self, method, purpose, width, sample):
        length = SAMPLES if self._grows else max(1, BLOCK // max(1, width))
        shape = (width, length) if self._grows else (length, width)
        block, within = divmod(sample, length)
        known = self._blocks.get(purpose)
        if known is None or known[:2] != (block, width):
            drawn = np.empty((len(self._numbers), *shape))
            seeds.draw(self._states_of(purpose, block), method, drawn)
            known = self._blocks[purpose] = block, width, drawn
        return known[2][..., within] if self._grows else known[2][:, within]

    def _states_of(self, purpose, block):
        """Return the states of the generators of all robots for ``block``.

        Those of the next blocks are found with them, twice as many each time.
        """
        m = len(self._numbers)
        first, states = self._states.get(purpose, (0, []))
        if not m * first <= m * block < m * first + len(states):
            length = max(1, min(2 * len(states), STATES) // max(1, m))
            key = zlib.crc32("{}/{}".format(self._sensor, purpose).encode())
            entropy = [
                (*self._seed, number, key, block + ahead)
                for ahead in range(length)
                for number in self._numbers
            ]
            first, states = block, seeds.states(np.array(entropy, dtype=np.uint32))
            self._states[purpose] = first, states
        return states[m * (block - first) : m * (block - first + 1)]


class Draws:
    """The noise of one sensor of m robots at one sample: the argument ``rng`` of ``read``."""

    def __init__(self, noise, streams, period):
        """``noise``: ``Noise`` by quantity; ``period`` [s] between two samples."""
        self._noise, self._streams, self._period = noise, streams, period
        self._walks = {}
        self.sample = 0

    def at(self, sample):
        """Go to the whole number ``sample``, counted from the beginning of the run; return ``self``."""
        if sample < self.sample:
            self._walks = {}
        self.sample = sample
        return self

    def noisy(self, values, quantity=""):
        """Return ``values`` (m, ...) as measured; lost ones are NaN."""
        noise = self._noise.get(quantity, NOISELESS)
        if noise[:-1] == NOISELESS[:-1]:
            return values
        shape = np.shape(values)
        values = np.asarray(values, dtype=float).reshape(shape[0], -1)
        error = self._error(noise, quantity, values.shape[1])
        values = np.add(values, error, out=error if isinstance(error, np.ndarray) else None)
        if noise.quantum:
            values = noise.quantum * np.round(values / noise.quantum)
        if noise.dropout:
            values[self.lost(values.shape[1], quantity)] = np.nan
        return values.reshape(shape)

    def lost(self, width, quantity=""):
        """Return which values (m, width) bool of ``quantity`` are lost."""
        chance = self._noise.get(quantity, NOISELESS).dropout
        drawn = self._streams.uniform(quantity + ".dropout", width, self.sample) if chance else 1.0
        return np.broadcast_to(drawn < chance, (len(self._streams._numbers), width))

    def _error(self, noise, quantity, width):
        """Return the error (m, width) before rounding, a new array, or one number for all."""
        error, draw = noise.bias, self._streams.normal
        if noise.bias_stddev:
            error = error + noise.bias_stddev * draw(quantity + ".bias", width, 0)
        if noise.bias_walk:
            step = noise.bias_walk * np.sqrt(self._period)
            error = error + step * self._walked(quantity, width)
        if noise.stddev:
            drawn = noise.stddev * draw(quantity + ".stddev", width, self.sample)
            error = (
                drawn if np.ndim(error) == 0 and error == 0.0 else np.add(error, drawn, out=drawn)
            )
        return error

    def _walked(self, quantity, width):
        """Return the sum of the steps 1 to ``sample`` of a random walk, (m, width)."""
        last, total = self._walks.get(quantity, (0, 0.0))
        for sample in range(last + 1, self.sample + 1):
            total = total + self._streams.normal(quantity + ".bias_walk", width, sample)
        self._walks[quantity] = self.sample, total
        return total
