#!/usr/bin/env python3
"""Make the moving picture of the first page, docs/images/teams.gif: python3 docs/make_film.py [FILE]

Runs three scenarios and draws them in space, each with the outcome of its verdict; the last fails, with
its reason.
"""

import io
import os
import sys
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image  # comes with matplotlib

from mrs_simulator import simulate
from mrs_simulator.core.writing import write_bytes
from mrs_simulator.pictures.camera import Camera
from mrs_simulator.pictures.palette import LIGHT
from mrs_simulator.study.draw.paint import DPI, paint
from mrs_simulator.study.draw.space_film import Film

DOCS = os.path.dirname(os.path.abspath(__file__))
WIDTH, HEIGHT, STRIP = 576, 328, 50  # [px] of a frame, and of the text below the team
FRAMES, HELD = 26, 18  # [-] frames of a run, and pictures for which its verdict is shown
PERIOD = 100  # [ms] of a frame
COLOURS = 64
INK, PASSED, FAILED = "#1d2733", "#1a7f37", "#c62828"


class Act(NamedTuple):
    """A run, the part of it that is shown, and from where."""

    scenario: str
    changes: dict
    until: float  # [-] share of the run
    camera: tuple  # of its begin and its end: yaw, pitch [deg], distance [m], all from the team's middle
    height: float  # [m] above the ground that it looks at
    says: str  # what the law does
    reason: str  # how the name of the check begins that is shown


ACTS = (
    Act(
        "carrying.yaml", {}, 1.0, ((55.0, -20.0, 5.2), (-50.0, -22.0, 6.2)), 0.4,
        "Three arms on wheels carry a beam", "largest internal force",
    ),
    Act(
        "shore.yaml", {}, 0.8, ((45.0, -26.0, 17.0), (5.0, -16.0, 13.0)), 0.0,
        "One law on land, on water and in the air", "decay rate of the error",
    ),
    Act(
        "crazyflies_cube.yaml",
        dict(fidelity="dynamic", events=[{"at": 9.0, "robot": 5, "event": "rotor_lost", "rotor": 1}]),
        0.5, ((0.0, -16.0, 6.8), (50.0, -14.0, 6.4)), 1.05,
        "A cube of quadrotors, until one loses a rotor", "collisions",
    ),
)  # fmt: skip


def main():
    """Write the picture to the file that the command line names, or to its place."""
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(DOCS, "images", "teams.gif")
    frames = [frame for act in ACTS for frame in frames_of(act)]
    write_bytes(path, gif(frames))
    print("{}: {} frames, {:.0f} KB".format(path, len(frames), os.path.getsize(path) / 1e3))


def frames_of(act):
    """Yield the frames of ``act``, ``(picture, duration [ms])``, the last held with the verdict."""
    study = simulate(act.scenario, **act.changes)
    line = judged(study.verdict, act.reason)
    film = Film(study.run)
    rows = np.linspace(0, act.until * (len(study.run.time) - 1), FRAMES).round().astype(int)
    views = np.linspace(*act.camera, FRAMES)
    for place, (row, (yaw, pitch, distance)) in enumerate(zip(rows, views)):
        last = place == FRAMES - 1
        target = *study.run.pose[row, :, :2].mean(axis=0).tolist(), act.height
        scene = film.drawing(row, WIDTH, HEIGHT - STRIP, Camera(target, distance, yaw, pitch))
        text = (line, study.passed) if last else ("mrs-simulator experiment " + act.scenario, None)
        yield frame(scene, act.says, *text), PERIOD * (HELD if last else 1)


def judged(verdict, name):
    """Return what the ``verdict`` says of its check ``name``."""
    (check,) = (each for each in verdict["checks"] if each["name"].startswith(name))
    values = (
        "{:.3g}".format(each) if isinstance(each, float) else each
        for each in (check["predicted"], check["measured"])
    )
    text = "{}: predicted {}, measured {}".format(check["name"], *values)
    return text if check["passed"] else "{} ({})".format(text, check["note"])


def frame(drawing, says, line, passed):
    """Return the picture (HEIGHT, WIDTH, 3) uint8 of a ``drawing`` above two lines of text."""
    figure = Figure(figsize=(WIDTH / DPI, HEIGHT / DPI), dpi=DPI, facecolor="white")
    canvas, share = FigureCanvasAgg(figure), STRIP / HEIGHT
    paint(figure.add_axes([0.0, share, 1.0, 1.0 - share]), drawing)
    figure.text(0.02, 0.66 * share, says, size=11, weight="bold", color=INK, va="center")
    shade = {None: "#5b6672", True: PASSED, False: FAILED}[passed]
    figure.text(0.02, 0.25 * share, line, size=8.5, family="monospace", color=shade, va="center")
    if passed is not None:
        text = "PASSED" if passed else "FAILED"
        figure.text(
            0.98, 0.64 * share, text, size=13, weight="bold", color=shade, ha="right", va="center"
        )
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def gif(frames):
    """Return the bytes of a GIF of ``frames``, pairs of picture and duration [ms], of one palette."""
    palette = palette_of(np.concatenate([each for each, duration in frames if duration > PERIOD]))
    images = [
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture, _ in frames
    ]
    file = io.BytesIO()
    images[0].save(
        file, "GIF", save_all=True, append_images=images[1:], loop=0,
        duration=[duration for _, duration in frames], disposal=1, optimize=False,
    )  # fmt: skip
    return file.getvalue()


def palette_of(picture):
    """Return an image with the colours of ``picture``, and of what is large in it without a change."""
    large = [LIGHT.ground, LIGHT.water, LIGHT.sky, (1.0, 1.0, 1.0)]
    large += [
        tuple(np.add(np.multiply(share, LIGHT.lines), np.multiply(1.0 - share, under)))
        for under in (LIGHT.ground, LIGHT.water)
        for share in (0.15, 0.3, 0.45, 0.6)
    ]
    found = Image.fromarray(picture).quantize(COLOURS - len(large), Image.Quantize.MAXCOVERAGE)
    fixed = np.round(255.0 * np.array(large)).astype(int).ravel().tolist()
    found.putpalette(fixed + found.getpalette()[: 3 * COLOURS - len(fixed)])
    return found


if __name__ == "__main__":
    main()
