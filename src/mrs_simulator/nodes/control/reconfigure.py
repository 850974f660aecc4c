"""dynamic_reconfigure for any protocol, made from the protocol's own parameter description."""

import uuid

import rospy
from dynamic_reconfigure.server import Server

from mrs_simulator.ros.node.node_parameters import CONTROL, NODES

WRITTEN = "written_parameters"  # which values on the parameter server a controller wrote
WIDEST = 1e9  # dynamic_reconfigure wants finite bounds; this stands for none
_TYPES = {float: "double", int: "int", bool: "bool", str: "str"}


class TellingServer(Server):
    """A server that says which values it moved into their range: clients are not notified.

    Parameters of the node itself are not taken for the law's of the same name, such as ``speed``.
    Nor are the values that a controller before wrote, which would replace the scenario's: the
    parameter server keeps them for as long as the master runs.
    """

    _OWN = frozenset(parameter.name for parameter in NODES[CONTROL])

    def _copy_from_parameter_server(self):
        begun = dict(self.config)
        super()._copy_from_parameter_server()
        self.config.update((name, begun[name]) for name in self._OWN.intersection(begun))
        self._writer, left = uuid.uuid4().hex, rospy.get_param(self.ns + WRITTEN, {})
        written, given = left.get("values", {}), left.get("given", {})
        for name in set(self.config).intersection(written):
            if self.config[name] == written[name]:
                self.config[name] = given.get(name, begun[name])
        # What users give, such as with <param> in a launch file, goes before the scenario.
        self._given = {n: v for n, v in self.config.items() if n in given or v != begun[n]}

    def _copy_to_parameter_server(self):
        names = set(self.config).intersection(self.type.defaults) - self._OWN
        values = {name: self.config[name] for name in sorted(names)}
        for name, value in values.items():
            rospy.set_param(self.ns + name, value)
        record = {"writer": self._writer, "values": values, "given": self._given}
        rospy.set_param(self.ns + WRITTEN, record)

    def withdraw(self):
        """Leave on the parameter server what users gave, unless another controller has begun."""
        record = rospy.get_param(self.ns + WRITTEN, {})
        if record.get("writer") != self._writer:
            return
        for name in record["values"]:
            if name in self._given:
                rospy.set_param(self.ns + name, self._given[name])
            elif rospy.has_param(self.ns + name):
                rospy.delete_param(self.ns + name)
        rospy.delete_param(self.ns + WRITTEN)

    def _clamp(self, config):
        asked = dict(config)
        super()._clamp(config)
        for name, value in config.items():
            if name in self.type.min and value != asked.get(name, value):
                text = "pioneer_control: %s = %s is out of range: %s is taken, wanted from %s to %s"
                bounds = self.type.min[name], self.type.max[name]
                rospy.logerr(text, name, asked[name], value, *bounds)


class ParameterServer:
    """Offers a control's parameters to rqt_reconfigure and dynparam while it runs."""

    def __init__(self, control):
        """Serve ``control.PARAMETERS`` from their present values."""
        self._control = control
        self._server = TellingServer(_config_type(control), self._on_change)

    def show(self):
        """Notify the clients of what is in force after a change from elsewhere."""
        self._server.update_configuration({})

    def close(self):
        """Take back from the parameter server what was written to it."""
        self._server.withdraw()

    def _on_change(self, config, level):
        if level:  # something is to be changed, not only shown
            self._set(config)
        # What is in force goes back to the caller, so that a refusal shows.
        config.update(self._control.parameters)
        return config

    def _set(self, config):
        names = [parameter.name for parameter in self._control.PARAMETERS]
        try:
            self._control.set_parameters({name: config[name] for name in names})
        except ValueError as error:
            rospy.logerr("pioneer_control: refused: %s", error)


def _config_type(control):
    """Return an object with what ``Server`` reads of a generated configuration module."""
    described = [_described(parameter, control.parameters) for parameter in control.PARAMETERS]

    class ConfigType:
        defaults = {entry["name"]: entry["default"] for entry in described}
        min = {entry["name"]: entry["min"] for entry in described}
        max = {entry["name"]: entry["max"] for entry in described}
        level = {entry["name"]: entry["level"] for entry in described}
        type = {entry["name"]: entry["type"] for entry in described}
        config_description = {
            "name": "Default",
            "type": "",
            "state": True,
            "cstate": "true",
            "id": 0,
            "parent": 0,
            "parameters": described,
            "groups": [],
            "upper": "DEFAULT",
            "lower": "groups",
            "class": "Default",
            "parentclass": "",
            "parentname": "Default",
            "field": "default",
        }

    return ConfigType


def _described(parameter, values):
    kind = type(parameter.default)
    unit = " [{}]".format(parameter.unit) if parameter.unit else ""
    return {
        "name": parameter.name,
        "type": _TYPES[kind],
        "default": values[parameter.name],
        "min": _bound(kind, parameter.low, -WIDEST),
        "max": _bound(kind, parameter.high, WIDEST),
        "level": 1,
        "description": parameter.meaning + unit,
        "edit_method": _choice_method(parameter.choices),
        "srcline": 0,
        "srcfile": "",
        "cconsttype": "",
        "ctype": "",
    }


def _bound(kind, given, otherwise):
    if kind is bool:
        return otherwise > 0
    if kind is str:
        return ""
    return kind(otherwise if given is None else given)


def _choice_method(choices):
    if not choices:
        return ""
    entries = [
        {
            "name": choice,
            "value": choice,
            "type": "str",
            "description": choice,
            "ctype": "",
            "cconsttype": "",
            "srcline": 0,
            "srcfile": "",
        }
        for choice in choices
    ]
    return str({"enum": entries, "enum_description": "one of " + ", ".join(choices)})
