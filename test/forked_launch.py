"""roslaunch, whose nodes that are Python's are forks of this process, as ``forked`` makes them."""

import shutil
import subprocess
import sys
import types

from forked import OwnForker

FORKS = OwnForker()  # before there are threads

import roslaunch.nodeprocess  # noqa: E402


def popen(command, cwd, stdout, stderr, env, **given):
    """Do what ``subprocess.Popen`` does; what Python runs is forked."""
    with open(shutil.which(command[0]), "rb") as file:
        is_python = b"python" in file.readline(200)
    streams = dict(cwd=cwd, stdout=stdout, stderr=stderr, env=env)
    if is_python:
        return FORKS.popen([sys.executable, *command], start_new_session=True, **streams)
    return subprocess.Popen(command, **streams, **given)


roslaunch.nodeprocess.subprocess = types.SimpleNamespace(**dict(vars(subprocess), Popen=popen))
roslaunch.main()
