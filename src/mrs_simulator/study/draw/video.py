"""The options ``--video`` and ``--space`` of commands: the run in motion, and in space."""

import functools
import os

from mrs_simulator.study.draw.style import LookError

DEFAULT = "run"  # the file's name
VIEWS = ("view.png", "view.pdf")


def add_video(parser):
    """Give ``parser`` the options ``--video`` and ``--space``, which :func:`write_video` takes."""
    parser.add_argument(
        "--video",
        nargs="?",
        const=DEFAULT,
        metavar="FILE",
        help="write an animation to the results' directory: run.mp4 where ffmpeg is installed, else "
        "run.gif; or to FILE, .gif, .svg or .mp4",
    )
    parser.add_argument(
        "--beside-curves",
        action="store_true",
        help="the animation shows states and inputs, too, which grow beside the team: 960 pixels wide",
    )
    parser.add_argument(
        "--space",
        action="store_true",
        help="write view.png and view.pdf, the team at the end in three dimensions; the animation "
        "shows it so, too",
    )


def check_video(arguments):
    """Raise ``LookError`` for a video that cannot be written."""
    if arguments.beside_curves and not arguments.video:
        raise LookError("--beside-curves: wanted --video, too")
    if not arguments.video or arguments.video == DEFAULT:
        return
    from mrs_simulator.study.draw.animation import FROM_ABOVE, SUFFIXES, WANTED, need_ffmpeg

    if not arguments.video.endswith(SUFFIXES):
        raise LookError("--video {}: {}".format(arguments.video, WANTED))
    for option in ("space", "beside_curves"):
        if getattr(arguments, option) and arguments.video.endswith(".svg"):
            text = "--{} --video {}: {}"
            raise LookError(text.format(option.replace("_", "-"), arguments.video, FROM_ABOVE))
    if arguments.video.endswith(".mp4"):
        need_ffmpeg("--video " + arguments.video)


def write_video(arguments, run, control):
    """Write what ``--video`` and ``--space`` ask for; return the paths.

    ``run``: a function that returns the ``Run``; ``control``: one that returns the control of a run, for
    its graph and targets.
    """
    paths, stage = [], None
    if arguments.space:
        from mrs_simulator.study.draw.space_film import Film, SpaceStage, write_picture

        film = Film(run(), control(run()))
        paths = [write_picture(film, os.path.join(arguments.out, name)) for name in VIEWS]

        def stage(_, width):
            return SpaceStage(film, width)

    return paths + _write_animation(arguments, run, stage)


def _write_animation(arguments, run, stage):
    if not arguments.video:
        return []
    from mrs_simulator.study.draw.animation import WIDTH, Animation, Stage, has_ffmpeg

    path, width = arguments.video, WIDTH
    if path == DEFAULT:
        path = os.path.join(arguments.out, DEFAULT + (".mp4" if has_ffmpeg() else ".gif"))
    if arguments.beside_curves:
        from mrs_simulator.study.draw.growing_curves import GrowingCurves

        stage, width = functools.partial(GrowingCurves, stage=stage or Stage), 2.0 * WIDTH
    return [Animation(run(), width=width, stage=stage).save(path)]
