"""Finding kinds of robots: shipped, in a scenario, and in users' files."""

import functools
import os

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError, load_yaml, shown, unwanted
from mrs_simulator.scenario.scenario import DEFAULT_KIND, KIND_FILES
from mrs_simulator.vehicles.importing import imported, is_description, read_request
from mrs_simulator.vehicles.kind import Kind, read_kind

DIRECTORY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "kinds")
ENDING = ".yaml"
DEEPEST = 8  # [-] bases of bases


def shipped_kinds():
    """Return the names of the kinds that come with the package, the default one first."""
    names = [name[: -len(ENDING)] for name in os.listdir(DIRECTORY) if name.endswith(ENDING)]
    return tuple(sorted(names, key=lambda name: (name != DEFAULT_KIND, name)))


@explained_by("docs/kinds.md")
def kind(name, relative_to="", own=None):
    """Return the ``Kind`` called ``name``.

    ``name``: a shipped kind, one of ``own``, or the path of a kind's file (``.yaml``) or of a robot's
    description (``.urdf``, ``.xacro``), relative to the directory ``relative_to``; a ``Kind`` is returned
    as it is.  ``own``: the scenario's kinds, mappings by name; a base of theirs is found in the same
    way.  Raises ``ValueError`` (``ScenarioError``).
    """
    if isinstance(name, Kind):
        return name
    if name not in (own or {}) and not is_file(name):
        return shipped_kind(name, tuple(own or ()))
    content, where, directory = merged(name, relative_to, own or {})
    return read_kind(content, where, directory)


@functools.lru_cache(maxsize=None)
def shipped_kind(name, others=()):
    """Return the shipped ``Kind`` called ``name``; ``others``: further names for the error."""
    content, where, directory = merged(name, "", {}, others)
    return read_kind(content, where, directory)


def merged(name, relative_to, own, others=(), above=()):
    """Return the content of the kind ``name`` merged over its bases, its place and its directory.

    ``above``: the kinds that it is a base of, none of which may be its own base.
    """
    if name in own:
        content, where, directory = own[name], "kinds.{}".format(name), relative_to
    else:
        where = _path_of(name, relative_to, tuple(own) + tuple(others))
        content, directory = None, os.path.dirname(where)
    if where in above or len(above) >= DEEPEST:
        raise ScenarioError("{}: base {!r} leads back to it".format(above[0], name))
    content = _loaded(where) if content is None else content
    if not isinstance(content, dict):
        raise unwanted(where, content, "a mapping")
    for key in content:
        if not isinstance(key, str):
            raise ScenarioError("{}: key {}, wanted a text".format(where, shown(key)))
    content = _with_absolute_model(content, directory)
    base, request = content.pop("base", None), content.pop("import", None)
    default_name = os.path.basename(str(name)).split(".")[0] if is_file(name) else name
    if request is not None:
        if base is not None:
            raise ScenarioError("{}: base and import are given, wanted one of them".format(where))
        return _imported(request, dict({"name": default_name}, **content), where, directory)
    if base is None:
        return dict({"name": default_name}, **content), where, directory
    if not isinstance(base, str):
        raise ScenarioError("{}: base: {}, wanted a kind's name".format(where, shown(base)))
    # A kind of a scenario may adapt the shipped one of its name.
    known = {key: value for key, value in own.items() if key != name}
    if not is_file(base) and base not in shipped_kinds() + tuple(known):
        raise ScenarioError(unknown_name(where + ": base", base, shipped_kinds() + tuple(known)))
    beneath, _, _ = merged(base, directory, known, others, above + (where,))
    beneath = dict(beneath, name=default_name)
    if "title" not in content:
        beneath.pop("title", None)
    return _over(beneath, content), where, directory


def file_named(scenario):
    """Return what in the ``scenario`` names a file, "" if nothing does.

    The sender of a scenario from a topic or a bag is unknown: it opens no files.
    """
    if scenario.map is not None:
        return scenario.map.file
    for name in scenario.kinds:
        if name not in scenario.own_kinds and is_file(name):
            return name
    for name, content in scenario.own_kinds.items():
        key = _file_key(content)
        if key:
            return "kinds.{}.{}".format(name, key)
    return ""


def files_of_kinds(scenario):
    """Return the paths of the models of those kinds of ``scenario`` that are files, and what these say."""
    models, said = [], []
    for name in dict.fromkeys(scenario.kinds):
        if (
            name not in scenario.own_kinds
            and is_file(name)
            or names_a_file(name, scenario.own_kinds)
        ):
            content, _, _ = merged(name, scenario.directory, scenario.own_kinds)
            models += [content["model"]] if isinstance(content.get("model"), str) else []
            said.append(content)
    return models, said


def _file_key(content):
    """Return the key of a kind's ``content`` that names a file, "" if none does."""
    keys = content if isinstance(content, dict) else {}
    named = (
        k for k in ("import", "model", "base") if k in keys and (k != "base" or is_file(keys[k]))
    )
    return next(named, "")


def names_a_file(name, own):
    """Return whether the kind ``name`` of ``own``, or a base of it there, names a file."""
    seen = set()
    while name in own and name not in seen:
        if _file_key(own[name]):
            return True
        seen.add(name)
        name = own[name].get("base")
    return False


def _imported(request, content, where, directory):
    """Return ``content`` merged over the robot that ``request`` describes, as ``merged`` does."""
    request = read_request(request, "{}: import".format(where), directory)
    beneath, notes = imported(request, content, where)
    result = _over(beneath, content)
    given = content.get("notes", [])
    if isinstance(given, list):
        result["notes"] = given + list(notes)
    return result, where, directory


def is_file(name):
    """Return whether a kind's ``name`` is the path of a file."""
    return str(name).endswith(KIND_FILES)


def _path_of(name, relative_to, others):
    if is_file(name):
        return os.path.abspath(os.path.join(relative_to, os.path.expanduser(name)))
    known = shipped_kinds() + tuple(others)
    if name not in known:
        raise ScenarioError(unknown_name("model", name, known))
    return os.path.join(DIRECTORY, name + ENDING)


def _loaded(path):
    """Return the content of the kind's file at ``path``; a description's is to import it."""
    return {"import": {"urdf": path}} if is_description(path) else load_yaml(path)


def _with_absolute_model(content, directory):
    model = content.get("model")
    if not isinstance(model, str):
        return dict(content)
    return dict(content, model=os.path.abspath(os.path.join(directory, os.path.expanduser(model))))


def _over(beneath, content):
    """Return ``beneath`` with ``content`` over it, mapping by mapping; ``null`` takes a key away."""
    result = dict(beneath)
    for key, value in content.items():
        below = result.get(key)
        both = isinstance(below, dict) and isinstance(value, dict)
        result[key] = _over(below, value) if both else value
    return result
