"""The state of the robots at one time, as sensors read it."""

from mrs_simulator.state.state_table import StateTable


class State(StateTable):
    """True state of n robots, with what their wheels have rolled and what they touch."""

    def __init__(self, time, pose, twist, travel=(), contacts=(), **columns):
        """``travel``: (m, wheels) [m] of each group of the team; ``contacts``: names, place [m]."""
        super().__init__(time, pose=pose, twist=twist, **columns)
        self.travel, self.contacts = travel, contacts
