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


def _whole(twist):
    """Return ``twist``, a ``PlanarTwist``, as the ``Twist`` that it is from now on."""
    v, omega = getattr(twist, "_v", 0.0), getattr(twist, "_omega", 0.0)
    twist.__class__ = Twist
    twist.linear, twist.angular = linear, angular = Vector3(), Vector3()
    linear.x, angular.z = v, omega  # in a third of the time of vectors made of components
    return twist


def _field(name):
    """Return the property of a field ``name``, at whose first use vectors are made."""
    return property(
        lambda twist: getattr(_whole(twist), name),
        lambda twist, value: setattr(_whole(twist), name, value),
    )


class PlanarTwist(Twist):
    """A ``Twist`` of ``v`` and ``omega`` that keeps these in the places of its vectors, and turns into a
    plain ``Twist``, which has them, at the first access."""

    __slots__ = ()
    _v, _omega = Twist.linear, Twist.angular  # what reads and writes these places
    linear, angular = _field("linear"), _field("angular")

    __init__ = object.__init__  # so that making one runs no function of Python's

    def __eq__(self, other):
        return _whole(self) == other

    __hash__ = None

    def __reduce_ex__(self, protocol):
        return _whole(self).__reduce_ex__(protocol)


PlanarTwist.__slots__ = Twist.__slots__  # what messages are printed and compared by


def make_twist(v, omega):
    """Return the ``Twist`` of forward speed ``v`` [m/s] and turn rate ``omega`` [rad/s]."""
    twist = PlanarTwist()
    twist._v, twist._omega = v, omega
    return twist


__all__ = ["Twist", "Vector3", "make_twist"]
