"""Python package for catkin; use it through catkin, not on its own."""

import os

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

ROOT = os.path.dirname(os.path.abspath(__file__))
setup(
    **generate_distutils_setup(
        packages=find_packages(os.path.join(ROOT, "src")),
        package_dir={"": "src"},
        package_data={"mrs_simulator.vehicles": ["kinds/*"]},
    )
)
