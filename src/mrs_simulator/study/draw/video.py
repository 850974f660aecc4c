"""The options ``--video`` and ``--space`` of commands: the run in motion, and in space."""

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
        "--space",
        action="store_true",
        help="write view.png and view.pdf, the team at the end in three dimensions; the animation "
        "shows it so, too",
    )


def check_video(arguments):
    """Raise ``LookError`` for a video that cannot be written."""
    if not arguments.video or arguments.video == DEFAULT:
        return
    from mrs_simulator.study.draw.animation import FROM_ABOVE, SUFFIXES, WANTED, need_ffmpeg

    if not arguments.video.endswith(SUFFIXES):
        raise LookError("--video {}: {}".format(arguments.video, WANTED))
    if arguments.space and arguments.video.endswith(".svg"):
        raise LookError("--space --video {}: {}".format(arguments.video, FROM_ABOVE))
    if arguments.video.endswith(".mp4"):
        need_ffmpeg("--video " + arguments.video)


def write_video(arguments, run, control):
    """Write what ``--video`` and ``--space`` ask for; return the paths.

    ``run``: a function that returns the ``Run``; ``control``: one that returns the control of a run, for
    its graph and targets.
    """
    paths, stage = [], None
    if arguments.space:
        from mrs_simulator.study.draw.film import Film, SpaceStage, write_picture

        film = Film(run(), control(run()))
        paths = [write_picture(film, os.path.join(arguments.out, name)) for name in VIEWS]

        def stage(_, width):
            return SpaceStage(film, width)

    return paths + _write_animation(arguments, run, stage)


def _write_animation(arguments, run, stage):
    if not arguments.video:
        return []
    from mrs_simulator.study.draw.animation import Animation, has_ffmpeg

    path = arguments.video
    if path == DEFAULT:
        path = os.path.join(arguments.out, DEFAULT + (".mp4" if has_ffmpeg() else ".gif"))
    return [Animation(run(), stage=stage).save(path)]
