"""The rooms of the package in their order, and what a module imports."""

import ast

# Each room may import those before it, and no other.
ROOMS = (
    "core",
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


def room_of_test(path):
    """Return the last room, in their order, that the test file at ``path`` imports from, or ""."""
    used = {
        name.split(".")[1]
        for name in imported(path)
        if name.startswith("mrs_simulator.") and name.split(".")[1] in ROOMS
    }
    return max(used, key=ROOMS.index, default="")
