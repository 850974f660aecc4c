"""Runs a script of Python in a network namespace: python3 on_host.py NAMESPACE SCRIPT ARGUMENT ..."""

import ctypes
import os
import runpy
import sys

NAMES = "/run/netns"  # where ``ip netns`` keeps them
NETWORK = 0x40000000  # CLONE_NEWNET

with open(os.path.join(NAMES, sys.argv[1])) as namespace:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.setns(namespace.fileno(), NETWORK) != 0:
        sys.exit("{}: {}".format(namespace.name, os.strerror(ctypes.get_errno())))
del sys.argv[:2]
sys.path[0] = os.path.dirname(sys.argv[0])
runpy.run_path(sys.argv[0], run_name="__main__")
