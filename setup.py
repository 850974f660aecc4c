"""Packages and data of mrs_simulator: read by catkin, and by pip together with pyproject.toml."""

import os
import shutil

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

ROOT = os.path.dirname(os.path.abspath(__file__))
SCENARIOS, DOCS = "scenarios", "docs"
# What these tell of is not installed: the tests, and the benchmarks whose tables they are.
OF_THE_REPOSITORY = "development.md", "agreement.md", "agreement_dynamic.md"


def version():
    """Return the version in ``src/mrs_simulator/version.py``."""
    content = {}
    with open(os.path.join(ROOT, "src", "mrs_simulator", "version.py"), encoding="utf-8") as file:
        exec(file.read(), content)
    return content["__version__"]


class BuildWithScenarios(build_py):
    """Puts scenarios and pages, which lie beside ``src``, into the installed package."""

    def run(self):
        """Build the package, then copy both; an editable install finds them where they are."""
        if getattr(self, "editable_mode", False):
            super().run()
            return
        # What an earlier build left there may have gone from the sources.
        shutil.rmtree(os.path.join(self.build_lib, "mrs_simulator"), ignore_errors=True)
        super().run()
        target = os.path.join(self.build_lib, "mrs_simulator", SCENARIOS)
        os.makedirs(target, exist_ok=True)
        for name in sorted(os.listdir(os.path.join(ROOT, SCENARIOS))):
            if name.endswith(".yaml"):
                shutil.copyfile(os.path.join(ROOT, SCENARIOS, name), os.path.join(target, name))
        self._copy_pages(os.path.join(self.build_lib, "mrs_simulator", DOCS))

    def _copy_pages(self, target):
        """Copy the pages for users, without their pictures."""
        for folder in (DOCS, os.path.join(DOCS, "protocols")):
            there = os.path.join(target, os.path.relpath(folder, DOCS))
            os.makedirs(there, exist_ok=True)
            for name in sorted(os.listdir(os.path.join(ROOT, folder))):
                if name.endswith(".md") and name not in OF_THE_REPOSITORY:
                    shutil.copyfile(os.path.join(ROOT, folder, name), os.path.join(there, name))


setup(
    name="mrs_simulator",
    version=version(),
    license="BSD-3-Clause",
    packages=find_packages(os.path.join(ROOT, "src")),
    package_dir={"": "src"},
    package_data={"mrs_simulator.vehicles": ["kinds/*"]},
    options={
        "build": {"build_base": os.path.join("build", "wheel")}
    },  # not into catkin's own files
    cmdclass={"build_py": BuildWithScenarios},
)
