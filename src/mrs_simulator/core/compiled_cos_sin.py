"""Cosines and sines with numpy's last bits, in what numba compiles: by the loops that numpy itself calls.

Those of the C library, which numba's ``math.cos`` calls, differ from them in the last bit, and take ten
times as long one by one.
"""

import ctypes
import functools

import numpy as np

from mrs_simulator.core.compiling import NotInstalled, jit

DOUBLES = "d->d"  # the loop for doubles, as numpy names it
SIZE = np.dtype(float).itemsize  # [bytes]


def cosines(angles, filled):
    """Fill ``filled`` (n,) with the cosines of ``angles`` (n,) [rad], both contiguous."""
    np.cos(angles, filled)


def sines(angles, filled):
    """Fill ``filled`` (n,) with the sines of ``angles`` (n,) [rad], both contiguous."""
    np.sin(angles, filled)


class Ufunc(ctypes.Structure):
    """The first fields of numpy's ``PyUFuncObject``, after what each Python object begins with."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("nin", "nout", "nargs", "identity")),
        ("functions", ctypes.POINTER(ctypes.c_void_p)),
        ("data", ctypes.POINTER(ctypes.c_void_p)),
        ("ntypes", ctypes.c_int),
    )


def loop_of(ufunc):
    """Return the address of numpy's loop of a ``ufunc`` of doubles, ``void(char **args, npy_intp *n,
    npy_intp *strides, void *data)``, which needs no ``data``; ``NotInstalled`` where it is not found."""
    known = Ufunc.from_address(id(ufunc) + object.__basicsize__)
    counts = known.nin, known.nout, known.nargs, known.ntypes
    if counts == (ufunc.nin, ufunc.nout, ufunc.nargs, ufunc.ntypes) and DOUBLES in ufunc.types:
        row = ufunc.types.index(DOUBLES)
        if known.functions[row] and not known.data[row]:
            return known.functions[row]
    raise NotInstalled("numba: the loops of numpy {} are not known".format(np.__version__))


def _compiled(ufunc):
    """Return the compiled twin of one of the functions above, by the loop of ``ufunc``."""
    compile_ = jit()
    import llvmlite.binding
    from numba import types

    # Machine code that is kept finds it by name.
    symbol = "mrs_simulator_loop_of_" + ufunc.__name__
    llvmlite.binding.add_symbol(symbol, loop_of(ufunc))
    loop = types.ExternalFunction(symbol, types.void(*4 * [types.voidptr]))

    def fill(angles, filled):
        given = np.empty(5, dtype=np.int64)
        given[0], given[1], given[2] = angles.ctypes.data, filled.ctypes.data, len(angles)
        given[3] = given[4] = SIZE
        loop(given.ctypes, given[2:].ctypes, given[3:].ctypes, given.ctypes)  # no data

    return compile_(fill)


cosines.compiled = functools.lru_cache(maxsize=None)(functools.partial(_compiled, np.cos))
sines.compiled = functools.lru_cache(maxsize=None)(functools.partial(_compiled, np.sin))
