"""The fault matrix: which fault hits whom, how simulated time goes, and what the robots must do."""

from typing import NamedTuple

# What robots that drive straight on must do, told from their own motion.
GOES_ON = "go on"
STOPS = "stop"  # within LIMIT, and stay so
LANDS = "hover, then land"  # hover within LIMIT, and come down slowly some seconds later
COMES_BACK = "stop, then go on"  # stop while the fault lasts, move again after it
STANDS = "stand with time"  # simulated time stands still, and nobody moves in it
STANDS_THEN_GOES_ON = "stand with time, then go on"
ENDS = "end with the stage"  # the simulated world is gone
BEGINS_AGAIN = "begin again"  # a new world, in which they drive or stand
SAFE = "drive as commanded, or stand"

FREE, LOCKSTEP, WALL = "free", "lockstep", "real robots"
AIR, WATER = "free, in the air", "free, on the water"


class Row(NamedTuple):
    """One trial."""

    fault: str
    victim: str
    mode: str
    expected: str
    quick: bool = False  # whether it is among the tests of every day

    @property
    def name(self):
        """Return the trial's name."""
        return "{} {} ({})".format(self.fault, self.victim, self.mode)


def _both(fault, victim, free, lockstep=None, quick=()):
    return [
        Row(fault, victim, FREE, free, FREE in quick),
        Row(fault, victim, LOCKSTEP, lockstep or free, LOCKSTEP in quick),
    ]


ROWS = [
    *_both("kill", "stage", ENDS),
    *_both("freeze", "stage", STANDS_THEN_GOES_ON),
    *_both("restart", "stage", BEGINS_AGAIN),
    *_both("delay", "stage", STOPS, GOES_ON),
    *_both("duplicate", "stage", GOES_ON),
    *_both("reorder", "stage", GOES_ON, quick=(LOCKSTEP,)),
    *_both("drop half", "stage", GOES_ON),
    *_both("drop all", "stage", STOPS, STANDS, quick=(FREE,)),
    *_both("clock jump", "stage", SAFE),
    *_both("starve", "stage", GOES_ON),
    *_both("kill", "control", STOPS, STANDS),
    *_both("freeze", "control", COMES_BACK, STANDS_THEN_GOES_ON),
    *_both("restart", "control", COMES_BACK, STANDS_THEN_GOES_ON),
    *_both("delay", "control", GOES_ON),
    *_both("duplicate", "control", GOES_ON),
    *_both("reorder", "control", GOES_ON),
    *_both("drop half", "control", GOES_ON),
    *_both("drop all", "control", STOPS, STANDS),
    *_both("starve", "control", GOES_ON),
    *_both("kill", "recorder", GOES_ON),
    *_both("freeze", "recorder", GOES_ON),
    *_both("restart", "recorder", GOES_ON),
    *_both("full disk", "recorder", GOES_ON, quick=(FREE,)),
    *_both("starve", "recorder", GOES_ON),
    *_both("kill", "GUI", GOES_ON),
    *_both("freeze", "GUI", GOES_ON),
    *_both("restart", "GUI", GOES_ON),
    *_both("starve", "GUI", GOES_ON),
    *_both("kill", "master", GOES_ON, quick=(FREE,)),
    *_both("freeze", "master", GOES_ON),
    *_both("restart", "master", GOES_ON),
    *_both("no number", "stage", STOPS, STANDS),
    *_both("no number", "control", STOPS),
    Row("kill", "control", AIR, LANDS, quick=True),
    Row("freeze", "control", AIR, COMES_BACK),
    Row("drop all", "control", AIR, LANDS),
    Row("no height", "control", AIR, LANDS),
    Row("starve", "control", AIR, GOES_ON),
    Row("freeze", "stage", AIR, STANDS_THEN_GOES_ON),
    Row("delay", "stage", AIR, STOPS),
    Row("drop half", "stage", AIR, GOES_ON),
    Row("drop all", "stage", AIR, STOPS),
    Row("no height", "stage", AIR, STOPS),
    Row("starve", "stage", AIR, GOES_ON),
    Row("kill", "master", AIR, GOES_ON),
    Row("kill", "control", WATER, STOPS),
    Row("freeze", "control", WATER, COMES_BACK),
    Row("drop all", "control", WATER, STOPS),
    Row("no number", "control", WATER, STOPS),
    Row("freeze", "stage", WATER, STANDS_THEN_GOES_ON),
    Row("drop all", "stage", WATER, STOPS),
    Row("no number", "stage", WATER, STOPS),
    Row("kill", "driver", WALL, STOPS),
    Row("freeze", "driver", WALL, STOPS, quick=True),
    Row("restart", "driver", WALL, STOPS),
    Row("delay", "driver", WALL, STOPS),
    Row("duplicate", "driver", WALL, SAFE),
    Row("reorder", "driver", WALL, SAFE),
    Row("drop half", "driver", WALL, SAFE),
    Row("drop all", "driver", WALL, STOPS),
    Row("no number", "driver", WALL, STOPS),
    Row("starve", "driver", WALL, SAFE),
    Row("kill", "control", WALL, STOPS),
    Row("freeze", "control", WALL, STOPS),
    Row("restart", "control", WALL, COMES_BACK),
    Row("drop all", "control", WALL, STOPS),
    Row("starve", "control", WALL, SAFE),
    Row("kill", "master", WALL, GOES_ON),
    Row("freeze", "master", WALL, GOES_ON),
]
