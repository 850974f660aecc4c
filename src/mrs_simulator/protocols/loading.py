"""Loads a protocol by name: a shipped one, ``package.module:Class`` or ``file.py:Class``.

Naming a protocol runs its code, so a name may come from a command line, a launch file or a local
scenario file, never from a topic or a service.
"""

import contextlib
import importlib
import importlib.util
import inspect
import os
import sys
import traceback

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.control.user_code import call
from mrs_simulator.core.doc_links import named
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.protocols import HOMES, shipped

_helpers = set()  # names of modules and packages that laws imported from beside them
_loading = 0  # how many protocols are being loaded, one within the other


def in_progress():
    """Return whether a protocol's file is being loaded now: a ``run`` in it is not meant then."""
    return _loading > 0


@contextlib.contextmanager
def _marked():
    global _loading
    _loading += 1
    try:
        yield
    finally:
        _loading -= 1


OWN_INIT = (
    "start() for what a law remembers, or an __init__(self, *args, **kwargs) that begins with "
)
OWN_INIT += "super().__init__(*args, **kwargs)"


class ProtocolError(ValueError):
    """A protocol that cannot be had; the message names it and says why."""

    page = "docs/protocols.md#where-a-protocol-is-named"


def load_protocol(name, beside=""):
    """Return the ``PioneerControl`` subclass called ``name``.

    A relative file is looked up in the current directory, then in the directory of the file
    ``beside`` (the scenario that names it).  Without ``:Class`` a file must hold exactly one
    protocol.  Raises ``ProtocolError``.
    """
    if name in HOMES:
        return shipped(name)
    source, class_name = split_name(name)
    if source.endswith(".py"):
        with _marked():
            module = _module_from_file(_located(source, beside), name)
    elif class_name:
        with _marked():
            module = _module_by_name(source, name)
    else:
        raise ProtocolError(
            unknown_name("protocol", name, HOMES) + "; or wanted package.module:Class or "
            "path/to/file.py:Class"
        )
    return _class_in(module, class_name, name)


def located_protocol(name, beside=""):
    """Return ``name`` with a file's absolute path, so that it means the same from anywhere."""
    path = protocol_file(name, beside)
    return ":".join(filter(None, (path, split_name(name)[1]))) if path else name


def from_anywhere(scenario):
    """Return ``scenario`` with a protocol's file beside it named so that it is found from anywhere."""
    control = scenario.control
    with contextlib.suppress(ProtocolError):  # a class given by the program, not by its name
        control = control._replace(protocol=located_protocol(control.protocol, scenario.path))
    return scenario._replace(control=control)


def protocol_file(name, beside=""):
    """Return the absolute path of the file that the protocol ``name`` names, "" if it names none."""
    source, _ = split_name(name)
    return "" if name in HOMES or not source.endswith(".py") else _located(source, beside)


def split_name(name):
    """Return the source and the class of a protocol's name; a path may hold a colon."""
    if ":" not in name or name.endswith(".py"):
        return name, ""
    source, _, class_name = name.rpartition(":")
    return source, class_name


def choose_protocol(scenario, protocol=None):
    """Return ``(scenario, protocol)``: the class that is to run, and the scenario that names it.

    Without ``protocol`` it is the one that the scenario names.  A class of one's own takes its
    defaults where the scenario's parameters were written for another protocol.  A default of its own for
    l goes into the scenario, which says where the recorded hand points are.
    """
    if protocol is None:
        protocol = load_protocol(scenario.control.protocol, beside=scenario.path)
        return _with_hand_length(scenario, protocol), protocol
    if not isinstance(protocol, type) or not issubclass(protocol, PioneerControl):
        text = "protocol {}: wanted a subclass of PioneerControl, or the name of one"
        raise ProtocolError(text.format(getattr(protocol, "__name__", type(protocol).__name__)))
    if not _is_named(protocol, scenario.control.protocol):
        scenario = scenario.with_protocol(_name_of(protocol))
    return _with_hand_length(scenario, protocol), protocol


def _is_named(protocol, name):
    """Return whether the class ``protocol`` is the one that ``name`` names, wherever its file lies."""
    if name in HOMES:
        return protocol is shipped(name)
    if name.rpartition(":")[2] == protocol.__name__:
        return True
    # The only one of a file needs no name of its own.
    own, _, _ = _name_of(protocol).rpartition(":")
    return os.path.basename(name) == os.path.basename(own)


def _with_hand_length(scenario, protocol):
    """Return ``scenario`` with the default that ``protocol`` has for l, where neither says another."""
    control = scenario.control
    default = next(each.default for each in protocol.PARAMETERS if each.name == "l")
    if "l" in control.parameters or default == scenario.hand_length:
        return scenario
    parameters = dict(control.parameters, l=default)
    return scenario._replace(control=control._replace(parameters=parameters))


def _name_of(protocol):
    """Return the name by which ``protocol`` is found again: its file and class."""
    try:
        path = inspect.getfile(protocol)
    except (OSError, TypeError):  # typed in by hand
        return protocol.__name__
    return "{}:{}".format(path, protocol.__name__)


def _located(source, beside):
    source = os.path.expanduser(source)
    places = [source]
    if beside and not os.path.isabs(source):
        places.append(os.path.join(os.path.dirname(os.path.abspath(beside)), source))
    for place in places:
        if os.path.isfile(place):
            return os.path.abspath(place)
    raise ProtocolError(
        "protocol file {}: not found (looked at {})".format(source, ", ".join(places))
    )


def _module_from_file(path, name):
    module_name = os.path.splitext(os.path.basename(path))[0]
    spec = importlib.util.spec_from_file_location("mrs_protocol_" + module_name, path)
    module = importlib.util.module_from_spec(spec)
    directory = os.path.dirname(path)
    aside = _put_aside()
    before = {*sys.modules, spec.name}
    # A protocol's helpers may lie beside it.
    sys.path.insert(0, directory)
    try:
        # Registered before it runs, as import does, so that its classes can be pickled.
        sys.modules[spec.name] = module
        call(spec.loader.exec_module, module)
    except KeyboardInterrupt:
        del sys.modules[spec.name]
        raise
    except Exception as error:
        del sys.modules[spec.name]
        raise ProtocolError(
            "protocol {}: {}{}".format(name, _place(error, path), named(error))
        ) from error
    finally:
        sys.path.remove(directory)
        _put_back(aside, directory, before)
    return module


def _put_aside():
    """Take what laws imported from beside them out of ``sys.modules``; return it by name.

    So a law imports its own helpers, as they are now, and not others of their names.
    """
    importlib.invalidate_caches()
    names = [name for name in sys.modules if name.partition(".")[0] in _helpers]
    return {name: sys.modules.pop(name) for name in names}


def _put_back(aside, directory, before):
    """Note the helpers in ``directory`` that were not loaded ``before``, a set; those ``aside`` return.

    Where both are of a name the newer stays: laws keep what they have imported.
    """
    for root in {name.partition(".")[0] for name in sys.modules.keys() - before}:
        module = sys.modules.get(root)
        places = [getattr(module, "__file__", None) or "", *getattr(module, "__path__", ())]
        if any(os.path.dirname(place) == directory for place in places):
            _helpers.add(root)
    loaded = {name.partition(".")[0] for name in sys.modules}
    sys.modules.update({k: v for k, v in aside.items() if k.partition(".")[0] not in loaded})


def refused_init(protocol, error):
    """Return the ``ProtocolError`` for an ``error`` that left the ``__init__`` of a user's ``protocol``."""
    try:
        path = inspect.getfile(protocol)
    except (OSError, TypeError):  # typed in by hand
        path = ""
    text = "{}{}.__init__ raised {}; wanted {}"
    return ProtocolError(
        text.format(_place(error, path), protocol.__name__, named(error), OWN_INIT)
    )


def has_own_init(protocol):
    """Return whether the ``protocol`` has an ``__init__`` that users wrote."""
    return not protocol.__init__.__module__.startswith(__package__.partition(".")[0] + ".")


def _place(error, path):
    """Return where in the user's file at ``path`` the ``error`` came up, as "file, line n: "."""
    if isinstance(error, SyntaxError) and error.filename:
        return "{}, line {}: ".format(error.filename, error.lineno)
    frames = traceback.extract_tb(error.__traceback__)
    directory = os.path.dirname(path)  # its helpers may lie beside it
    own = [frame for frame in frames if os.path.dirname(frame.filename) == directory]
    return "{}, line {}: ".format(own[-1].filename, own[-1].lineno) if own else ""


def _module_by_name(module_name, name):
    try:
        return call(importlib.import_module, module_name)
    except Exception as error:
        raise ProtocolError(
            "protocol {}: importing {} raised {}".format(name, module_name, named(error))
        ) from error


def _class_in(module, class_name, name):
    found = {
        key: value
        for key, value in vars(module).items()
        if isinstance(value, type)
        and issubclass(value, PioneerControl)
        and (value.__module__ == module.__name__ or key == class_name)
    }
    if class_name:
        if class_name not in found:
            raise ProtocolError(unknown_name("protocol {}: class".format(name), class_name, found))
        return found[class_name]
    if len(found) != 1:
        raise ProtocolError(
            "protocol {}: {} subclasses of PioneerControl ({}), wanted one, or name it as "
            "file.py:Class".format(name, len(found), ", ".join(sorted(found)) or "none")
        )
    return next(iter(found.values()))
