"""The rooms of the package in their order, and what a module imports."""

import ast
import functools

# Each room may import those before it, and no other.
ROOMS = (
    "core",
    "state",
    "scenario",
    "record",
    "vehicles",
    "pictures",
    "sensors",
    "world",
    "control",
    "protocols",
    "verdict",
    "ros",
    "study",
    "nodes",
    "rqt_plugin",
)


@functools.lru_cache(maxsize=None)
def imported(path):
    """Return the names of the modules that the Python file at ``path`` imports, anywhere in it."""
    return tuple(name for name, _ in _imports(path))


def imported_modules(path):
    """Return what :func:`imported` returns, and names that may be modules within a package."""
    within = ("{}.{}".format(name, inner) for name, names in _imports(path) for inner in names)
    return (*within, *imported(path))


@functools.lru_cache(maxsize=None)
def _imports(path):
    """Return (module, names imported from it) of all imports; statements are searched, no expressions."""
    with open(path, encoding="utf-8") as file:
        left = list(ast.parse(file.read()).body)
    found = []
    while left:
        node = left.pop()
        if isinstance(node, ast.Import):
            found += [(alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found.append((node.module or "", tuple(alias.name for alias in node.names)))
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            left += getattr(node, block, ())
    return found
