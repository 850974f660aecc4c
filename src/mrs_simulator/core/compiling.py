"""Compilation by numba, an optional package, where ``MRS_SIMULATOR_COMPILED=1`` asks for it."""

import os

VARIABLE = "MRS_SIMULATOR_COMPILED"


def is_wanted():
    """Return whether the environment asks for compiled functions; ``ValueError`` unless 0 or 1."""
    wanted = os.environ.get(VARIABLE, "0")
    if wanted not in ("0", "1"):
        raise ValueError("{}={}: wanted 0 or 1".format(VARIABLE, wanted))
    return wanted == "1"


def jit(**options):
    """Return numba's compiler: numpy's operations in numpy's order, none fused or reordered.

    Raises ``ValueError`` where numba is not installed.
    """
    try:
        import numba  # optional
    except ImportError:
        text = "{}=1: numba is not installed, wanted `pip install numba`"
        raise ValueError(text.format(VARIABLE)) from None
    return numba.njit(fastmath=False, error_model="numpy", **options)
