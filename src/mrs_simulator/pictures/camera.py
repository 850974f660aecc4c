"""A pinhole camera that orbits a target."""

import functools
from typing import NamedTuple, Tuple

import numpy as np

FIELD_OF_VIEW = 40.0  # [deg] from bottom to top
NEAR = 0.02  # [m] in front of the eye: nearer things are not seen
STEEPEST, FLATTEST = -89.0, -3.0  # [deg] of pitch
NEAREST, FARTHEST = 0.2, 5000.0  # [m] from the target


class Camera(NamedTuple):
    """A view of ``target`` from ``distance``; from the south at yaw 0, from above at pitch -90 degrees."""

    target: Tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]
    distance: float = 10.0  # [m]
    yaw: float = 0.0  # [deg], about the vertical
    pitch: float = -40.0  # [deg]

    @property
    def axes(self):
        """Return the unit vectors (3, 3) of the picture: to the right, up, and away from the eye."""
        return _axes(self.yaw, self.pitch)

    @property
    def eye(self):
        """Return the camera's position (3,) [m]."""
        return np.asarray(self.target, dtype=float) - self.distance * self.axes[2]

    def turned(self, yaw, pitch):
        """Return the camera that has orbited its target by so many degrees."""
        pitch = min(FLATTEST, max(STEEPEST, self.pitch + pitch))
        return self._replace(yaw=(self.yaw + yaw + 180.0) % 360.0 - 180.0, pitch=pitch)

    def zoomed(self, factor):
        """Return the camera at ``factor`` times the distance."""
        return self._replace(distance=min(FARTHEST, max(NEAREST, self.distance * factor)))

    def panned(self, right, up, height):
        """Return the camera moved over the ground so that what is under the mouse follows it.

        By so many pixels in a picture ``height`` pixels high.
        """
        metres = self.distance / scale(height)
        axes = self.axes
        ahead = np.array([-axes[0, 1], axes[0, 0], 0.0]) / max(0.2, -axes[2, 2])
        target = np.asarray(self.target) - metres * (right * axes[0] + up * ahead)
        return self._replace(target=tuple(target.tolist()))

    def at(self, target):
        """Return the camera that looks at ``target`` (x, y, z) [m]."""
        return self._replace(target=tuple(float(each) for each in target))

    def seen(self, points):
        """Return ``points`` (..., 3) [m] in the camera's frame: right, up, and depth ahead [m]."""
        return (points - self.eye) @ self.axes.T

    def framed(self, points, width, height, room=1.0):
        """Return the camera, of the same direction, nearest to ``points`` (k, 3) that sees all of them.

        ``room``: the share of the picture's sides within which they are.
        Each of a picture's four sides is a plane through the eye, so the place of the eye follows from
        the farthest points beyond each.  The target is on the ground, where the camera looks down on it.
        """
        if not len(points):
            return self
        across, up, ahead = self._replace(target=(0.0, 0.0, 0.0), distance=0.0).seen(points).T
        slope = room * 0.5 * height / scale(height)
        slopes = slope * width / height, slope
        eye = np.empty(3)
        back = []
        for axis, (values, tangent) in enumerate(zip((across, up), slopes)):
            high, low = np.max(values - tangent * ahead), np.max(-values - tangent * ahead)
            eye[axis] = 0.5 * (high - low)
            back.append(0.5 * (high + low) / tangent)
        eye[2] = -max(back)
        for axis, (values, need) in enumerate(zip((across, up), back)):
            if need < max(back):
                eye[axis] = _centred(values, ahead - eye[2], eye[axis])
        place, forward = eye @ self.axes, self.axes[2]
        distance = max(NEAREST, -place[2] / forward[2] if forward[2] < 0.0 else 1.0)
        return self.at(place + distance * forward)._replace(distance=float(distance))


@functools.lru_cache(maxsize=8)
def _axes(yaw, pitch):
    yaw, pitch = np.radians([yaw, pitch])
    right = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    ahead = np.array([-np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)])
    axes = np.stack([right, np.cross(right, ahead), ahead])
    axes.flags.writeable = False  # it is shared
    return axes


def _centred(values, depth, start):
    """Return where an eye is that sees points at ``values`` (k,) across and ``depth`` (k,) as much to one
    side as to the other, [m]; ``start``: where it sees all of them."""
    for _ in range(8):
        slopes = (values - start) / depth
        low, high = np.argmin(slopes), np.argmax(slopes)
        # Both slopes fall by 1 / depth for each metre.
        start += (slopes[low] + slopes[high]) / (1.0 / depth[low] + 1.0 / depth[high])
    return start


def scale(height):
    """Return the pixels per metre at a depth of 1 m in a picture ``height`` pixels high."""
    return 0.5 * height / np.tan(np.radians(0.5 * FIELD_OF_VIEW))


def on_screen(seen, width, height):
    """Return where points ``seen`` (..., 3), all of them ahead, are in a picture, (..., 2) [px] from its
    upper left corner."""
    across, up, depth = np.moveaxis(seen, -1, 0)
    factor = scale(height) / depth
    return np.stack([0.5 * width + factor * across, 0.5 * height - factor * up], axis=-1)


def clipped_segments(seen, near=NEAR):
    """Return segments ``seen`` (m, 2, 3) cut off at the depth ``near``, and which of them are left (m,)."""
    depth = seen[:, :, 2]
    left = (depth > near).any(axis=1)
    result = seen.copy()
    for end in (0, 1):
        cut = left & (depth[:, end] < near)
        if cut.any():
            other = seen[cut, 1 - end]
            share = (near - other[:, 2]) / (depth[cut, end] - other[:, 2])
            result[cut, end] = other + share[:, np.newaxis] * (seen[cut, end] - other)
    return result[left], left


def clipped_polygon(seen, near=NEAR):
    """Return a convex polygon ``seen`` (k, 3) cut off at the depth ``near``; (0, 3) if it is nearer."""
    result = []
    for begin, end in zip(seen, np.roll(seen, -1, axis=0)):
        if begin[2] >= near:
            result.append(begin)
        if (begin[2] >= near) != (end[2] >= near):
            share = (near - begin[2]) / (end[2] - begin[2])
            result.append(begin + share * (end - begin))
    return np.array(result).reshape(-1, 3)
