"""The command ``view``: plays a run in a window, or saves it as an animation."""

import argparse
import os

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import LookError
from mrs_simulator.study.results.report import read_run

RATE = 20.0  # [Hz] of pictures in the window


@printing
def main(argv=None):
    """Run the command ``view``; exits with 2 for bad input."""
    parser = argparse.ArgumentParser(prog=program("view"), description="Play a recorded run.")
    parser.add_argument("run", help="run.csv or its directory, or a rosbag of a ROS run")
    parser.add_argument("--speed", type=float, default=5.0, help="times as fast as recorded")
    parser.add_argument(
        "--save", metavar="FILE", help="write FILE, .gif, .svg or .mp4, and open no window"
    )
    arguments = parser.parse_args(argv)
    with refusing_bad_input("view"):
        if not 0.0 < arguments.speed <= 1e4:
            raise LookError("--speed {:g}: wanted from above 0 to 10000".format(arguments.speed))
        run = read_run(arguments.run)
        seconds = max(1.0, float(run.time[-1] - run.time[0]) / arguments.speed)
        if arguments.save:
            from mrs_simulator.study.draw.animation import Animation

            path = Animation(run, seconds).save(arguments.save)
            print("  animation: {}".format(os.path.abspath(path)))
        else:
            _play(run, seconds)


def _play(run, seconds):
    """Show ``run`` in a window of matplotlib's, again and again, until it is closed."""
    import matplotlib.pyplot as plt
    from matplotlib.animation import FuncAnimation
    from matplotlib.rcsetup import interactive_bk

    from mrs_simulator.study.draw.animation import Animation, Stage

    if plt.get_backend().lower() not in {name.lower() for name in interactive_bk}:
        text = "matplotlib's backend {} opens no window; wanted a display, or --save FILE.gif"
        raise LookError(text.format(plt.get_backend()))
    rows = Animation(run, seconds, RATE).rows
    stage = Stage(run, figure=plt.figure(run.scenario.title if run.scenario else "Run"))
    playing = FuncAnimation(stage.figure, stage.show, frames=rows, interval=1000.0 / RATE)
    plt.show()
    del playing
