"""Compilation by numba, an optional package, where ``MRS_SIMULATOR_COMPILED=1`` asks for it."""

import os

VARIABLE = "MRS_SIMULATOR_COMPILED"
PREAMBLE = ("Failed in nopython mode", "Resolution failure")  # before numba comes to the point


def is_wanted():
    """Return whether the environment asks for compiled functions; ``ValueError`` unless 0 or 1."""
    wanted = os.environ.get(VARIABLE, "0")
    if wanted not in ("0", "1"):
        raise ValueError("{}={}: wanted 0 or 1".format(VARIABLE, wanted))
    return wanted == "1"


def compile_failure(error):
    """Return in a line why numba cannot compile something, as its ``error`` says; "" for other errors."""
    if not type(error).__module__.startswith("numba."):
        return "a function calls itself" if isinstance(error, RecursionError) else ""
    lines = (line.strip(" -\t") for line in str(error).splitlines())
    told = (line for line in lines if line and not line.startswith(PREAMBLE))
    return next(told, type(error).__name__)


def jit(cache=False, **options):
    """Return numba's compiler: numpy's operations in numpy's order, none fused or reordered.

    ``cache``: keep the machine code for other processes, beside the source or, where that may not be
    written, in the user's cache directory (``NUMBA_CACHE_DIR`` names another); nowhere if neither can be.
    Raises ``ValueError`` where numba is not installed.
    """
    try:
        import numba  # optional
    except ImportError:
        text = "{}=1: numba is not installed, wanted `pip install numba`"
        raise ValueError(text.format(VARIABLE)) from None
    compile_ = numba.njit(fastmath=False, error_model="numpy", **options)
    if not cache:
        return compile_
    keep = numba.njit(fastmath=False, error_model="numpy", cache=True, **options)

    def kept(function):
        try:
            return keep(function)
        except RuntimeError:  # there is nowhere to keep it
            return compile_(function)

    return kept
