"""The figures of a run in the style of the paper's Figures 7 to 10.

Each ``draw_`` function fills a given ``matplotlib.figure.Figure``, so a window shows the same
drawing that ``figures`` saves.  ``new_figure`` makes one that lays itself out.

Where a ``prediction`` of theory is given it is drawn as a dashed black line.  Theory speaks of hand
points, so the run's hand points are then drawn in place of its wheel-axle centres.  A prediction is
an array (m, n, 2) [m] at the run's own times, or a mapping with ``time`` (p,) [s] and ``hand``
(p, n, 2) [m].
"""

import functools
import io
import os

from mrs_simulator.core.sample_blocks import release
from mrs_simulator.study.draw.canvas import (
    HEIGHT,
    in_style,
    new_figure,
    print_settled,
    save,
    settle,
    styled,
)
from mrs_simulator.study.draw.curve_figures import draw_inputs, draw_states, inputs_height
from mrs_simulator.study.draw.figure_parts import predicted_of
from mrs_simulator.study.draw.plane_figure import draw_trajectories, trajectories_height
from mrs_simulator.study.draw.style import Look, check_formats

WARMING = (2.0, 1.5)  # [in], of a drawing that is not shown
EVERY = slice(None)  # all figures


def figures(run, out_dir, formats=("png", "pdf"), prediction=None, look=None, part=EVERY):
    """Write the figures of ``run`` into ``out_dir`` and return the paths written.

    ``trajectories``, ``x_states``, ``y_states`` and ``inputs``, of robots off the ground ``z_states``, of a
    run in space ``trajectories_in_space``, each in every one of ``formats`` (png, pdf, svg), as ``look``, a
    ``Look``, has it; ``part``: which of them.  A file appears whole or not at all.  Raises ``ValueError``
    for another format and for a run without samples.
    """
    check_formats(formats)
    if not len(run.time):
        raise ValueError("a run without samples has no figures")
    look = Look() if look is None else look
    os.makedirs(out_dir, exist_ok=True)
    paths = []
    with in_style(look.style):
        for name, draw, height in _drawings(run, prediction, look)[part]:
            figure = new_figure(look.width, height)
            draw(figure)
            settle(figure)
            made = [os.path.join(out_dir, name + "." + kind) for kind in formats]
            paths += [save(figure, path, look.stamp) for path in made]
            release()  # what the figure shows is in it
    return paths


@styled
def warm_up(formats):
    """Load fonts, what reads formulas, and what writes ``formats``, so that no figure waits for it."""
    figure = new_figure(*WARMING)
    figure.text(0.0, 0.0, r"Robot 1234567890 $x$ $\omega$")
    for kind in formats:
        print_settled(figure, io.BytesIO(), kind)


def _drawings(run, prediction, look):
    """Return ``(file name, function of a figure, height [in])`` of each figure."""
    states = look.scaled(HEIGHT)
    drawings = (
        (
            "trajectories",
            lambda figure: draw_trajectories(figure, run, prediction),
            trajectories_height(run, prediction, look.width),
        ),
        ("x_states", lambda figure: draw_states(figure, run, "x", prediction), states),
        ("y_states", lambda figure: draw_states(figure, run, "y", prediction), states),
        ("inputs", lambda figure: draw_inputs(figure, run), look.scaled(inputs_height(run))),
    )
    if run.spatial is not None:
        draw = functools.partial(draw_states, run=run, component="z", prediction=prediction)
        drawings += (("z_states", draw, states),)
    if run.hand.shape[2] == 3:
        from mrs_simulator.study.draw.space_figure import (  # few runs need it
            SPACE_HEIGHT,
            draw_in_space,
        )

        draw = functools.partial(draw_in_space, run=run, prediction=_in_space(run, prediction))
        drawings += (("trajectories_in_space", draw, look.scaled(SPACE_HEIGHT)),)
    return drawings


def _in_space(run, prediction):
    """Return theory's points (p, n, 3) [m], None without a prediction."""
    return None if prediction is None else predicted_of(run, prediction)[1]
