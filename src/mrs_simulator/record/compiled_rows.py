"""Lines of numbers as text by loops that numba compiles: the bytes of ``number_rows``.

Shortest digits are found as R. Giulietti does ("The Schubfach way to render doubles", 2020): of the
decimals with one digit less, and then of those with so many, the nearest that rounds to the number.  Where
one product decides which, it does, by a margin that is wider than what rounding takes.
"""

import functools
import itertools

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit

U = np.uint64
LONGEST = 25  # [bytes] of a number and the comma after it
SLACK = 32  # [bytes] that are written beyond the end of what is
LARGE = U(np.float64(1e16).view(np.int64))  # bits from which on numbers are not written here
SIGN, FRACTION, HIDDEN = U(1 << 63), U((1 << 52) - 1), U(1 << 52)
ONE, TWO, FOUR, TEN, FORTY = U(1), U(2), U(4), U(10), U(40)
SIXTEEN_DIGITS, EIGHT_DIGITS, FOUR_DIGITS = U(10**16), U(10**8), U(10**4)
TENTH = U(10 << 60)  # ten, in units of 2^-60
MINUS, POINT, ZERO, COMMA, EXPONENT = np.frombuffer(b"-.0,e", np.uint8)
LEAST, GREATEST = -292, 324  # exponents of ten

high = None  # numba's function of the upper half of a product of two numbers of 64 bits


def _powers():
    """Return the first 128 bits of ``10^LEAST`` to ``10^GREATEST``, rounded up, (m, 2) of 64 each."""
    rows = []
    for exponent in range(LEAST, GREATEST + 1):
        shift = 127 - (exponent * 1741647 >> 19)
        over, under = 10 ** max(exponent, 0) << max(shift, 0), 10 ** max(-exponent, 0)
        power = -(-over // (under << max(-shift, 0)))
        rows.append((power >> 64, power & (1 << 64) - 1))
    return np.array(rows, dtype=np.uint64)


POWERS = _powers()


class Filler:
    """Writes lines as ``number_rows.Lines`` does, into memory of its own that is used again."""

    def __init__(self, robots, ends):
        """``robots``: their numbers; ``ends``: what ends the lines of each, such as ``,kind``."""
        heads, tails = map(",{},".format, robots), map("{}\n".format, ends)
        self._texts = _in_a_row(heads) + _in_a_row(tails)
        self._longest = _longest(self._texts[1]) + _longest(self._texts[3])  # [bytes]
        self._memory = np.empty(0, np.uint8)

    def filled(self, stamps, tables, points=None):
        """Return the lines, bytes, and where in them each sample ends, (k,); None for numbers from 1e16 on.

        ``stamps`` (k,) [s], ``tables`` (k, n, c), contiguous; ``points`` as :func:`place_points` has it,
        None for none.
        """
        samples, n, columns = tables.shape
        texts, ends = _in_a_row(map(repr, stamps)) + self._texts, np.empty(samples, np.int64)
        size = samples * n * (self._longest + (1 + columns) * LONGEST) + SLACK
        if len(self._memory) < size:
            self._memory = np.empty(size, np.uint8)
        if points is None:
            points = np.zeros(samples, bool), np.empty(0), 0, 0
        if not compiled_lines()(*texts, tables, points, self._memory, ends):
            return None
        return memoryview(self._memory)[: ends[-1]], ends


def _longest(ends):
    return int(np.diff(ends, prepend=0).max(initial=0))


def _in_a_row(texts):
    """Return ``texts`` as bytes one after the other, and the ends of each."""
    texts = [text.encode("utf-8") for text in texts]
    ends = np.fromiter(itertools.accumulate(map(len, texts)), np.int64, len(texts))
    return np.frombuffer(b"".join(texts), np.uint8), ends


def lines(stamps, stamp_ends, heads, head_ends, tails, tail_ends, numbers, points, out, ends):
    """Fill ``out`` with the lines of samples and ``ends`` (k,) with where those of each end.

    A line is a stamp of the sample, a head of the robot, numbers, and its tail; texts are bytes one after
    the other, with the ends of each.  ``numbers`` (k, n, c), into which ``points`` are put before.  Return
    False, with nothing of use in ``out``, where one of them is not below 1e16.
    """
    place_points(numbers, points)
    table = numbers.view(np.uint64)
    samples, n, columns = table.shape
    at, stamp = U(0), U(0)
    for sample in range(samples):
        head, tail = U(0), U(0)
        for row in range(n):
            at = copied(stamps, stamp, U(stamp_ends[sample]), out, at)
            at = copied(heads, head, U(head_ends[row]), out, at)
            for column in range(columns):
                bits = table[sample, row, column]
                if bits & ~SIGN >= LARGE:
                    return False
                at = written(bits, out, at)
                out[at] = COMMA
                at += ONE
            at = copied(tails, tail, U(tail_ends[row]), out, at - ONE)
            head, tail = U(head_ends[row]), U(tail_ends[row])
        ends[sample], stamp = at, U(stamp_ends[sample])
    return True


def place_points(numbers, points):
    """Put hand points into ``numbers`` (k, n, c), to the bit those of ``kinematics.hand_points``.

    ``points``: into which samples, (k,) bool, the hand lengths (n,) [m], and the first columns of poses and
    of points.  Here no lock of Python's is needed, for which a law would have to be interrupted.
    """
    wanted, arms, pose, hand = points
    n = numbers.shape[1]
    theta, cos, sin = np.empty(n), np.empty(n), np.empty(n)
    for sample in range(len(wanted)):
        if wanted[sample]:
            rows = numbers[sample]
            for row in range(n):
                theta[row] = rows[row, pose + 2]
            cosines(theta, cos)
            sines(theta, sin)
            for row in range(n):
                rows[row, hand] = rows[row, pose] + arms[row] * cos[row]
                rows[row, hand + 1] = rows[row, pose + 1] + arms[row] * sin[row]


def copied(text, begin, end, out, at):
    """Put ``text`` from ``begin`` to ``end`` into ``out``; return where it ends there."""
    for place in range(end - begin):
        out[at + place] = text[begin + place]
    return at + (end - begin)


def written(bits, out, at):
    """Put the number with these ``bits`` into ``out`` from ``at`` on; return where it ends."""
    if bits & SIGN:
        out[at] = MINUS
        at, bits = at + ONE, bits & ~SIGN
    if not bits:
        out[at], out[at + ONE], out[at + TWO] = ZERO, POINT, ZERO
        return at + U(3)
    digits, exponent = shortest(bits)
    point = exponent + 17  # digits before it
    while digits < SIXTEEN_DIGITS:
        digits, point = digits * TEN, point - 1
    if point > 0:
        spread(digits, out, at + ONE)
        for place in range(U(point)):
            out[at + place] = out[at + place + ONE]
        out[at + U(point)] = POINT
        return without_zeros(out, at + U(point) + TWO, at + U(18))
    if point > -5:
        for place in range(U(2 - point)):
            out[at + place] = ZERO
        out[at + ONE] = POINT
        at += U(2 - point)
        spread(digits, out, at)
        return without_zeros(out, at, at + U(17))
    spread(digits, out, at + ONE)
    out[at], out[at + ONE] = out[at + ONE], POINT
    end = without_zeros(out, at + TWO, at + U(18))
    return with_exponent(U(1 - point), out, end if end > at + TWO else at + ONE)


def without_zeros(out, least, end):
    """Return where what ends at ``end`` does without the zeros at its end, at ``least`` or after it."""
    while end > least and out[end - ONE] == ZERO:
        end -= ONE
    return end


def with_exponent(size, out, at):
    """Put an exponent of minus ``size`` into ``out``; return where it ends."""
    out[at], out[at + ONE] = EXPONENT, MINUS
    at += TWO
    if size >= U(100):
        out[at] = ZERO + size // U(100)
        at += ONE
    if size >= TEN:
        out[at] = ZERO + size // TEN % TEN
        at += ONE
    out[at] = ZERO + size % TEN
    return at + ONE


def spread(digits, out, at):
    """Put 17 ``digits`` into ``out``."""
    upper = digits // EIGHT_DIGITS
    first = upper // EIGHT_DIGITS
    out[at] = ZERO + first
    spread_eight(upper - first * EIGHT_DIGITS, out, at + ONE)
    spread_eight(digits - upper * EIGHT_DIGITS, out, at + U(9))


def spread_eight(digits, out, at):
    """Put eight ``digits`` into ``out``: split in halves three times, all parts at once."""
    upper = digits // FOUR_DIGITS
    parts = upper | (digits - upper * FOUR_DIGITS) << U(32)
    upper = parts * U(10486) >> U(20) & U(0x0000007F0000007F)
    parts = upper | (parts - upper * U(100)) << U(16)
    upper = parts * U(103) >> U(10) & U(0x000F000F000F000F)
    parts = (upper | (parts - upper * TEN) << U(8)) + U(0x3030303030303030)
    for byte in range(U(8)):
        out[at + byte] = parts >> U(8) * byte


def shortest(bits):
    """Return the shortest decimal ``digits * 10^exponent`` of a positive number, the nearest of those."""
    fraction, biased = bits & FRACTION, np.int64(bits >> U(52))
    binary = biased - 1075
    exponent = binary * 1262611 >> 22  # of ten, at most the spacing of numbers
    shift = U(binary + (-exponent * 1741647 >> 19) + 1)
    upper, lower = POWERS[U(-exponent - LEAST), U(0)], POWERS[U(-exponent - LEAST), ONE]
    # The number in units of that power of ten: whole and parts of 2^-64.
    scaled = (fraction | HIDDEN) << shift
    more = high(lower, scaled)
    parts = upper * scaled + more
    whole = high(upper, scaled) + U(parts < more)
    tens = whole // TEN * TEN
    # In units of 2^-60: how far it is above tens and below the next, and half of the spacing.
    above = whole - tens << U(60) | parts >> FOUR
    below, half = TENTH - above, upper >> U(5) - shift
    is_close = is_small(above - half) | is_small(below - half) | is_small(parts - SIGN)
    if biased == 0 or fraction == 0 or is_close:
        return shortest_of_all(bits)
    if above < half:
        return tens, exponent
    if below < half:
        return tens + TEN, exponent
    return whole + (parts >> U(63)), exponent


def is_small(difference):
    """Return whether a ``difference`` modulo 2^64 is what rounding may take."""
    return difference + U(16) < U(32)


def shortest_of_all(bits):
    """Return what :func:`shortest` does, of any positive number."""
    fraction, biased = bits & FRACTION, np.int64(bits >> U(52))
    number, binary = (fraction | HIDDEN, biased - 1075) if biased else (fraction, -1074)
    nearer = fraction == 0 and biased > 1  # the next number below
    exponent = binary * 1262611 - (524031 if nearer else 0) >> 22
    shift = U(binary + (-exponent * 1741647 >> 19) + 1)
    odd, number = number & ONE, number * FOUR
    # Quarters of units of the power of ten: the number, and what rounds to it.
    least = scaled_to_odd(number - TWO + U(nearer) << shift, exponent) + odd
    middle = scaled_to_odd(number << shift, exponent)
    most = scaled_to_odd(number + TWO << shift, exponent) - odd
    whole = middle // FOUR
    if whole >= TEN:
        tens = whole // TEN
        low, up = least <= FORTY * tens, FORTY * tens + FORTY <= most
        if low != up:
            return tens + U(up), exponent + 1
    low, up = least <= FOUR * whole, FOUR * whole + FOUR <= most
    if low != up:
        return whole + U(up), exponent
    half = FOUR * whole + TWO
    return whole + U(middle > half or middle == half and whole & ONE == ONE), exponent


def scaled_to_odd(number, exponent):
    """Return ``number`` over ``10^exponent``, its last bit 1 where it is not whole."""
    upper, lower = POWERS[U(-exponent - LEAST), U(0)], POWERS[U(-exponent - LEAST), ONE]
    more = high(lower, number)
    parts = upper * number + more
    return high(upper, number) + U(parts < more) | U(parts > ONE)


def _upper_half():
    """Return numba's function :func:`high`."""
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def upper_half(context, first, second):
        def generated(context, builder, signature, factors):
            wide = ir.IntType(128)
            first, second = (builder.zext(each, wide) for each in factors)
            upper = builder.lshr(builder.mul(first, second), ir.Constant(wide, 64))
            return builder.trunc(upper, ir.IntType(64))

        return types.uint64(types.uint64, types.uint64), generated

    return upper_half


@functools.lru_cache(maxsize=None)
def compiled_lines():
    """Return the compiled :func:`lines`; ``ValueError`` without numba."""
    global high
    compile_ = jit(cache=True, nogil=True)
    high = _upper_half()
    return linked(lines, compile_)
