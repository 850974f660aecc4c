"""Those points of trails that a picture needs."""

import numpy as np

MOST_NEAR, MOST_FAR = 12000, 4000  # [-] points of all trails of robots near to the target, and far
NEAR = 1.5  # [-] of the camera's distance from its target


def shown_trails(scene, view):
    """Return the trails of ``scene``, (k, 3) [m] each, thinned to what is seen in ``view``.

    Near to the camera's target they are finer.  But for the last one their points stay where they are.
    """
    held = np.array([len(trail) for trail in scene.trails])
    away = np.linalg.norm(scene.place - view.eye, axis=1)[: len(held)]
    near = away < NEAR * view.camera.distance
    strides = np.ones(len(held), dtype=int)
    for chosen, most in ((near, MOST_NEAR), (~near, MOST_FAR)):
        strides[chosen] = _stride(held[chosen].sum() / most)
    pairs = zip(scene.trails, strides.tolist())
    return [np.concatenate([t[:-1:s], t[-1:]]) if s > 1 and len(t) else t for t, s in pairs]


def _stride(share):
    """Return a power of two, of at least ``share``, since points that jump to and fro would be seen."""
    return 1 if share <= 1.0 else int(2 ** np.ceil(np.log2(share)))
