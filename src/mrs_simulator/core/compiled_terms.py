"""Sums over edges by loops that numba compiles, of the same terms that numpy evaluates.

Results are those of ``edge_terms`` to the bit, but for two things: cosines, exponentials and powers are
the C library's, whose last bits differ from numpy's, and a linear term is summed as differences, edge by
edge.  Either is within 1e-12 of the largest value.  Kernels are cached on disk under a name with a digest
of the term; the least recently used is removed when there are too many.
"""

import functools
import hashlib
import itertools
import types

import numpy as np

from mrs_simulator.core.compiling import bound_kept, jit


def edge_sum(term, arcs, values, *given):
    """Return what ``edge_terms.edge_sum`` does."""
    return _kernel(term, of_edges)(*_contiguous(values, arcs), *given)


def pair_sum(term, pairs, values, *given):
    """Return what ``edge_terms.pair_sum`` does."""
    return _kernel(term, of_pairs)(*_contiguous(values, pairs), *given)


def weighted_differences(weight, points, values, *given):
    """Return what ``edge_terms.weighted_differences`` does."""
    arrays = np.ascontiguousarray(points), np.ascontiguousarray(values)
    return _kernel(weight, of_all)(*arrays, *given)


def _contiguous(values, arcs):
    """Return contiguous values and rows, so that kernels are compiled for one layout."""
    return tuple(np.ascontiguousarray(each) for each in (values, arcs[0], arcs[1]))


@functools.lru_cache(maxsize=None)
def _kernel(term, loops):
    return kernel(term, loops, jit(), jit(cache=True))


def kernel(term, loops, compile_, compile_kept, made=None):
    """Return ``loops``, one of the functions below, over the ``term``, compiled.

    ``compile_`` is what terms and their helpers go through, ``compile_kept`` what the loops do; ``made`` as
    :func:`linked` has it.
    """
    both = hashlib.sha256((digest(term) + digest(loops)).encode()).hexdigest()[:12]
    scope = _scope(loops, compile_, made)
    scope["term"] = linked(term, compile_)
    return _kept("{}_{}_{}".format(loops.__name__, term.__name__, both), loops, scope, compile_kept)


def kept(function, made=None):
    """Return ``function`` compiled, under a name with a digest of it and of what it calls; ``made`` as
    :func:`linked` has it.

    By the name machine code that was kept is found again.  numba itself knows the function's file alone:
    it would go on with what a helper or a constant of another file was.
    """
    name = "{}_{}".format(function.__name__, digest(function))
    return _kept(name, function, _scope(function, jit(), dict(made or {})), jit(cache=True))


def _kept(name, function, scope, compile_kept):
    named = types.FunctionType(function.__code__, scope, name)
    named.__qualname__ = name
    compiled = compile_kept(named)
    bound_kept(compiled)
    return compiled


def _scope(function, compile_, made=None):
    """Return the globals of ``function`` with the functions that it calls compiled."""
    found = _helpers(function)
    helpers = {name: linked(each, compile_, made) for name, each in found.items()}
    return dict(function.__globals__, **helpers)


@functools.lru_cache(maxsize=64)
def flow_law(term):
    """Return the law ``(points, places, gain, first, second, *given)`` of a ``Flow`` with that term."""
    scope = dict(globals(), term=term)
    return types.FunctionType(of_flow.__code__, scope, "{}_{}".format("flow", term.__name__))


def linked(function, compile_, made=None):
    """Return ``function`` compiled, with the functions of its module that it calls compiled as well.

    One that has a method ``compiled`` of its own returns itself so, such as ``compiled_cos_sin.cosines``.
    ``made``: what some functions have been compiled to, by them; those that it calls are added, so that
    each is compiled once, however many call it.
    """
    if hasattr(function, "compiled"):
        return function.compiled()
    made = {} if made is None else made
    if function in made:
        return made[function]
    scope, code = _scope(function, compile_, made), function.__code__
    same = types.FunctionType(
        code, scope, function.__name__, function.__defaults__, function.__closure__
    )
    same.__dict__.update(function.__dict__)
    made[function] = compile_(same)
    return made[function]


def digest(function):
    """Return a name for what ``function`` computes: of its code, its constants and its helpers'."""
    code, names = function.__code__, _names(function.__code__)
    found = {name: function.__globals__.get(name) for name in names}
    cells = zip(code.co_freevars, function.__closure__ or ())
    found.update((name, cell.cell_contents) for name, cell in cells)
    constants = [(name, _constant(value, names)) for name, value in sorted(found.items())]
    own = _code(code), _constant(function.__defaults__ or (), names)
    parts = [repr((*own, [each for each in constants if each[1]]))]
    parts += [digest(helper) for _, helper in sorted(_helpers(function).items())]
    return hashlib.sha256("".join(parts).encode()).hexdigest()[:12]


def _code(code):
    """Return bytecode, constants and names of ``code``, with its lambdas and comprehensions."""
    constants = [_code(c) if isinstance(c, types.CodeType) else _literal(c) for c in code.co_consts]
    return code.co_code, constants, code.co_names, code.co_varnames, code.co_freevars


def _literal(value):
    """Return a literal in a form that is the same in every process, also of sets."""
    if isinstance(value, (tuple, frozenset)):
        each = map(_literal, value)
        return [
            type(value).__name__,
            *(sorted(each, key=repr) if isinstance(value, frozenset) else each),
        ]
    return type(value).__name__, repr(value)


def _names(code):
    """Return the names that ``code`` looks up, with its lambdas and comprehensions."""
    inner = [_names(each) for each in code.co_consts if isinstance(each, types.CodeType)]
    return tuple(dict.fromkeys(itertools.chain(code.co_names, *inner)))


def _constant(value, names):
    """Return what compiled code takes of a ``value`` found by name, "" for nothing.

    Of a module these are its constants among ``names``.
    """
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, (tuple, list)):
        return [type(value).__name__, *(_constant(each, names) for each in value)]
    if isinstance(value, (bool, int, float, complex, str, np.generic)):
        return type(value).__name__, repr(value)
    if isinstance(value, types.ModuleType):
        own = [(name, _constant(getattr(value, name, None), ())) for name in names]
        return [each for each in own if each[1]]
    compiled = getattr(value, "py_func", None)  # of numba
    return digest(compiled) if isinstance(compiled, types.FunctionType) else ""


def _helpers(function):
    found = {name: function.__globals__.get(name) for name in _names(function.__code__)}
    return {name: each for name, each in found.items() if isinstance(each, types.FunctionType)}


# The loops, compiled with another ``term`` each time ----------------------------------------------

term = None


def of_edges(values, first, second, *given):
    """Return the sums (n, d) of the term over edges ``first``, ``second`` (m,) of ``values`` (n, d)."""
    (n, d), m = values.shape, len(first)
    apart = np.empty((d, m))
    for axis in range(d):
        for edge in range(m):
            apart[axis, edge] = values[second[edge], axis] - values[first[edge], axis]
    flow, total = term(apart, *given), np.zeros((d, n))
    for axis in range(d):
        for edge in range(m):
            total[axis, first[edge]] += flow[axis, edge]
    return total.T


def of_flow(points, places, gain, first, second, *given):
    """Return ``gain`` times the sums (n, d) of the term over edges of ``points - places`` (n, d)."""
    (n, d), m = points.shape, len(first)
    apart = np.empty((d, m))
    for axis in range(d):
        for edge in range(m):
            i, j = first[edge], second[edge]
            here = points[i, axis] - places[i, axis]
            apart[axis, edge] = (points[j, axis] - places[j, axis]) - here
    flow, total = term(apart, *given), np.zeros((d, n))
    for axis in range(d):
        for edge in range(m):
            total[axis, first[edge]] += flow[axis, edge]
    return gain * total.T


def of_pairs(values, first, second, *given):
    """Return the same less the sums over the edges by their ``second`` robots."""
    (n, d), m = values.shape, len(first)
    apart = np.empty((d, m))
    for axis in range(d):
        for edge in range(m):
            apart[axis, edge] = values[second[edge], axis] - values[first[edge], axis]
    flow, gained, lost = term(apart, *given), np.zeros((d, n)), np.zeros((d, n))
    for axis in range(d):
        for edge in range(m):
            gained[axis, first[edge]] += flow[axis, edge]
            lost[axis, second[edge]] += flow[axis, edge]
    return (gained - lost).T


def of_all(points, values, *given):
    """Return the sums (n, d) of ``w (x_j - x_i)`` over all robots, the term being the weight w."""
    (n, d), width = points.shape, values.shape[1]
    apart, total = np.empty((d, n)), np.zeros((width, n))
    for row in range(n):
        for axis in range(d):
            for other in range(n):
                apart[axis, other] = points[other, axis] - points[row, axis]
        weight = term(apart, *given)
        for axis in range(width):
            for other in range(n):
                total[axis, row] += weight[other] * (values[other, axis] - values[row, axis])
    return total.T
