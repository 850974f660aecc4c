"""Animations of a run: robots, their trails and the edges of their graph, as GIF, MP4 or moving SVG.

Axes and what stands are drawn once; each frame adds what moves, obstacles on their tracks too.
"""

import base64
import io
import os
import shutil
import tempfile

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from mrs_simulator.core.writing import write_bytes
from mrs_simulator.study.draw.canvas import new_figure, settle, styled
from mrs_simulator.study.draw.figure_parts import robot_colours
from mrs_simulator.study.draw.plane_figure import (
    draw_ground,
    move,
    robot_length,
    robot_shapes,
    trajectories_height,
)
from mrs_simulator.study.draw.style import LookError

SUFFIXES = (".gif", ".mp4", ".svg")
WANTED = "wanted a file .gif, .svg or .mp4"
FROM_ABOVE = "an SVG moves seen from above alone; wanted a file .gif or .mp4"
WIDTH = 4.8  # [in]
DPI = 100
RATE = 12.0  # [Hz] frames of a file
SECONDS = 8.0  # of a file
MOST_FRAMES = 2000
COLOURS = 64  # of a GIF
PALE = 246  # of 255: what is as bright becomes white
ENLARGED = 1.6  # [-] robots against those of figures, which have finer pixels
TRAIL = 0.25  # [-] share of the run that a trail shows
MOST_EDGES = 400  # above it edges would hide the robots


class Animation:
    """A run in motion: ``save(path)``, and shown by itself in a notebook."""

    def __init__(self, run, seconds=SECONDS, rate=RATE, width=WIDTH, stage=None):
        """``run``: a ``Run``; the file lasts ``seconds`` at ``rate`` [Hz] and is ``width`` [in] wide.

        ``stage``: what draws it, of the run and the width: by default ``Stage``, from above.  Raises
        ``LookError`` for numbers that make no animation.
        """
        frames = int(round(seconds * rate)) if 0.0 < seconds * rate <= MOST_FRAMES else 0
        if frames < 1 or not len(run.time):
            text = "an animation of {:g} s at {:g} Hz, of {} samples: wanted from 1 to {} frames"
            raise LookError(text.format(seconds, rate, len(run.time), MOST_FRAMES))
        self.run, self.rate, self.width, self._stage = run, rate, width, stage or Stage
        last = len(run.time) - 1
        self.rows = np.unique(np.linspace(0, last, frames).round().astype(int))

    def save(self, path):
        """Write the animation to ``path``, ``.gif`` or ``.svg``, or ``.mp4`` by ffmpeg; return the path."""
        suffix = os.path.splitext(path)[1]
        if suffix not in SUFFIXES:
            raise LookError("{}: {}".format(path, WANTED))
        if suffix == ".mp4":
            need_ffmpeg(path)
            return self._save_film(path)
        write_bytes(path, self.gif() if suffix == ".gif" else self.svg())
        return path

    def svg(self):
        """Return the bytes of an SVG that moves in a browser, from above alone."""
        from mrs_simulator.study.draw.moving_svg import moving_svg

        if self._stage is not Stage:
            raise LookError("an animation in space: " + FROM_ABOVE)
        return moving_svg(Stage(self.run, self.width), self.rows, len(self.rows) / self.rate)

    def gif(self):
        """Return the bytes of a GIF that begins anew at its end."""
        first, *others = _with_few_colours([frame[:, :, :3] for frame in self.frames()])
        image = io.BytesIO()
        first.save(
            image,
            "GIF",
            save_all=True,
            append_images=others,
            duration=int(round(1000.0 / self.rate)),
            loop=0,
            optimize=False,
            disposal=1,
        )
        return image.getvalue()

    def _repr_html_(self):
        text = base64.b64encode(self.gif()).decode("ascii")
        return '<img src="data:image/gif;base64,{}" alt="The run in motion">'.format(text)

    def _save_film(self, path):
        import matplotlib
        from matplotlib.animation import FFMpegWriter

        stage = self._stage(self.run, self.width)
        # ffmpeg writes to a file of its own, so that ``path`` is whole or not there.
        with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(path))) as directory:
            partial = os.path.join(directory, "film.mp4")
            writer = FFMpegWriter(fps=self.rate)
            white = matplotlib.rc_context({"savefig.facecolor": "white"})
            with white, writer.saving(stage.figure, partial, DPI):
                for row in self.rows:
                    stage.show(row)
                    writer.grab_frame()
            os.replace(partial, path)
        return path

    def frames(self):
        """Yield the frames, each (height, width, 4) uint8."""
        stage = self._stage(self.run, self.width)
        for row in self.rows:
            yield stage.picture(row)


class Stage:
    """The axes, and the artists that move on them."""

    @styled
    def __init__(self, run, width=WIDTH, figure=None):
        """Draw what stands still on ``figure``, by default a new one ``width`` [in] wide."""
        self.run = run
        height = trajectories_height(run, page=width)
        self.figure = new_figure(width, height) if figure is None else figure
        self.figure.set_dpi(DPI)
        self.axes = self.figure.add_subplot(1, 1, 1)
        low, high, self.carts = draw_ground(self.axes, run)
        # [s] on the tracks of obstacles, as the run begins
        self.begun = run.meta.get("scene_time", 0.0)
        self.length = ENLARGED * robot_length(run.pose[-1, :, :2], np.max(high - low))
        colours = self.colours = robot_colours(run.robots)
        self._edges = LineCollection([], colors="#b8c4d0", linewidths=0.8, zorder=1.5)
        self._trails = LineCollection([], colors=colours, linewidths=1.4, alpha=0.6, zorder=2)
        self._robots = PolyCollection([], facecolors=colours, edgecolors="white", linewidths=0.4)
        self._robots.set_zorder(4)
        self._clock = self.axes.text(0.02, 0.97, "", transform=self.axes.transAxes, va="top")
        collections = self._edges, self._trails, self._robots
        for artist in collections:
            self.axes.add_collection(artist, autolim=False)
        self.moving = (*(patch for _, patch in self.carts), *collections, self._clock)
        settle(self.figure)
        self.pairs = _pairs(run)
        self._behind = max(1, int(TRAIL * len(run.time)))
        self._still = None

    def show(self, row):
        """Move the artists to sample ``row`` of the run; return them."""
        pose = self.run.pose
        points = pose[row, :, :2]
        begin = max(0, row - self._behind)
        chosen = np.unique(np.linspace(begin, row, min(row - begin + 1, 200)).astype(int))
        self._trails.set_segments(list(pose[chosen, :, :2].transpose(1, 0, 2)))
        self._robots.set_verts(robot_shapes(points, pose[row, :, 2], self.length))
        if self.pairs is not None:
            # Between the points that the law moves, in front of wheels' axles.
            self._edges.set_segments(list(self.run.hand[row, :, :2][self.pairs]))
        move(self.carts, self.begun + float(self.run.time[row]))
        self._clock.set_text("{:.1f} s".format(self.run.time[row]))
        return self.moving

    @styled
    def picture(self, row):
        """Return sample ``row`` as (height, width, 4) uint8."""
        canvas = self.figure.canvas
        if self._still is None:
            for artist in self.moving:
                artist.set_animated(True)
            canvas.draw()
            self._still = canvas.copy_from_bbox(self.figure.bbox)
        canvas.restore_region(self._still)
        for artist in self.show(row):
            self.axes.draw_artist(artist)
        return np.array(canvas.buffer_rgba())


def _pairs(run):
    """Return the rows (m, 2) of robots that an edge joins; None where there are none, or too many."""
    topology = run.scenario.topology if run.scenario is not None else None
    if topology is None or not 0 < len(topology.arcs[0]) <= MOST_EDGES:
        return None
    return np.stack([topology.arcs[0], topology.arcs[1]], axis=1)


def _with_few_colours(pictures):
    """Return ``pictures`` as images of one palette, each (height, width, 3) uint8 before."""
    from PIL import Image  # comes with matplotlib

    images = [Image.fromarray(picture) for picture in pictures]
    tall = np.concatenate([pictures[0], pictures[len(pictures) // 2], pictures[-1]])
    palette = Image.fromarray(tall).quantize(COLOURS, dither=0)
    colours = np.array(palette.getpalette()[: 3 * COLOURS]).reshape(-1, 3)
    colours[colours.min(axis=1) >= PALE] = 255  # the ground is white, not a mean of pale colours
    palette.putpalette(colours.ravel().tolist())
    return [image.quantize(palette=palette, dither=0) for image in images]


def has_ffmpeg():
    """Return whether films can be written."""
    return shutil.which("ffmpeg") is not None


def need_ffmpeg(path):
    """Raise ``LookError`` where the film ``path`` cannot be written."""
    if not has_ffmpeg():
        raise LookError("{}: ffmpeg is not installed; wanted it, or a file .gif".format(path))
