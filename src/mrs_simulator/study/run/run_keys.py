"""Keys of runs: of two runs they differ where anything does that decides on the run or its verdict.

What a law reads by itself, as a file of gains, is not known here, and no key covers it.
"""

import ast
import contextlib
import functools
import hashlib
import os
import sys
import sysconfig

from mrs_simulator.protocols import HOMES
from mrs_simulator.protocols.loading import load_protocol, protocol_file, split_name
from mrs_simulator.scenario.surroundings.maps import files_of_map
from mrs_simulator.vehicles.registry import files_of_kinds
from mrs_simulator.verdict.verdict import versions

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# rooms that neither run nor judge
OTHERS = ("msg", "nodes", "pictures", "ros", "rqt_plugin", "scripts")
COMPUTING = ("mrs_simulator", "numpy", "pybullet")  # of ``versions``: what numbers depend on
CACHE = "__pycache__"
INSTALLED = ("site-packages", "dist-packages")
LENGTH = 10  # [-] hexadecimal digits


def run_key(scenario):
    """Return the key of a run of ``scenario``, ``LENGTH`` hexadecimal digits.

    It is made of the scenario, the files of its map and kinds, the Python files of its law
    (:func:`law_files`), the sources of this package, and the versions of what computes.
    """
    content = hashlib.sha256(scenario.to_yaml().encode())
    content.update(_law_digest(scenario.control.protocol, scenario.path))
    content.update(_computing())
    files, kinds = files_of_kinds(scenario)
    content.update(repr(kinds).encode())
    content.update(_digest((files_of_map(scenario) if scenario.map else []) + files))
    return content.hexdigest()[:LENGTH]


def forget():
    """Look at the files of laws anew; until then each law's are read once."""
    _law_digest.cache_clear()


@functools.lru_cache(maxsize=None)
def _law_digest(protocol, beside):
    return _digest(law_files(protocol, beside))


@functools.lru_cache(maxsize=None)
def _computing():
    """Return a digest of this package's sources and of the versions of what computes."""
    found = versions()
    content = repr([found[name] for name in COMPUTING]).encode()
    files = [
        os.path.join(directory, name)
        for room in sorted(set(os.listdir(PACKAGE)) - set(OTHERS))
        for directory, _, names in os.walk(os.path.join(PACKAGE, room))
        if os.path.basename(directory) != CACHE  # what is compiled, by numba too
        for name in names
        if not name.endswith(".pyc")
    ]
    return content + _digest(sorted(files))


def _digest(paths):
    """Return a digest of the contents of ``paths``; of what is missing the run says so."""
    content = hashlib.sha256()
    for path in paths:
        with contextlib.suppress(OSError), open(path, "rb") as file:
            content.update(hashlib.sha256(file.read()).digest())
    return content.digest()


def law_files(protocol, beside=""):
    """Return the paths of the Python files of the law named ``protocol``: its own, and those it imports.

    Imports are found wherever they stand in a file, and in the files imported.  Python's own modules,
    installed packages and this package are left out.  The law is loaded; where it cannot be, the run says
    so.
    """
    if protocol in HOMES:
        return []
    with contextlib.suppress(ValueError):
        load_protocol(protocol, beside)
    own = _law_file(protocol, beside)
    waiting = [own] if own else _files_of(split_name(protocol)[0], sys.path)
    places, found = ([os.path.dirname(own)] if own else []), {}
    while waiting:
        path = os.path.abspath(waiting.pop())
        if path not in found and not _is_foreign(path):
            found[path] = True
            waiting += _imported(path, places)
    return sorted(found)


def _law_file(protocol, beside):
    with contextlib.suppress(ValueError):
        return protocol_file(protocol, beside)
    return ""


def _imported(path, places):
    """Return the files that the Python file at ``path`` imports; first looked for in ``places``."""
    try:
        with open(path, "rb") as file:
            tree = ast.parse(file.read())
    except (OSError, ValueError, SyntaxError):
        return []
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                found += _files_of(alias.name, places + sys.path)
        elif isinstance(node, ast.ImportFrom):
            above, start = [places + sys.path], os.path.dirname(path)
            if node.level:
                above = [[os.path.join(start, *[os.pardir] * (node.level - 1))]]
            for alias in node.names:
                found += _files_of(".".join(filter(None, (node.module, alias.name))), *above)
    return found


def _files_of(module, places):
    """Return the files of ``module``, a dotted name, and of the packages that it is in.

    A package that is loaded says where its modules are, as those of a catkin workspace do.
    """
    found, parts = [], module.split(".")
    for row, part in enumerate(parts):
        at = [os.path.join(place, part) for place in places]
        files = [name for each in at for name in (os.path.join(each, "__init__.py"), each + ".py")]
        file = next(filter(os.path.isfile, files), "")
        if file:
            found.append(file)
            at = [os.path.dirname(file)] if file.endswith("__init__.py") else []
        loaded = sys.modules.get(".".join(parts[: row + 1]))
        if not file or _is_foreign(file):
            at += list(getattr(loaded, "__path__", ()))
            found += filter(None, [getattr(loaded, "__file__", None)])
        places = at
    return [file for file in found if file.endswith(".py")]


def _is_foreign(path):
    """Return whether the file at ``path`` is Python's, of an installed package, or of this one."""
    real = os.path.realpath(path)
    if real.startswith(PACKAGE + os.sep) or any(each in real.split(os.sep) for each in INSTALLED):
        return True
    return real.startswith(_standard())


@functools.lru_cache(maxsize=None)
def _standard():
    known = sysconfig.get_paths()
    return tuple(os.path.realpath(known[name]) + os.sep for name in ("stdlib", "platstdlib"))
