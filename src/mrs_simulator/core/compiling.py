"""Compilation by numba, an optional package: of long runs, or as ``MRS_SIMULATOR_COMPILED`` says."""

import contextlib
import functools
import os
import re
import sys
import threading
from importlib.util import find_spec

from mrs_simulator.core.garbage import loading_more

VARIABLE = "MRS_SIMULATOR_COMPILED"
PREAMBLE = (
    "Failed in nopython mode",
    "Resolution failure",
    "AssertionError()",  # of old versions, which name the function in the next line
)  # lines of numba's messages before the cause

LOADING = 0.6  # [s] that numba and a kept kernel take to load, about
# [s] that a step takes less when it is compiled: of each step, of each of its robots
SAVED = (30e-6, 20e-9)
WORTH = 5000  # [-] calls of 0.1 ms that take as long as loading
LOADED = 10  # [-] times as long as a kept kernel alone
HINT = "numba is not installed: {} some {:.0f} s longer, wanted `pip install numba`"
MANY = "many"  # how runs are made of which so many are alike that they pay for compilation together

# Files of what is kept under a name that ends with a digest: an index, and machine code by its count.
KEPT_FILE = re.compile(r"(.+_[0-9a-f]{12}-\w+\.py\w+?)(?:\.\d+)?\.nb[ic]$")
MOST_KEPT = 256  # [-] kernels that a directory keeps


def is_wanted():
    """Return whether the environment enables compiled functions; ``ValueError`` unless 0 or 1."""
    return _chosen() == "1"


def is_chosen():
    """Return whether the environment says anything of compiled functions."""
    return _chosen() is not None


def _chosen():
    wanted = os.environ.get(VARIABLE)
    if wanted not in (None, "0", "1"):
        raise ValueError("{}={}: wanted 0 or 1".format(VARIABLE, wanted))
    return wanted


@contextlib.contextmanager
def chosen(wanted):
    """Let ``VARIABLE`` be ``wanted`` in the environment, None unset, while the context lasts."""
    before = os.environ.pop(VARIABLE, None)
    try:
        if wanted is not None:
            os.environ[VARIABLE] = wanted
        yield
    finally:
        os.environ.pop(VARIABLE, None)
        if before is not None:
            os.environ[VARIABLE] = before


_many = False


@contextlib.contextmanager
def of_many(wanted):
    """Let runs be compiled where they can be, if ``wanted``, since they pay together.

    Unless the environment says anything.  A law that numba cannot compile goes step by step.
    """
    global _many
    before, _many = _many, wanted
    try:
        yield
    finally:
        _many = before


def mode():
    """Return what decides whether a run is compiled: ``VARIABLE``'s value, ``MANY``, or None."""
    return _chosen() or (MANY if _many else None)


@contextlib.contextmanager
def as_made(wanted):
    """Let runs be compiled as when :func:`mode` returned ``wanted``."""
    with chosen(None if wanted == MANY else wanted), of_many(wanted == MANY):
        yield


def seconds_saved(steps, robots, saved=SAVED):
    """Return how much sooner [s] ``steps`` of ``robots`` end when they are compiled, loading included.

    ``saved`` as ``SAVED``, that of wheels without forces.
    """
    by_step, by_robot = saved
    return steps * (by_step + robots * by_robot) - LOADING


def pays(steps, robots, saved=SAVED):
    """Return whether a run is to be compiled, and a text for users where it would be if numba were here.

    As the environment says, else where :func:`seconds_saved`, by ``saved``, is positive: it depends on the
    run alone, so that each repetition gives the same bits.
    """
    if is_chosen():
        return is_wanted(), ""
    if _many:
        return find_spec("numba") is not None, ""
    return _pays(seconds_saved(steps, robots, saved), "this run takes")


def pays_together(runs):
    """Return as :func:`pays` does of ``runs``, pairs of steps and robots, made one after the other.

    False where the environment says anything: it holds for each of them.
    """
    if is_chosen():
        return False, ""
    saved = sum(LOADING + seconds_saved(*run) for run in runs) - LOADING
    return _pays(saved, "these runs take")


def _pays(saved, what):
    if saved <= 0.0:
        return False, ""
    if find_spec("numba") is None:
        return False, HINT.format(what, saved)
    return True, ""


_asked = {}  # by function: how often this process could have used what it returns


_thread = threading.local()


@contextlib.contextmanager
def in_time(wanted=True):
    """Let :func:`same_bits` compile and load nothing in this thread, if ``wanted``: robots wait for its
    results, or people do."""
    before = _is_in_time()
    _thread.in_time = wanted or before
    try:
        yield
    finally:
        _thread.in_time = before


def _is_in_time():
    return getattr(_thread, "in_time", False)


def same_bits(compiled, worth=WORTH, size=1, loading=True):
    """Return ``compiled()``, whose results are numpy's to the bit, where it pays, else None.

    As the environment says, else after calls in this process whose sizes add up to ``worth``, when numpy
    has taken about as long as numba takes to load: a tenth of that where it has been loaded.  None
    :func:`in_time`, and where numba would have to be loaded unless ``loading``.
    """
    if _is_in_time():
        return None
    wanted = _chosen()
    if wanted is not None:
        return compiled() if wanted == "1" else None
    if not (loading or _is_loaded()):
        return None
    asked = _asked[compiled] = _asked.get(compiled, 0) + size
    return _available(compiled) if asked > (worth // LOADED if _is_loaded() else worth) else None


def _is_loaded():
    return "numba" in sys.modules


@functools.lru_cache(maxsize=None)
def _available(compiled):
    try:
        return compiled()
    except NotInstalled:
        return None


class NotInstalled(ValueError):
    """numba is not installed, or does not go with the numpy that is."""


def compile_failure(error):
    """Return in a line why numba cannot compile something, as its ``error`` says; "" for other errors."""
    if isinstance(error, NotInstalled):
        return str(error)
    if not type(error).__module__.startswith("numba."):
        return "a function calls itself" if isinstance(error, RecursionError) else ""
    lines = (line.strip(" -\t") for line in str(error).splitlines())
    causes = (line for line in lines if line and not line.startswith(PREAMBLE))
    return next(causes, type(error).__name__)


def jit(cache=False, **options):
    """Return numba's compiler: numpy's operations in numpy's order, none fused or reordered.

    ``cache``: keep the machine code for other processes, beside the source or, where that may not be
    written, in the user's cache directory (``NUMBA_CACHE_DIR`` names another); nowhere if neither can be.
    Raises ``NotInstalled`` where numba cannot be imported.
    """
    try:
        with loading_more() if "numba" not in sys.modules else contextlib.nullcontext():
            import numba  # optional
    except ImportError as error:
        text = "{}=1: numba is not installed, wanted `pip install numba`".format(VARIABLE)
        if find_spec("numba") is not None:
            text = "numba cannot be imported: {}".format(error)
        raise NotInstalled(text) from None

    def compile_(function):
        inline = "always" if hasattr(function, "inlined") else "never"
        given = dict(fastmath=False, error_model="numpy", inline=inline, **options)
        return numba.njit(**given)(function)

    if not cache:
        return compile_
    keep = numba.njit(fastmath=False, error_model="numpy", cache=True, **options)

    def kept(function):
        try:
            return keep(function)
        except RuntimeError:  # there is nowhere to keep it
            return compile_(function)

    return kept


def inlined(function):
    """Mark a ``function`` to become part of those that call it, where numba compiles these.

    A call takes some 5 ns of each array, which counts where it is made for each robot or pair.
    """
    function.inlined = True
    return function


def entry_of(compiled, arguments):
    """Return what ``compiled`` calls for ``arguments`` of these types, to be called with such alone.

    It does not find their types out, which takes ``compiled`` 35 ns of each array at each call.
    """
    if not hasattr(compiled, "overloads"):
        return compiled  # numba compiles nothing, as NUMBA_DISABLE_JIT says
    import numba

    types = tuple(map(numba.typeof, arguments))
    compiled.compile(types)  # unless it is
    return compiled.overloads[types].entry_point


def is_kept(compiled):
    """Return whether machine code of ``compiled`` as it is now is kept, so that none need be compiled.

    By numba's own index, which knows of its version and of the source's last change.
    """
    index = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    return bool(getattr(index, "_load_index", dict)())


def bound_kept(compiled, most=MOST_KEPT):
    """Keep at most ``most`` kernels in the directory of ``compiled``, which is in use; remove the oldest.

    Another process that reads one of them meanwhile compiles it again.
    """
    directory = getattr(getattr(compiled, "stats", None), "cache_path", None)
    if directory is None or not os.path.isdir(directory):
        return
    files, used = {}, {}
    own = ".{}-".format(compiled.__name__)
    for entry in os.scandir(directory):
        found = KEPT_FILE.match(entry.name)
        if found:
            with contextlib.suppress(OSError):
                if own in entry.name:
                    os.utime(entry.path)
                last = entry.stat().st_mtime if own not in entry.name else float("inf")
                files.setdefault(found.group(1), []).append(entry.path)
                used[found.group(1)] = max(last, used.get(found.group(1), 0.0))
    for kernel in sorted(used, key=used.get)[: max(0, len(used) - most)]:
        for path in files[kernel]:
            with contextlib.suppress(OSError):
                os.remove(path)
