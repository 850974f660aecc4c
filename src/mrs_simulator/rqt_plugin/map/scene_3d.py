"""What the map shows, as a scene of three dimensions."""

import numpy as np

from mrs_simulator.pictures.scene import Scene


def scene_of(team, shades, trails, targets, edges, obstacles, numbered):
    """Return the ``Scene`` of a ``MapTeam``.

    ``shades``: a colour per robot; ``trails``: as of :func:`trails_of`; ``targets`` (n, 3) [m] or None;
    ``edges``: ``(i, j, weight)`` of robots' numbers; ``numbered``: whether numbers are shown.
    """
    rows = {number: row for row, number in enumerate(team.numbers)}
    return Scene(
        kinds=team.kinds(),
        state=team.state,
        shades=np.array([shade.getRgbF()[:3] for shade in shades]).reshape(-1, 3),
        load=team.load,
        trails=trails,
        targets=targets,
        edges=[(rows[i], rows[j]) for i, j, _ in edges if i in rows and j in rows],
        obstacles=obstacles,
        numbered=numbered,
    )


def trails_of(team, trails, hidden):
    """Return the robots' ``trails`` up to where they are now, (m, 3) [m] each; none of those ``hidden``."""
    now = np.column_stack([team.pose[:, :2], team.state.heights])
    paths = map(trails.path_in_space, range(len(now)))
    return tuple(
        np.concatenate([path, now[row : row + 1]])
        if len(path) and team.numbers[row] not in hidden
        else np.empty((0, 3))
        for row, path in enumerate(paths)
    )


def targets_of(team, targets, z):
    """Return ``targets`` (n, 2) at heights ``z`` (n,), None: the robots' own, as (n, 3) [m].

    None where there are none, or of another number of robots.
    """
    if targets is None or len(targets) != len(team.numbers):
        return None
    return np.column_stack([targets, team.state.heights if z is None else z])
