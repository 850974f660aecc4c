"""The types of sensors: each ``Sensor`` of this folder with a ``TYPE``.

``sensor.py`` says what a type has.  A reading is a NamedTuple: ``PER_ROBOT`` names its fields with a row
for each robot, ``text()`` returns it in words, and ``of(k)``, if there is one, that of the k-th robot.
"""

from mrs_simulator.core.discovery import classes_in
from mrs_simulator.sensors.types.sensor import Sensor

TYPES = dict(sorted((each.TYPE, each) for each in classes_in(__name__, Sensor) if each.TYPE))
