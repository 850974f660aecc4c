"""What a protocol's class may define, and which names are ``PioneerControl``'s own."""

from mrs_simulator.control.twists import ControlError
from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import Parameter, shown

HOOKS = ("calculateControlLaw", "pointMassLaw", "neighbourLaw")
DIMENSIONS = (2, 3)
# Attributes of PioneerControl: laws read them and may not assign them.
OWN = {
    "numbers": "the robots' numbers",
    "team": "the robots' vehicles",
    "dimension": "how many coordinates the controlled points have",
    "joints": "the drives' inner joints, such as steering angles",
    "limits": "the limits of each command axis",
    "saturation": "how the limits on speeds are kept to",
    "deadband": "up to which commands are sent as zero",
    "safety": "the robots' radii, which the safety filter keeps apart",
    "obstacles": "what stands in the scene",
    "readings": "the robots' sensors",
    "links": "the faults of the edges",
    "edge_seed": "the seed of the faults of the edges",
    "period": "the time between two commands",
    "fidelity": "what moves the robots",
    "parameters": "the values of PARAMETERS by name",
    "_environment": "current, wind and waves",
    "_given_topology": "the scenario's topology",
    "runner": "what runs the law",
    "safety_filter": "what keeps robots apart",
}
SET_BY_ALL = ("topology", "time")  # its own too, but a law or a test may set them


def refuse_own_name(cls, base, name, value):
    """Raise ``ControlError`` where a ``cls`` may not assign ``value`` to ``self.name``.

    ``base``: PioneerControl.  Its methods may be replaced by what can be called.
    """
    if name in OWN:
        text = "{}: self.{} is PioneerControl's own, {}: wanted another name"
        raise ControlError(text.format(cls.__name__, name, OWN[name]))
    known = getattr(base, name, None)
    if isinstance(known, property) or callable(known) and not callable(value):
        text = "{}: self.{} is a method or property of PioneerControl: wanted another name for {}"
        raise ControlError(text.format(cls.__name__, name, shown(value)))


def check_class(cls, base):
    """Raise ``TypeError`` that names what is wrong in a subclass ``cls`` of ``base``, PioneerControl."""
    with explained_by("docs/protocols.md", TypeError):
        _refuse_hidden_hook(cls)
    with explained_by("docs/protocols.md#names-that-are-taken", TypeError):
        _refuse_names(cls, base)
    with explained_by("docs/protocols.md#parameters-and-topology", TypeError):
        _refuse_parameters(cls, base)
    with explained_by("docs/protocols.md#in-space", TypeError):
        _refuse_dimensions(cls)
    with explained_by("docs/sensors.md", TypeError):
        _refuse_sensors(cls)


def _refuse_dimensions(cls):
    """Refuse ``DIMENSIONS`` that are not some of those there are."""
    given = cls.DIMENSIONS
    if not isinstance(given, (tuple, list)) or not given or not set(given) <= set(DIMENSIONS):
        text = "{}.DIMENSIONS = {}: wanted some of {}"
        raise TypeError(text.format(cls.__name__, shown(given), DIMENSIONS))


def _refuse_sensors(cls):
    """Refuse ``SENSORS`` that are no names."""
    if not isinstance(cls.SENSORS, (tuple, list)) or not all(type(s) is str for s in cls.SENSORS):
        text = "{}.SENSORS = {}: wanted a tuple of sensors' names"
        raise TypeError(text.format(cls.__name__, shown(cls.SENSORS)))


def _refuse_hidden_hook(cls):
    """Refuse a ``calculateControlLaw`` that hides another hook of the same class."""
    own = [hook for hook in HOOKS if hook in vars(cls)]
    law = vars(cls).get("calculateControlLaw")
    used = getattr(getattr(law, "__code__", None), "co_names", own)
    if law is not None and len(own) > 1 and not {*own[1:], "super", "wanted_commands"} & set(used):
        text = "{} overrides {}: the first hides the other, wanted one of them"
        raise TypeError(text.format(cls.__name__, " and ".join(own)))


def _refuse_names(cls, base):
    """Refuse what hides a name of the base's own, a private method, or a method with a mere value."""
    for name, value in vars(cls).items():
        if name in OWN or name in SET_BY_ALL:
            what = OWN.get(name, "which it sets at each command")
        elif not name.startswith("_") and _is_hidden_by(value, getattr(base, name, None)):
            what = "a method"
        elif name.startswith("_") and not name.startswith("__") and hasattr(base, name):
            what = "a part that laws do not see"
        else:
            continue
        text = "{} defines {!r}, a name of PioneerControl's own, {}: wanted another name"
        raise TypeError(text.format(cls.__name__, name, what))


def _is_hidden_by(value, method):
    return callable(method) and not callable(value) and not hasattr(value, "__get__")


def _refuse_parameters(cls, base):
    """Refuse ``PARAMETERS`` that are no sequence of ``Parameter``, or called as the base's own."""
    given = cls.PARAMETERS
    if isinstance(given, Parameter):
        text = "{}.PARAMETERS is one Parameter, wanted a tuple: (Parameter(...),)"
        raise TypeError(text.format(cls.__name__))
    for index, entry in enumerate(given if isinstance(given, (list, tuple)) else [given]):
        if not isinstance(entry, Parameter):
            text = "{}.PARAMETERS[{}]: {}, wanted a Parameter(name, default, ...)"
            raise TypeError(text.format(cls.__name__, index, shown(entry)))
        try:
            entry.checked(entry.default)
        except (ValueError, KeyError, TypeError) as error:
            text = "{}.PARAMETERS[{}]: the default does not fit: {}"
            raise TypeError(text.format(cls.__name__, index, error)) from None
        if entry.name in OWN or entry.name in SET_BY_ALL or hasattr(base, entry.name):
            text = "{}: a parameter may not be called {!r}, which PioneerControl uses"
            raise TypeError(text.format(cls.__name__, entry.name))
