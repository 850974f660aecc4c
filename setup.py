"""Python package for catkin; use it through catkin, not on its own."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

ROOMS = (
    "core",
    "core.protocols",
    "world",
    "world.robots",
    "control",
    "control.library",
    "report",
    "nodes",
    "rqt_plugin",
)

setup(
    **generate_distutils_setup(
        packages=["mrs_simulator"] + ["mrs_simulator." + room for room in ROOMS],
        package_dir={"": "src"},
        package_data={"mrs_simulator.world.robots": ["*.urdf"]},
    )
)
