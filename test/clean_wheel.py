"""The wheel in a clean virtual environment, without ROS and without the system's packages.

``python3 test/clean_wheel.py [--python PYTHON] [--no-pybullet] [SCENARIO ...]`` installs it, usually with
pybullet, and runs every shipped scenario, or those named, there and here; it prints how far the values of
``run.csv`` are apart, and ends with 1 where that is more than ``SMALL``.  Where a run is so sensitive that
a nudge of ``NUDGE`` moves it further, it is compared up to then.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
from recorded_values import NUDGE, SCENARIOS, SMALL, TAME, differing

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
OF_ROS = ("PYTHONPATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "PYTHONHOME")
MOST_SECONDS = 600.0  # of one step


class NoIndex(RuntimeError):
    """No package can be had from pip's index."""


class StepFailed(RuntimeError):
    """A step that ended with an error; the message holds its output."""


def without_ros():
    """Return the environment without what ROS and another virtual environment have put there."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("ROS_")}
    return {key: value for key, value in kept.items() if key not in OF_ROS}


def ran(*command, codes=(0,), cwd=None):
    """Run ``command`` without ROS and return what it printed; ``StepFailed`` for another exit code."""
    done = subprocess.run(
        [str(part) for part in command],
        cwd=None if cwd is None else str(cwd),
        env=without_ros(),
        timeout=MOST_SECONDS,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    text = done.stdout.decode(errors="replace")
    if done.returncode not in codes:
        raise StepFailed("{} ended with {}:\n{}".format(command, done.returncode, text[-3000:]))
    return text


class CleanEnvironment:
    """A virtual environment in ``directory`` that sees no other packages, with the wheel installed."""

    def __init__(self, directory, extra="", python=sys.executable):
        """``extra``: of the package, such as ``[dynamic]``.  Raises ``NoIndex`` and ``StepFailed``."""
        self.directory = str(directory)
        self.bin = os.path.join(self.directory, "environment", "bin")
        ran(python, "-m", "venv", os.path.dirname(self.bin))
        try:
            self.pip("install", "setuptools>=61", "wheel")
        except StepFailed as error:
            raise NoIndex(str(error).strip().rpartition("\n")[2]) from error
        self.wheel = self._built()
        begun = time.monotonic()
        self.pip("install", "--no-compile", self.wheel + extra)
        self.seconds = time.monotonic() - begun  # of the installation

    def pip(self, command, *arguments):
        """Run pip."""
        return ran(
            os.path.join(self.bin, "python"), "-m", "pip", "--disable-pip-version-check", command, "-q",
            *arguments,
        )  # fmt: skip

    def _built(self):
        """Return the path of the wheel, built from a copy: no earlier build has left anything there."""
        sources, target = (os.path.join(self.directory, name) for name in ("sources", "dist"))
        os.mkdir(sources)
        for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
            shutil.copy(os.path.join(ROOT, name), sources)
        for name in ("src", "scenarios", "docs"):
            ignored = shutil.ignore_patterns("__pycache__", "*.egg-info", "images")
            shutil.copytree(os.path.join(ROOT, name), os.path.join(sources, name), ignore=ignored)
        self.pip("wheel", "--no-deps", "--no-build-isolation", "-w", target, sources)
        (name,) = os.listdir(target)
        return os.path.join(target, name)

    def python(self, code):
        """Return what the Python ``code`` prints there."""
        return ran(os.path.join(self.bin, "python"), "-c", code, cwd=self.directory)

    def run(self, *arguments, codes=(0, 1)):
        """Return what ``mrs-simulator`` with ``arguments`` prints there."""
        return ran(
            os.path.join(self.bin, "mrs-simulator"), *arguments, codes=codes, cwd=self.directory
        )


def values(path):
    """Return the numbers of a run.csv, (rows, columns); the robots' kinds are left out."""
    with open(path, encoding="ascii") as file:
        header = file.readline().strip().split(",")
        rows = [line.strip().split(",") for line in file]
    numbers = [column for column, name in enumerate(header) if name != "kind"]
    return np.array([[row[column] for column in numbers] for row in rows], dtype=float)


def compared(there, here):
    """Return in words how far two run.csv files are apart, and whether that is little."""
    with open(there, "rb") as first, open(here, "rb") as second:
        if first.read() == second.read():
            return "the same bytes", True
    came, wanted = values(there), values(here)
    if came.shape != wanted.shape:
        return "{} values, wanted {}".format(came.shape, wanted.shape), False
    apart = np.max(np.abs(came - wanted) / np.maximum(1.0, np.abs(wanted)))
    return "{:.1e} apart".format(apart), not differing(came, wanted, SMALL).any()


def compared_while_tame(there, here, name, directory):
    """Return what ``compared`` does, of the samples before a nudge moves the run ``here``."""
    from mrs_simulator import load_scenario, run_experiment

    scenario = load_scenario(os.path.join(SCENARIOS, name))
    nudged = scenario._replace(poses=scenario.poses + NUDGE)
    run_experiment(nudged, directory, formats=())
    came, wanted, moved = map(values, (there, here, os.path.join(directory, "run.csv")))
    wild = differing(moved, wanted, TAME).any(axis=1)
    tame = int(np.argmax(wild)) if wild.any() else len(wild)
    said = "the same within {:g} until {:g} s, when a nudge of {:g} m moves it, too"
    near = tame > 0 and not differing(came[:tame], wanted[:tame], SMALL).any()
    return said.format(SMALL, wanted[tame - 1, 0], NUDGE) if near else "far apart", near


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO")
    parser.add_argument("--python", default=sys.executable, help="the interpreter there")
    parser.add_argument("--no-pybullet", action="store_true", help="for scenarios that need none")
    return parser.parse_args()


def main():
    """Compare the scenarios that the command line names, or all."""
    arguments = _arguments()
    names = arguments.scenarios or sorted(os.listdir(SCENARIOS))
    extra = "" if arguments.no_pybullet else "[dynamic]"
    with tempfile.TemporaryDirectory() as directory:
        clean = CleanEnvironment(directory, extra, arguments.python)
        size = os.path.getsize(clean.wheel) / 1e6
        print(
            clean.python("import sys, numpy; print(sys.version.split()[0], numpy.__version__)"),
            end="",
        )
        print("wheel {:.2f} MB, installed in {:.0f} s".format(size, clean.seconds), flush=True)
        far = []
        for name in names:
            there, here = (os.path.join(directory, place, name) for place in ("there", "here"))
            begun = time.monotonic()
            clean.run("experiment", name, "--out", there)
            seconds = time.monotonic() - begun
            command = [sys.executable, "-m", "mrs_simulator", "experiment", name, "--out", here]
            subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
            files = [os.path.join(out, "run.csv") for out in (there, here)]
            said, near = compared(*files)
            if not near:
                nudged = os.path.join(directory, "nudged", name)
                said, near = compared_while_tame(*files, name, nudged)
            far += [] if near else [name]
            print("{:34}{:5.1f} s  {}".format(name, seconds, said), flush=True)
    sys.exit(bool(far))


if __name__ == "__main__":
    main()
