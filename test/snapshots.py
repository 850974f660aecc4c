"""States of a team as the GUI shows them."""

import numpy as np

from mrs_simulator.state.state_table import StateTable


def snapshot_of(time, robots, pose, twist, command, fresh, real=(), **more):
    """Return the ``StateTable`` of ``robots`` at ``time`` [s]; ``real``: the numbers of real ones."""
    columns = {"pose": pose, "twist": twist, "command": command, "fresh": fresh}
    flags = np.array([number in real for number in robots], dtype=bool)
    return StateTable(time, robots, **columns, real=flags, **more)
