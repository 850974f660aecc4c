"""The option ``--video`` of commands: an animation of the run beside its figures."""

import os

from mrs_simulator.study.look import LookError

DEFAULT = "run"  # the file's name


def add_video(parser):
    """Give ``parser`` the option ``--video``, which :func:`write_video` takes."""
    parser.add_argument(
        "--video",
        nargs="?",
        const=DEFAULT,
        metavar="FILE",
        help="write an animation to the results' directory: run.mp4 where ffmpeg is installed, else "
        "run.gif; or to FILE, .gif or .mp4",
    )


def check_video(arguments):
    """Raise ``LookError`` for a video that cannot be written."""
    if not arguments.video or arguments.video == DEFAULT:
        return
    if not arguments.video.endswith((".gif", ".mp4")):
        raise LookError("--video {}: wanted a file .gif or .mp4".format(arguments.video))
    if arguments.video.endswith(".mp4"):
        from mrs_simulator.study.animation import need_ffmpeg

        need_ffmpeg("--video " + arguments.video)


def write_video(arguments, run):
    """Write what ``--video`` asks for; return the paths.  ``run``: a function that returns the ``Run``."""
    if not arguments.video:
        return []
    from mrs_simulator.study.animation import Animation, has_ffmpeg

    path = arguments.video
    if path == DEFAULT:
        path = os.path.join(arguments.out, DEFAULT + (".mp4" if has_ffmpeg() else ".gif"))
    return [Animation(run()).save(path)]
