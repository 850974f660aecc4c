"""The projection of a camera onto a picture of a given size."""

import numpy as np

from mrs_simulator.pictures.camera import clipped_segments, on_screen, scale
from mrs_simulator.pictures.drawing import Lines, Texts

LIGHT_FROM = (-0.5, -0.6, 1.0)  # right, ahead over the ground, up: from behind the left shoulder


class View:
    """Projects points of the common frame into the primitives of a ``Drawing``."""

    def __init__(self, camera, width, height, palette):
        self.camera = camera
        self.width = int(width)
        self.height = int(height)
        self.palette = palette
        self._axes, self.eye = camera.axes, camera.eye
        self.scale = scale(self.height)  # [px] of 1 m at a depth of 1 m
        ahead = np.array([-self._axes[0, 1], self._axes[0, 0], 0.0])
        light = LIGHT_FROM[0] * self._axes[0] + LIGHT_FROM[1] * ahead + (0.0, 0.0, LIGHT_FROM[2])
        self.light = light / np.linalg.norm(light)  # the direction it comes from, common frame

    def seen(self, points):
        """Return ``points`` (..., 3) [m] in the camera's frame: right, up, depth [m]."""
        return (np.asarray(points, dtype=float) - self.eye) @ self._axes.T

    def screen(self, seen):
        """Return where points ``seen`` (..., 3), all of them ahead, are in the picture, (..., 2) [px]."""
        return on_screen(seen, self.width, self.height)

    def lines(self, segments, colours, width):
        """Return ``segments`` (m, 2, 3) [m] in ``colours`` (m, 4) as ``Lines``; None where none is ahead.

        Segments that are not finite are left out.
        """
        known = np.isfinite(segments).all(axis=(1, 2))
        seen, left = clipped_segments(self.seen(segments[known]))
        if not len(seen):
            return None
        return Lines(self.screen(seen), colours[known][left], width)

    def texts(self, places, texts, left=False):
        """Return ``texts`` at ``places`` (m, 2) [px]."""
        colour, halo = (*self.palette.text, 1.0), (*self.palette.halo, 0.75)
        return Texts(places, texts, colour, halo, left)
