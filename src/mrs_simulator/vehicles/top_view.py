"""A kind of robot from above: its outline and its wheels about its centre, x ahead, in metres."""

import numpy as np

CORNERS = 32  # [-] of the polygon of a round robot
TYRE = 0.5  # [-] width of a wheel over its radius


def outline(body):
    """Return the outline (k, 2) [m] of a ``Body``, a polygon."""
    if body.round:
        turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
        return body.front * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    side = 0.5 * body.width
    return np.array(
        [(body.front, side), (-body.rear, side), (-body.rear, -side), (body.front, -side)]
    )


def wheel_places(kind):
    """Return the centre (x, y) of each wheel, a list; empty where the drive has none."""
    numbers = kind.numbers
    across = getattr(numbers, "spacing", 0.0) or getattr(numbers, "track", 0.0)
    base = getattr(numbers, "wheelbase", 0.0)
    if not across:
        return []
    # Skid steers have the centre between their axles, cars on the rear one.
    skid = hasattr(numbers, "spacing")
    axles = (0.0,) if not base else (-0.5 * base, 0.5 * base) if skid else (0.0, base)
    return [(x, side * across) for x in axles for side in (0.5, -0.5)]
