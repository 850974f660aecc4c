"""What a user's law refers to outside of itself: variables of its module and attributes of its classes."""

import pickle
import types

from mrs_simulator.core.snapshots import NotCopied

OURS = ("mrs_simulator", "builtins", "abc")
CODE = (types.ModuleType, type, types.FunctionType, types.BuiltinFunctionType)
CODE += (staticmethod, classmethod, property)


def law_globals(control):
    """Return the data that the law of ``control`` may keep elsewhere than in ``self``, bytes by name.

    Of shipped laws there is none.  Raises ``NotCopied`` for what cannot be looked into.
    """
    found = {}
    for cls in type(control).__mro__:
        if cls.__module__.split(".")[0] in OURS:
            continue
        for name, value in vars(cls).items():
            if not name.startswith("__") and not isinstance(value, CODE):
                found["{}.{}".format(cls.__name__, name)] = value
            for function in _functions(value):
                _look_into(function, found, set())
    return {name: _bytes(name, value) for name, value in found.items()}


def _functions(value):
    """Return the functions in a class's attribute ``value``."""
    parts = (value.fget, value.fset) if isinstance(value, property) else (value,)
    parts = [getattr(part, "__func__", part) for part in parts]
    return [part for part in parts if isinstance(part, types.FunctionType)]


def _look_into(function, found, seen):
    """Add the data that ``function`` names, and the functions of its module that it calls, to ``found``."""
    if function in seen:
        return
    seen.add(function)
    known = function.__globals__
    for name in _names(function.__code__):
        value = known.get(name)
        if isinstance(value, types.FunctionType) and value.__globals__ is known:
            _look_into(value, found, seen)
        elif name in known and not isinstance(value, CODE):
            found["{}.{}".format(function.__module__, name)] = value


def _names(code):
    """Return the global names in ``code``, with those of functions and comprehensions within."""
    inner = [each for each in code.co_consts if isinstance(each, types.CodeType)]
    return set(code.co_names).union(*map(_names, inner))


def _bytes(name, value):
    try:
        return pickle.dumps(value)
    except Exception as error:  # of whatever a user's class does as it is pickled
        raise NotCopied("{}: {}".format(name, error)) from None
