"""A run in motion as one SVG file: vectors that a browser moves by itself (SMIL), without a script.

It is sharp at any size and some tens of kB large, for web pages and slides; a page takes it as any picture.
"""

import io

import numpy as np
from matplotlib.colors import to_hex

from mrs_simulator.study.draw.canvas import print_settled, styled
from mrs_simulator.study.draw.plane_figure import OBSTACLE_COLOUR, move, robot_shapes

KEYS = 48  # moments between which the browser interpolates
MOST_EDGES = 40  # above it edges are most of the file
EDGE_COLOUR, CLOCK_COLOUR = "#b8c4d0", "#7a8794"
PATH_POINTS = 150  # of a robot's path


def moving_svg(stage, rows, seconds):
    """Return the bytes of an SVG in which the run of ``stage`` repeats every ``seconds``.

    ``stage``: an ``animation.Stage``.  ``rows``: the samples that may be shown, of which at most ``KEYS``
    are taken; in between robots move along straight lines.
    """
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, KEYS).round().astype(int))]
    still = _still(stage)
    parts = [
        *_carts(stage, chosen),
        *_paths(stage),
        *_edges(stage, chosen),
        *_robots(stage, chosen),
    ]
    parts.append(_clock(stage))
    moving = "\n".join(parts).replace("TIMES", _times(stage.run.time[chosen], seconds))
    head, closing, _ = still.rpartition("</svg>")
    return (head + '<g id="moving">\n' + moving + "\n</g>\n" + closing + "\n").encode("utf-8")


@styled
def _still(stage):
    """Return the SVG, a text, of all that stands."""
    for artist in stage.moving:
        artist.set_visible(False)
    image = io.BytesIO()
    print_settled(stage.figure, image, "svg")
    return image.getvalue().decode("utf-8")


def _times(time, seconds):
    """Return the attributes of an animation with keys at ``time`` [s], which takes ``seconds``."""
    share = (time - time[0]) / max(time[-1] - time[0], 1e-9)
    keys = ";".join("{:.4g}".format(each) for each in share[:-1]) + ";1"
    if len(time) == 1:
        keys = "0"
    return 'dur="{:g}s" repeatCount="indefinite" keyTimes="{}"'.format(seconds, keys)


def _to_svg(stage, points):
    """Return ``points`` (..., 2) [m] in SVG's points, y downwards."""
    points = np.asarray(points, dtype=float)
    pixels = stage.axes.transData.transform(points.reshape(-1, 2)).reshape(points.shape)
    placed = pixels * 72.0 / stage.figure.dpi
    placed[..., 1] = 72.0 * stage.figure.get_size_inches()[1] - placed[..., 1]
    return placed


def _robots(stage, rows):
    """Return an element for each robot: its shape, carried along and turned."""
    pose = stage.run.pose[rows]
    places = _to_svg(stage, pose[:, :, :2])
    degrees = -np.degrees(np.unwrap(pose[:, :, 2], axis=0))
    (shape,) = robot_shapes(np.zeros((1, 2)), np.zeros(1), stage.length)
    shape = _to_svg(stage, shape) - _to_svg(stage, np.zeros(2))
    for robot, colour in enumerate(map(to_hex, stage.colours)):
        yield (
            '<g>{}<polygon points="{}" fill="{}" stroke="white" stroke-width="0.4">{}</polygon></g>'
        ).format(
            _transform("translate", [_pair(each) for each in places[:, robot]]),
            " ".join(map(_pair, shape)),
            colour,
            _transform("rotate", ["{:.0f}".format(each) for each in degrees[:, robot]]),
        )


def _paths(stage):
    """Return an element for each robot: its whole path, pale."""
    pose = stage.run.pose
    chosen = np.unique(np.linspace(0, len(pose) - 1, PATH_POINTS).round().astype(int))
    paths = _to_svg(stage, pose[chosen, :, :2])
    for robot, colour in enumerate(map(to_hex, stage.colours)):
        yield (
            '<polyline points="{}" fill="none" stroke="{}" stroke-width="1" opacity="0.45"/>'
        ).format(" ".join(map(_pair, paths[:, robot])), colour)


def _edges(stage, rows):
    """Return one element for all edges of the graph, each once."""
    if stage.pairs is None:
        return
    pairs = np.unique(np.sort(stage.pairs, axis=1), axis=0)
    if len(pairs) > MOST_EDGES:
        return
    ends = _to_svg(stage, stage.run.hand[rows][:, :, :2])[:, pairs]
    shapes = ["".join("M{}L{}".format(*map(_pair, edge)) for edge in moment) for moment in ends]
    style = 'fill="none" stroke="{}" stroke-width="0.8"'.format(EDGE_COLOUR)
    yield _shaped(shapes, style)


def _carts(stage, rows):
    """Return an element for each obstacle that moves."""
    style = 'fill="{}" stroke="#7a7a7a" stroke-width="0.6"'.format(OBSTACLE_COLOUR)
    shapes = [[] for _ in stage.carts]
    for row in rows:
        move(stage.carts, stage.begun + float(stage.run.time[row]))
        for drawn, (_, patch) in zip(shapes, stage.carts):
            outline = patch.get_patch_transform().transform(patch.get_path().to_polygons()[0])
            drawn.append("M{}Z".format("L".join(map(_pair, _to_svg(stage, outline)))))
    for drawn in shapes:
        yield _shaped(drawn, style)


def _clock(stage):
    """Return a bar below the axes that grows with the run's time."""
    (left, low), (right, _) = (
        stage.axes.transAxes.transform([(0, 0), (1, 0)]) * 72.0 / stage.figure.dpi
    )
    y = 72.0 * stage.figure.get_size_inches()[1] - low
    return (
        '<rect x="{:.1f}" y="{:.1f}" height="2.5" width="0" fill="{}"><animate attributeName="width" '
        'from="0" to="{:.1f}" {}/></rect>'
    ).format(left, y - 2.5, CLOCK_COLOUR, right - left, "TIMES".partition(" keyTimes")[0])


def _shaped(shapes, style):
    return '<path {} d="{}"><animate attributeName="d" values="{}" TIMES/></path>'.format(
        style, shapes[0], ";".join(shapes)
    )


def _transform(kind, values):
    return '<animateTransform attributeName="transform" type="{}" values="{}" TIMES/>'.format(
        kind, ";".join(values)
    )


def _pair(point):
    return "{:.1f},{:.1f}".format(*point)
