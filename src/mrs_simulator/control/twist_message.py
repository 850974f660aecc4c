"""``geometry_msgs/Twist``, and where ROS is absent classes with the same fields.

A protocol that imports ``geometry_msgs.msg`` then finds these classes there: its file runs unchanged.
"""

import importlib.machinery
import sys
import types

try:
    from geometry_msgs.msg import Twist, Vector3
except ModuleNotFoundError as error:
    if error.name not in ("geometry_msgs", "geometry_msgs.msg"):
        raise  # ROS is installed incompletely

    class _Message:
        """Named fields, with the constructor, the comparison and the text of ROS's messages."""

        __slots__ = ()

        def __init__(self, *args, **kwargs):
            """Take no arguments, all fields in their order, or some fields by name."""
            if args and (kwargs or len(args) != len(self.__slots__)):
                text = "{}: wanted {} or keyword arguments"
                raise TypeError(text.format(type(self).__name__, ", ".join(self.__slots__)))
            given = dict(zip(self.__slots__, args), **kwargs)
            for name in self.__slots__:
                setattr(self, name, given.pop(name) if name in given else self._default())
            if given:
                raise AttributeError(
                    "{} has no field {!r}, wanted {}".format(
                        type(self).__name__, next(iter(given)), ", ".join(self.__slots__)
                    )
                )

        def __eq__(self, other):
            if not isinstance(other, type(self)):
                return NotImplemented
            return all(getattr(self, name) == getattr(other, name) for name in self.__slots__)

        __hash__ = None

        def __repr__(self):
            fields = ("{}={!r}".format(name, getattr(self, name)) for name in self.__slots__)
            return "{}({})".format(type(self).__name__, ", ".join(fields))

    class Vector3(_Message):
        """Components ``x``, ``y`` and ``z``."""

        __slots__ = ("x", "y", "z")
        _default = float

    class Twist(_Message):
        """Velocities ``linear`` [m/s] and ``angular`` [rad/s], each a :class:`Vector3`."""

        __slots__ = ("linear", "angular")
        _default = Vector3

    def _stand_in(name, is_package=False, **content):
        """Register a module called ``name`` that holds ``content``."""
        module = types.ModuleType(name, "Stands in for that of ROS, which is absent.")
        module.__spec__ = importlib.machinery.ModuleSpec(name, None, is_package=is_package)
        vars(module).update(content)
        sys.modules[name] = module
        return module

    _stand_in(
        "geometry_msgs",
        is_package=True,
        __path__=[],
        msg=_stand_in("geometry_msgs.msg", Twist=Twist, Vector3=Vector3),
    )

_new = object.__new__


class PlanarTwist(Twist):
    """A ``Twist`` of ``v`` and ``omega``, whose vectors are made at the first access."""

    __slots__ = ("_v", "_omega")

    def __getattr__(self, name):
        """Make the vectors at the first access."""
        if name not in Twist.__slots__:
            raise AttributeError("Twist has no attribute {!r}".format(name))
        self.linear, self.angular = Vector3(self._v, 0.0, 0.0), Vector3(0.0, 0.0, self._omega)
        del self._v, self._omega  # from now on the vectors hold, which may be written to
        return getattr(self, name)

    def __eq__(self, other):
        if not isinstance(other, Twist):
            return NotImplemented
        return (self.linear, self.angular) == (other.linear, other.angular)

    __hash__ = None


PlanarTwist.__slots__ = Twist.__slots__  # what messages are printed, compared and pickled by


def make_twist(v, omega):
    """Return the ``Twist`` of forward speed ``v`` [m/s] and turn rate ``omega`` [rad/s]."""
    twist = _new(PlanarTwist)
    twist._v, twist._omega = v, omega
    return twist


__all__ = ["Twist", "Vector3", "make_twist"]
