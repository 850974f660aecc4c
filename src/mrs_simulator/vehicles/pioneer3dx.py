"""Pioneer 3-DX: a differential-drive robot with two driven wheels and a rear caster.

``pioneer3dx.urdf`` beside this file carries the same numbers; a test holds the two together.
"""

import math
import os

from mrs_simulator.core.kinematics import Limits

URDF = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pioneer3dx.urdf")

# ARIA parameter file of the P3-DX: robot width, and centre of rotation to the front and rear ends.
WIDTH = 0.425  # [m]
FRONT = 0.210  # [m]
REAR = 0.301  # [m]
LENGTH = FRONT + REAR  # [m]
HEIGHT = 0.237  # [m], data sheet
# ARIA parameter file: 2/DiffConvFactor, the track with which the firmware turns wheel speeds into a
# turn rate.  The model's wheels stand at this track, so that commanded and true turn rate agree.
WHEEL_TRACK = 0.357  # [m]
WHEEL_RADIUS = 0.09  # [m], public URDF models of the robot
MASS = 9.0  # [kg], data sheet, bare robot with one battery

# ARIA parameter file: absolute maxima.
V_ABSOLUTE_MAX = 2.2  # [m/s]
OMEGA_ABSOLUTE_MAX = math.radians(500.0)  # [rad/s]
# Factory settings of the firmware (P2OS/ARCOS).
FIRMWARE_LIMITS = Limits(
    v_max=0.75,  # [m/s]
    omega_max=math.radians(100.0),  # [rad/s]
    v_accel=0.3,  # [m/s^2]
    omega_accel=math.radians(100.0),  # [rad/s^2]
)
# The highest settings that the firmware accepts.
TOP_LIMITS = Limits(
    v_max=1.5,  # [m/s]
    omega_max=math.radians(360.0),  # [rad/s]
    v_accel=2.0,  # [m/s^2]
    omega_accel=math.radians(300.0),  # [rad/s^2]
)

# The model's contact with the ground; the caster has none to speak of.
WHEEL_FRICTION = 0.9  # [-] rubber on a laboratory floor
WHEEL_SPIN_FRICTION = 0.001  # [m] a tyre's patch of contact resists turning on the spot a little
WHEEL_TORQUE = 6.0  # [N m] at a wheel, enough for the top acceleration with room to spare
WHEEL_JOINTS = ("left_wheel_joint", "right_wheel_joint")
CASTER_LINK = "caster"
