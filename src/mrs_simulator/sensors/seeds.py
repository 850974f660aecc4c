"""The generators of many seeds at once: ``default_rng(seed)`` takes 25 us, nearly all of it Python's.

``SeedSequence`` and ``PCG64``, of which it is made, are the same in all versions of numpy.
"""

import threading

import numpy as np

FEW = 8  # [-] seeds of which numpy's own way takes less
# Of SeedSequence, 32 bits each.
FIRST_MIXED, FACTOR_MIXED = 0x43B0D7E5, 0x931E8875
FIRST_OUT, FACTOR_OUT = 0x8B51F9DD, 0x58F38DED
LEFT, RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
HALF = np.uint32(16)  # [bit]
POOL = 4  # [words] of SeedSequence
WORDS = 8  # [words] of the seed of a PCG64
FACTOR = 0x2360ED051FC65DA44385DF649FCCF645  # of PCG64
BITS_32, BITS_128 = (1 << 32) - 1, (1 << 128) - 1


def words_of(number):
    """Return the 32-bit words of a whole ``number`` >= 0, the lowest first, as SeedSequence takes it."""
    words = [number & BITS_32]
    while number > BITS_32:
        number >>= 32
        words.append(number & BITS_32)
    return words


def states(entropy):
    """Return the states of ``PCG64(SeedSequence(words))`` of each row of ``entropy`` (m, words), uint32.

    A list of what the ``state`` of a ``PCG64`` can be set to.
    """
    if len(entropy) < FEW:
        return [np.random.PCG64(np.random.SeedSequence(words)).state for words in entropy]
    seeds = _seeds(entropy.T)
    seeds = (seeds[::2].astype(np.uint64) | seeds[1::2].astype(np.uint64) << np.uint64(32)).T
    return [_state(*row) for row in seeds.tolist()]


def draw(states, method, drawn):
    """Fill the rows of ``drawn`` by the ``method`` of a generator that begins in each of the ``states``."""
    if not hasattr(_of_thread, "generator"):
        _of_thread.generator = np.random.Generator(np.random.PCG64(0))
    generator = _of_thread.generator
    bits, fill = generator.bit_generator, getattr(generator, method)
    for state, row in zip(states, drawn):
        bits.state = state
        fill(out=row)


_of_thread = threading.local()


def _state(high, low, high_step, low_step):
    step = ((high_step << 64 | low_step) << 1 | 1) & BITS_128
    state = ((step + (high << 64 | low)) * FACTOR + step) & BITS_128
    inner = {"state": state, "inc": step}
    return {"bit_generator": "PCG64", "state": inner, "has_uint32": 0, "uinteger": 0}


def _seeds(words):
    """Return what SeedSequence generates, (WORDS, m), of ``words`` (w, m), uint32."""
    constants = _constants(FIRST_MIXED, FACTOR_MIXED)
    none = np.zeros(words.shape[1], dtype=np.uint32)
    pool = [_hashed(words[k] if k < len(words) else none, constants) for k in range(POOL)]
    for source in range(POOL):
        for k in range(POOL):
            if k != source:
                pool[k] = _mixed(pool[k], _hashed(pool[source], constants))
    for word in words[POOL:]:
        for k in range(POOL):
            pool[k] = _mixed(pool[k], _hashed(word, constants))
    constants = _constants(FIRST_OUT, FACTOR_OUT)
    return np.array([_hashed(pool[k % POOL], constants) for k in range(WORDS)])


def _constants(first, factor):
    """Yield pairs of successive numbers from ``first`` on, each the last times ``factor`` in 32 bits."""
    while True:
        second = first * factor & BITS_32
        yield np.uint32(first), np.uint32(second)
        first = second


def _hashed(value, constants):
    """Return ``value`` (m,) hashed by the next pair of ``constants``."""
    first, second = next(constants)
    value = (value ^ first) * second
    return value ^ (value >> HALF)


def _mixed(left, right):
    result = LEFT * left - RIGHT * right
    return result ^ (result >> HALF)
