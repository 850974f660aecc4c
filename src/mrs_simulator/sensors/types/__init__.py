"""The types of sensors: one class each, which ``TYPES`` knows by name.

A type has ``QUANTITIES``, the SI unit of each quantity whose noise can be given, ``""`` where there is only
one; ``RATE`` [Hz] and ``NOISE`` by quantity, where nothing else is said; ``MODELS``, settings by name,
which a mount takes with ``model``; ``settings(section)``, which reads the type's own settings, hashable,
from a mount; and

    sensor = Type(mount, rows, team)            # of the robots in ``rows`` (m,), which have equal mounts
    reading = sensor.read(state, environment, rng)

where ``state`` is a ``State``, ``environment`` a ``Scenery`` and ``rng`` the ``noise.Draws`` of the sample.
A reading is a NamedTuple whose first field is ``stamp`` [s]; ``PER_ROBOT`` names its fields with a row for
each robot; one that has ``of(k)`` returns by it what its k-th robot has.

Optional are ``check(kind, where)``, which raises ``ScenarioError`` where robots of a kind cannot have the
sensor; ``LOOKS_BACK = True`` for one whose ``read`` takes a fourth argument, the ``State`` one step before;
``ALWAYS_READ = True`` for one that is read at all its samples, active or not; ``begin()``, which resets one
with a memory; ``SEES_ROBOTS = True`` for one whose values have a column for each robot of the team.
"""

from mrs_simulator.sensors.types.battery import Battery
from mrs_simulator.sensors.types.beacons import Beacons
from mrs_simulator.sensors.types.bumper import Bumper
from mrs_simulator.sensors.types.camera import Camera
from mrs_simulator.sensors.types.encoders import Encoders
from mrs_simulator.sensors.types.inertial import Altimeter, Compass, Imu
from mrs_simulator.sensors.types.laser import Laser
from mrs_simulator.sensors.types.position import Gps, MotionCapture
from mrs_simulator.sensors.types.range_bearing import RangeBearing
from mrs_simulator.sensors.types.sonar import Sonar

TYPES = {
    "altimeter": Altimeter,
    "battery": Battery,
    "beacons": Beacons,
    "bumper": Bumper,
    "camera": Camera,
    "compass": Compass,
    "encoders": Encoders,
    "gps": Gps,
    "imu": Imu,
    "laser": Laser,
    "motion_capture": MotionCapture,
    "range_bearing": RangeBearing,
    "sonar": Sonar,
}
