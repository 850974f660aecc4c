"""Mistakes put into the source of a law, by its syntax tree: signs, terms, indices, neighbours, degrees."""

import ast
import contextlib
import copy
import inspect
import textwrap
from typing import Any, NamedTuple

from mrs_simulator.control.class_checks import HOOKS
from mrs_simulator.control.pioneer_control import PioneerControl

MOST = 12  # [-] mistakes put into one law
SHIPPED = "mrs_simulator.protocols."  # modules whose functions belong to the laws that call them
ANGLES = ("sin", "cos", "tan")  # functions of angles
WIDTH = 40  # [-] letters of a line of source that are shown
DEGREES = 57.29577951308232  # [deg/rad]
SWAPPED = {"x": "y", "y": "x"}


class Edit(NamedTuple):
    """A function ``name`` of ``owner``, a class or a module, and what stands in for it."""

    owner: Any
    name: str
    wrong: Any

    @contextlib.contextmanager
    def made(self):
        """Put the wrong function in its place for a while."""
        own = self.name in vars(self.owner)
        right = vars(self.owner).get(self.name)
        setattr(self.owner, self.name, self.wrong)
        try:
            yield
        finally:
            if own:
                setattr(self.owner, self.name, right)
            else:
                delattr(self.owner, self.name)


def source_edits(law):
    """Return ``{name: Edit}`` of the class ``law``: at most ``MOST``, the first of each kind first."""
    found = []
    for owner, name, function in _functions(law):
        counts = {}
        for kind, text, edit in _edits(owner, name, function):
            counts[kind] = counts.get(kind, 0) + 1
            found.append((counts[kind], text, edit))
    found.sort(key=lambda each: each[0])
    return {text: edit for _, text, edit in found[:MOST]}


def _functions(law):
    """Return ``(owner, name, function)`` of the hook of ``law`` and of all that it calls, as known."""
    known, waiting = [], [(law, name) for name in HOOKS]
    while waiting:
        owner, name = waiting.pop(0)
        function = _own_function(law, owner, name)
        if function is None or any(function is each[2] for each in known):
            continue
        known.append((owner, name, function))
        waiting += _called(law, function)
    return known


def _own_function(law, owner, name):
    """Return the function ``name``, of the law's class or of a module; None for others' code."""
    found = inspect.getattr_static(owner, name, None)
    found = getattr(found, "__func__", found)
    if not inspect.isfunction(found):
        return None
    if owner is law:
        base = inspect.getattr_static(PioneerControl, name, None)
        return None if found is getattr(base, "__func__", base) else inspect.unwrap(found)
    own = found.__module__ == law.__module__ or found.__module__.startswith(SHIPPED)
    return inspect.unwrap(found) if own else None


def _called(law, function):
    """Return ``(owner, name)`` of what ``function`` calls by ``self.name``, ``name`` or ``module.name``."""
    tree, names = _tree(function), function.__globals__
    found = []
    for node in ast.walk(tree) if tree else ():
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = law if node.value.id == "self" else names.get(node.value.id)
            if owner is law or inspect.ismodule(owner):
                found.append((owner, node.attr))
        elif isinstance(node, ast.Name) and inspect.isfunction(names.get(node.id)):
            module = inspect.getmodule(function)
            found += [(module, node.id)] if module is not None else []
    return found


def _tree(function):
    """Return the syntax tree of ``function``, None where there is no source or it has a closure."""
    if set(function.__code__.co_freevars) - {"__class__"}:
        return None
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, SyntaxError, TypeError):
        return None
    return tree.body[0] if isinstance(tree.body[0], ast.FunctionDef) else None


def _edits(owner, name, function):
    """Return ``(kind, text, Edit)`` for each mistake that can be put into ``function``."""
    tree, found = _tree(function), []
    if tree is None:
        return []
    source = textwrap.dedent(inspect.getsource(function))
    for place, node in enumerate(ast.walk(tree)):
        for kind, wrong in _wrong(node):
            number = getattr(node, "iter", node).lineno  # a comprehension has none of its own
            line = source.splitlines()[number - 1].strip()
            edited = _compiled(owner, function, _replaced(tree, place, wrong))
            if edited is not None:
                text = "{} in {}, {}: {}".format(kind, name, len(found) + 1, line[:WIDTH])
                found.append((kind, text, Edit(owner, name, edited)))
    return found


def _wrong(node):
    """Yield ``(kind, node)`` of what a mistake makes of a node."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
        other = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        yield "another sign", ast.BinOp(node.left, other, node.right)
        yield "a missing term", node.left
        first = node.right if isinstance(node.op, ast.Add) else ast.UnaryOp(ast.USub(), node.right)
        yield "a missing term", first
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        if not isinstance(node.operand, ast.Constant):
            yield "another sign", node.operand
    elif isinstance(node, ast.Attribute) and node.attr in SWAPPED:
        if isinstance(node.ctx, ast.Load):
            yield "another index", ast.Attribute(node.value, SWAPPED[node.attr], node.ctx)
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        other = _reindexed(node)
        if other is not None:
            yield "another index", other
    elif isinstance(node, ast.comprehension):
        fewer = ast.comprehension(node.target, _but_last(node.iter), node.ifs, node.is_async)
        yield "a missing neighbour", fewer
    elif isinstance(node, ast.For):
        yield (
            "a missing neighbour",
            ast.For(node.target, _but_last(node.iter), node.body, node.orelse),
        )
    elif isinstance(node, ast.Call):
        yield from _wrong_call(node)


def _wrong_call(node):
    function = node.func.attr if isinstance(node.func, ast.Attribute) else ""
    if function in ANGLES and len(node.args) == 1:
        degrees = ast.BinOp(node.args[0], ast.Mult(), ast.Constant(DEGREES))
        yield "degrees for radians", ast.Call(node.func, [degrees], node.keywords)
    elif function in ("laplacian", "adjacency"):
        yield "other neighbours", ast.Attribute(node, "T", ast.Load())


def _reindexed(node):
    other = copy.deepcopy(node)
    for each in ast.walk(other.slice):
        if isinstance(each, ast.Slice):
            return None
        if isinstance(each, ast.Constant) and type(each.value) is int:
            each.value = each.value - 1 if each.value else 1
            return other
    return None


def _but_last(iterated):
    everything = ast.Call(ast.Name("list", ast.Load()), [iterated], [])
    until = ast.UnaryOp(ast.USub(), ast.Constant(1))
    part = ast.parse("x[:-1]", mode="eval").body
    part.value, part.slice.upper = everything, until
    return part


def _replaced(tree, place, wrong):
    """Return a copy of ``tree`` whose node number ``place``, as they are walked, is ``wrong``."""
    tree, wrong = copy.deepcopy((tree, wrong))
    right = list(ast.walk(tree))[place]

    class Replacing(ast.NodeTransformer):
        def visit(self, node):
            return wrong if node is right else self.generic_visit(node)

    return ast.fix_missing_locations(Replacing().visit(tree))


def _compiled(owner, function, tree):
    """Return the function of ``tree``, with what ``function`` knows; None where it cannot be made."""
    make = ast.parse("def make(__class__):\n    return None").body[0]
    make.body = [tree, ast.Return(ast.Name(tree.name, ast.Load()))]
    module = ast.fix_missing_locations(ast.Module([make], []))
    found = {}
    try:
        exec(compile(module, "<mistake>", "exec"), function.__globals__, found)
        return found["make"](owner)
    except Exception:  # of a decorator, or of a tree that is no program
        return None
