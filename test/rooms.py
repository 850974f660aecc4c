"""The rooms of the package in their order, and what a module imports."""

import ast

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


def imported(path):
    """Yield the names of the modules that the Python file at ``path`` imports, anywhere in it."""
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


def imported_modules(path):
    """Yield what :func:`imported` yields, and names that may be modules within a package."""
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield "{}.{}".format(node.module, alias.name)
    yield from imported(path)
