"""Messages of packages that need not be installed, made from their definitions.

Their names and checksums are those of the packages: nodes that have these read what is published here.
"""

from genpy.dynamic import generate_dynamic

_RULE = "\n{}\nMSG: ".format(80 * "=")
_HEADER = _RULE + "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id"
_BUMPERS = "Header header\nbool[] front_bumpers\nbool[] rear_bumpers" + _HEADER
_SONARS = "Header header\nint32 ranges_count\nfloat64[] ranges" + _HEADER
_VOLTAGE = "Header header\nfloat32 voltage" + _HEADER
_LEVELS = "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
_STATUS = "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values"
_DIAGNOSTICS = (
    "Header header\nDiagnosticStatus[] status"
    + _HEADER
    + _RULE
    + "diagnostic_msgs/DiagnosticStatus\n"
    + _LEVELS
    + _STATUS
    + _RULE
    + "diagnostic_msgs/KeyValue\nstring key\nstring value"
)


def _defined(name, text):
    """Return the classes of the message ``name`` and of those within it, by name."""
    return generate_dynamic(name, text + "\n")


BumperState = _defined("rosaria/BumperState", _BUMPERS)["rosaria/BumperState"]
SonarArray = _defined("p2os_msgs/SonarArray", _SONARS)["p2os_msgs/SonarArray"]
P2osBattery = _defined("p2os_msgs/BatteryState", _VOLTAGE)["p2os_msgs/BatteryState"]
_diagnostics = _defined("diagnostic_msgs/DiagnosticArray", _DIAGNOSTICS)
DiagnosticArray = _diagnostics["diagnostic_msgs/DiagnosticArray"]
DiagnosticStatus = _diagnostics["diagnostic_msgs/DiagnosticStatus"]
KeyValue = _diagnostics["diagnostic_msgs/KeyValue"]
