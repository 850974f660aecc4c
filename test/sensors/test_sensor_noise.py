"""The vocabulary of noise: statistics over many draws, and streams that depend on nobody else."""

import zlib

import numpy as np
import pytest

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.sensors import seeds
from mrs_simulator.sensors.noise import BLOCK, SAMPLES, Draws, Noise, Streams, read_noise
from mrs_simulator.vehicles.quantities import QuantitySection

DRAWN = 10000
PERIOD = 0.1  # [s]


def draws(noise, numbers=(1, 2), sensor="sonar", seed=0):
    return Draws({"": noise}, Streams(seed, numbers, sensor), PERIOD)


def measured(noise, samples=DRAWN, width=1, **options):
    """Return 5 m as it is measured, (samples, robots, width)."""
    drawn = draws(noise, **options)
    robots = len(options.get("numbers", (1, 2)))
    return np.array([drawn.at(k).noisy(np.full((robots, width), 5.0)) for k in range(samples)])


def test_the_standard_deviation_is_that_of_the_noise_for_every_robot():
    values = measured(Noise(stddev=0.2))[:, :, 0]
    # Four standard deviations of the estimates: 0.2/sqrt(N) of the mean, 0.2/sqrt(2 N) of the other.
    assert np.abs(values.mean(axis=0) - 5.0).max() < 4.0 * 0.2 / np.sqrt(DRAWN)
    assert np.abs(values.std(axis=0) - 0.2).max() < 4.0 * 0.2 / np.sqrt(2.0 * DRAWN)
    assert abs(np.corrcoef(values.T)[0, 1]) < 4.0 / np.sqrt(DRAWN)
    assert abs(np.corrcoef(values[1:, 0], values[:-1, 0])[0, 1]) < 4.0 / np.sqrt(DRAWN)


def test_a_bias_moves_all_values_alike_and_a_drawn_one_each_robot_once():
    assert measured(Noise(bias=0.3), samples=3) == pytest.approx(5.3)
    numbers = tuple(range(1, DRAWN + 1))
    values = measured(Noise(bias_stddev=0.3), samples=2, numbers=numbers)[:, :, 0]
    assert np.array_equal(values[0], values[1])
    assert abs(values[0].std() - 0.3) < 4.0 * 0.3 / np.sqrt(2.0 * DRAWN)


def test_a_bias_walks_as_the_square_root_of_time():
    numbers = tuple(range(1, 2001))
    values = measured(Noise(bias_walk=0.4), samples=31, numbers=numbers)[:, :, 0] - 5.0
    for sample in (1, 10, 30):
        wanted = 0.4 * np.sqrt(sample * PERIOD)
        assert abs(values[sample].std() - wanted) < 4.0 * wanted / np.sqrt(2.0 * len(numbers))
    assert np.all(values[0] == 0.0)


def test_whoever_subscribes_late_receives_the_same_walk():
    noise, late = Noise(stddev=0.1, bias_walk=0.4), draws(Noise(stddev=0.1, bias_walk=0.4))
    values = measured(noise, samples=2500)
    assert np.array_equal(late.at(2499).noisy(np.full((2, 1), 5.0)), values[2499])
    assert np.array_equal(late.at(7).noisy(np.full((2, 1), 5.0)), values[7])  # the clock of a reset


def test_values_are_whole_quanta_and_lost_ones_are_nan():
    values = measured(Noise(stddev=0.2, quantum=0.05, dropout=0.1))
    lost = np.isnan(values)
    assert abs(lost.mean() - 0.1) < 4.0 * np.sqrt(0.1 * 0.9 / lost.size)
    steps = values[~lost] / 0.05
    assert np.abs(steps - np.round(steps)).max() < 1e-9
    # What is rounded has the variance of the noise and of the rounding, q^2/12.
    wanted = np.sqrt(0.2**2 + 0.05**2 / 12.0)
    assert abs(np.nanstd(values) - wanted) < 4.0 * wanted / np.sqrt(2.0 * (~lost).sum())


def test_values_of_a_robot_depend_on_no_other_robot_sensor_or_quantity():
    alone = measured(Noise(stddev=0.2), samples=200, numbers=(2,), width=16)
    beside = measured(Noise(stddev=0.2), samples=200, numbers=(1, 2, 9), width=16)
    assert np.array_equal(alone[:, 0], beside[:, 1])
    more = measured(Noise(stddev=0.2, bias=1.0, dropout=0.5), samples=200, numbers=(2,), width=16)
    heard = ~np.isnan(more)
    assert np.allclose(more[heard], alone[heard] + 1.0)
    for other in ({"sensor": "laser"}, {"seed": 1}, {"numbers": (3,)}):
        options = dict({"numbers": (2,), "width": 16}, **other)
        assert not np.array_equal(measured(Noise(stddev=0.2), samples=1, **options), alone[:1])


@pytest.mark.parametrize("grows", [False, True])
@pytest.mark.parametrize("seed, robots", [(0, 1), (2**32 - 1, 11), (2**80 + 3, 11)])
def test_draws_are_those_of_one_generator_for_each_seed_robot_purpose_and_block(
    seed, robots, grows
):
    """To the bit, in any order of samples: a run of before has the same readings."""
    width, numbers = 300, tuple(range(1, 2 * robots, 2))
    length = SAMPLES if grows else BLOCK // width
    streams = Streams(seed, numbers, "laser", grows)
    for sample in (0, 1, 2, 3, length, 5 * length, 9 * length + 1, 4, 10**6):
        block, within = divmod(sample, length)
        for method, ask in (("standard_normal", streams.normal), ("random", streams.uniform)):
            drawn = ask(method, width, sample)
            key = zlib.crc32("laser/{}".format(method).encode())
            for number, own in zip(numbers, drawn):
                one = getattr(np.random.default_rng((seed, number, key, block)), method)
                wanted = one((width, length)).T if grows else one((length, width))
                np.testing.assert_array_equal(own, wanted[within])


def test_states_found_together_are_those_that_numpy_finds_one_by_one():
    words = np.random.default_rng(0).integers(0, 2**32, (40, 6), dtype=np.uint32)
    words[0], words[1] = 0, 2**32 - 1
    for length in (1, 3, 4, 6):
        one_by_one = [np.random.PCG64(np.random.SeedSequence(w[:length])).state for w in words]
        assert seeds.states(words[:, :length]) == one_by_one


def test_values_of_those_that_are_seen_depend_on_no_larger_team():
    noise = {"": Noise(stddev=0.2, bias_stddev=0.1, bias_walk=0.3, dropout=0.2)}

    def seen(n):
        drawn = Draws(noise, Streams(0, (1, 2), "others", grows=True), PERIOD)
        return np.array([drawn.at(k).noisy(np.full((2, n), 5.0)) for k in range(50)])

    np.testing.assert_array_equal(seen(3), seen(7)[:, :, :3])
    assert abs(np.nanmean(seen(3)[:, 0] - seen(3)[:, 1])) > 1e-3


def test_without_noise_values_are_those_that_came():
    values = np.array([[1.0, np.inf]])
    assert draws(Noise(latency=0.2), numbers=(1,)).noisy(values) is values
    far = draws(Noise(stddev=0.1, quantum=0.01), numbers=(1,)).noisy(values)
    assert far[0, 1] == np.inf


def read(content):
    return read_noise(QuantitySection(content, "sensors: noise"), "m", Noise(stddev=0.5))


def test_noise_is_read_with_units_over_a_default():
    given = {"bias": "2 mm", "bias_walk": "1 mm/sqrt(s)", "quantum": "1 cm", "latency": "50 ms"}
    assert read(given) == Noise(0.5, 0.002, 0.0, 0.001, 0.01, 0.0, 0.05)
    assert read({"bias": {"stddev": 0.1}}) == Noise(stddev=0.5, bias_stddev=0.1)


@pytest.mark.parametrize(
    "content, wanted",
    [
        ({"stdev": 1.0}, "noise.*stdev.*stddev"),
        ({"stddev": -1.0}, "noise.stddev: -1.0, wanted a number of at least 0"),
        ({"dropout": 1.5}, "noise.dropout: 1.5, wanted a number from 0 to 1"),
        ({"latency": "2 m"}, "noise.latency: '2 m', wanted .* s, ms"),
        ({"bias": {"mean": 1.0}}, "noise.bias.stddev"),
        ({"stddev": 1e200}, r"noise.stddev: 1e\+200, wanted at most 1e\+09"),
        ({"bias": {"stddev": 1e200}}, r"noise.bias: 1e\+200, wanted at most 1e\+09"),
        ({"bias": -1e200}, r"noise.bias: 1e\+200, wanted at most 1e\+09"),
        ({"latency": 1e300}, r"noise.latency: 1e\+300, wanted at most 1e\+09"),
        ({"quantum": 1e-320}, r"noise.quantum: .*, wanted 0 or at least 1e-12"),
    ],
)
def test_impossible_noise_is_refused_by_name(content, wanted):
    with pytest.raises(ScenarioError, match=wanted):
        read(content)
