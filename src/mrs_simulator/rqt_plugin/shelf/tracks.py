"""A few of a run's positions, read fast from a file of any size; without Qt and ROS."""

import os

import numpy as np

SAMPLES = 80  # [-] read of a run, evenly from its file
MOST_ROBOTS = 60  # [-] whose positions are read
COLUMNS = ("time", "robot", "x", "y")
LONGEST_LINE = 1 << 16  # [bytes]


def tracks_of(path, samples=SAMPLES):
    """Return ``{number: (m, 2) [m]}``, positions of robots at about ``samples`` times of a ``run.csv``.

    The first and the last sample are among them.  Raises ``OSError`` and ``ValueError``.
    """
    with open(path, "rb") as file:
        names = file.readline(LONGEST_LINE).decode("utf-8").rstrip("\n").split(",")
        if not set(COLUMNS) <= set(names):
            raise ValueError("{}: no columns {}".format(path, ", ".join(COLUMNS)))
        places = [names.index(name) for name in COLUMNS]
        begin, size = file.tell(), os.path.getsize(path)
        block = _first_sample(file, places)
        starts = np.linspace(begin, max(begin, size - int(1.5 * block)), samples)
        rows = {}
        for start in np.unique(starts.astype(int)).tolist():
            file.seek(start)
            if start > begin:
                file.readline()  # the rest of a line
            for time, robot, x, y in _lines(file.read(2 * block), places):
                rows[time, robot] = x, y
    found = {}
    for (_, robot), place in sorted(rows.items()):
        found.setdefault(robot, []).append(place)
    return {int(robot): np.array(track) for robot, track in sorted(found.items())}


def _first_sample(file, places):
    """Return the size [bytes] of the first sample, all of its robots' lines, as far as they are read."""
    size, first = 0, None
    for line in iter(lambda: file.readline(LONGEST_LINE), b""):
        parts = line.split(b",", max(places) + 1)
        first = parts[places[0]] if first is None else first
        if len(parts) <= max(places) or parts[places[0]] != first:
            break
        size += len(line)
    return max(size, 1)


def _lines(content, places):
    """Return what stands in the whole lines of ``content``: time, robot, x and y, of the first robots."""
    for line in content.split(b"\n")[:-1]:
        parts = line.split(b",", max(places) + 1)
        if len(parts) > max(places):
            time, robot, x, y = (float(parts[place]) for place in places)
            if robot <= MOST_ROBOTS:
                yield time, robot, x, y
