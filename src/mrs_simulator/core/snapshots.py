"""Snapshots: the state of objects that act together, from which they go on to the same bits."""

import io
import pickle
import types

FIXED = (types.ModuleType, types.BuiltinFunctionType, type, slice)  # slices are compared by `is`


class NotCopied(ValueError):
    """A state that cannot be copied; the message says of what."""


class Constant:
    """Something that never changes: copies and snapshots of what holds it share it."""

    def __deepcopy__(self, memo):
        return self


class Snapshot:
    """The state of ``objects`` now, with everything that their attributes refer to.

    The objects stay the same, and so do instances of ``Constant``, functions and classes; all else is
    copied once, however many refer to it.  What there is no copy of, such as a solver's memory, raises
    ``NotCopied`` in its ``__getstate__``.
    """

    def __init__(self, objects):
        self._objects = tuple(objects)
        self._shared = _Shared(self._objects)
        file = io.BytesIO()
        try:
            _Writer(file, self._shared).dump(list(map(_state_of, self._objects)))
        except (TypeError, AttributeError, pickle.PicklingError, RecursionError) as error:
            raise NotCopied(str(error)) from None
        self._state = file.getvalue()

    def restore(self):
        """Put the objects back into this state; as often as is wanted."""
        states = _Reader(io.BytesIO(self._state), self._shared).load()
        for each, state in zip(self._objects, states):
            vars(each).clear()
            vars(each).update(state)


def _state_of(each):
    own = getattr(type(each), "__getstate__", None)
    return vars(each) if own in (None, getattr(object, "__getstate__", None)) else own(each)


class _Shared:
    """What is not copied, by number."""

    def __init__(self, objects):
        self._numbers = {id(each): number for number, each in enumerate(objects)}
        self.all = list(objects)

    def number(self, each):
        """Return the number of ``each`` where it is shared, else None."""
        number = self._numbers.get(id(each))
        if number is None and _is_shared(each):
            number = self._numbers[id(each)] = len(self.all)
            self.all.append(each)
        return number


def _is_shared(each):
    if isinstance(each, types.FunctionType):
        if each.__closure__:
            text = "{}: a function that refers to variables around it; wanted a method, or data"
            raise NotCopied(text.format(each.__qualname__))
        return True
    return isinstance(each, (Constant, *FIXED)) or hasattr(type(each), "py_func")  # of numba


class _Writer(pickle.Pickler):
    def __init__(self, file, shared):
        super().__init__(file, 5)
        self._shared = shared

    def persistent_id(self, each):
        return self._shared.number(each)


class _Reader(pickle.Unpickler):
    def __init__(self, file, shared):
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, number):
        return self._shared.all[number]
