"""The figures of a run in the style of the paper's Figures 7 to 10.

Each ``draw_`` function fills a given ``matplotlib.figure.Figure``, so a window shows the same
drawing that ``figures`` saves.  ``new_figure`` makes one that lays itself out.  Nothing here uses
pyplot or changes the global ``rcParams`` for good.

Where a ``prediction`` of theory is given it is drawn as a dashed black line.  Theory speaks of hand
points, so the run's hand points are then drawn in place of its wheel-axle centres.  A prediction is
an array (m, n, 2) [m] at the run's own times, or a mapping with ``time`` (p,) [s] and ``hand``
(p, n, 2) [m].
"""

import contextlib
import functools
import io
import os
import threading

import matplotlib
import numpy as np
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cbook import pts_to_poststep
from matplotlib.cm import ScalarMappable, viridis
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.core.maps import obstacles_of
from mrs_simulator.core.moving import moves
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.core.obstacles import corners, is_flat, with_obstacles
from mrs_simulator.core.run_columns import ARM
from mrs_simulator.core.writing import write_bytes
from mrs_simulator.study.look import WIDTHS, Look, check_formats

# Saved files carry no date, so that the same run gives the same bytes.
METADATA = {"png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}

START_COLOUR = "#d60000"
TRAJECTORY_COLOUR = "#1a8a34"
FINAL_COLOUR = "#0b3d91"
OBSTACLE_COLOUR, LAND_COLOUR = "#b8b8b8", "#f1ede2"
# Okabe and Ito's colour-blind-safe palette; its yellow is too faint on white, black is for theory.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b4a3f")
# Without the pale end, which is too faint on white.
MANY_ROBOTS = ListedColormap(viridis(np.linspace(0.0, 0.92, 256)))
MOST_IN_LEGEND = 12  # above it robots are told apart by a colour bar
MOST_IN_LEGEND_ROW = 6
ENTRY_WIDTH = 1.1  # [in] of one entry of a legend
MOST_LINES = (
    MOST_IN_LEGEND  # above it one artist draws all: each artist costs milliseconds in every file
)
MOST_NUMBERED = 200  # above it the numbers at the starts would hide each other

WIDTH = WIDTHS["page"]  # [in]
STATES_HEIGHT = 3.4  # [in]
INPUTS_HEIGHT, INPUT_HEIGHT = 4.4, 1.05  # [in], and of each input where there are many
TRAJECTORIES_HEIGHT = (3.2, 5.8)  # [in], least and most
WARMING = (2.0, 1.5)  # [in], of a drawing that nobody sees

MOST_POINTS_PER_LINE = 2000
MOST_POINTS = 60000  # over all lines of one panel
ROBOT_LENGTH = 0.5  # [m], of the robot drawn at its final pose
ROBOT_SHARE = (0.012, 0.022)  # its least length as a share of the drawing: always, and with room
ROBOT_SHAPE = ((0.6, 0.0), (-0.4, 0.38), (-0.2, 0.0), (-0.4, -0.38))  # of length 1, heading along x
MARGIN = 0.08  # around all that is drawn, as a share of its larger side
REACH = 0.5  # how far around the team obstacles are drawn, as a share of its larger side
LEAST_EXTENT = 10.0  # [m], of a drawing of robots that stand still

STYLE = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 10.0,
    "axes.labelsize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "legend.columnspacing": 1.6,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 200,
    "pdf.fonttype": 42,
    "svg.hashsalt": "mrs_simulator",
    "path.simplify": True,
}

EVERY = slice(None)  # all figures

# Two threads that borrowed the global rcParams at once would hand them back in the wrong order.
_RC_LOCK = threading.RLock()
_own_styles = [{}]  # over STYLE, the innermost last; changed under the lock alone


def styled(function):
    """Run ``function`` under ``STYLE`` and leave the global ``rcParams`` as they were."""

    @functools.wraps(function)
    def under_style(*args, **kwargs):
        with _RC_LOCK, matplotlib.rc_context({**STYLE, **_own_styles[-1]}):
            return function(*args, **kwargs)

    return under_style


@contextlib.contextmanager
def in_style(style):
    """Draw with the rcParams in ``style`` over ``STYLE``, in this thread, while others wait."""
    with _RC_LOCK:
        _own_styles.append(style)
        try:
            yield
        finally:
            _own_styles.pop()


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
            paths += [save(figure, os.path.join(out_dir, name + "." + kind)) for kind in formats]
    return paths


@styled
def warm_up(formats):
    """Load fonts and what writes ``formats`` by a small drawing, so that no figure waits for it."""
    figure = new_figure(*WARMING)
    axes = _emptied(figure, 1)[0]
    axes.plot([0.0, 1.0], [0.0, 1.0], label="Robot 1234567890")
    axes.set(xlabel="$x$ [m]", ylabel=r"$\omega$ [rad/s]")
    _legend_above(axes)
    settle(figure)
    for kind in formats:
        _print(figure, io.BytesIO(), kind)


def _drawings(run, prediction, look):
    """Return ``(file name, function of a figure, height [in])`` of each figure."""
    states = look.scaled(STATES_HEIGHT)
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
        from mrs_simulator.study.space_figure import SPACE_HEIGHT, draw_in_space  # few runs need it

        draw = functools.partial(draw_in_space, run=run, prediction=_in_space(run, prediction))
        drawings += (("trajectories_in_space", draw, look.scaled(SPACE_HEIGHT)),)
    return drawings


def _in_space(run, prediction):
    """Return theory's points (p, n, 3) [m], None without a prediction."""
    return None if prediction is None else _predicted(run, prediction)[1]


@styled
def new_figure(width=WIDTH, height=STATES_HEIGHT):
    """Return an empty figure of ``width`` by ``height`` [in] that makes room for its labels."""
    figure = Figure(figsize=(width, height), constrained_layout=True)
    FigureCanvasAgg(figure)
    return figure


@styled
def settle(figure):
    """Lay out ``figure`` once and for all.

    The solver of the layout leaves its last digits to chance: places are rounded, so that the same
    run gives the same bytes.
    """
    if hasattr(figure, "set_layout_engine"):  # matplotlib 3.6
        figure.get_layout_engine().execute(figure)
        figure.set_layout_engine("none")
    else:
        figure.execute_constrained_layout()
        figure.set_constrained_layout(False)
    for axes in figure.axes:
        axes.set_position([round(value, 4) for value in axes.get_position(original=True).bounds])


@styled
def save(figure, path):
    """Write ``figure`` to ``path`` in the format of its ending, whole or not at all; return path."""
    kind = os.path.splitext(path)[1][1:]
    image = io.BytesIO()
    if _is_settled(figure):
        _print(figure, image, kind)
    else:
        figure.savefig(image, format=kind, metadata=METADATA.get(kind))
    write_bytes(path, image.getvalue())
    return path


def _is_settled(figure):
    """Return whether ``figure`` is laid out for good, as matplotlib 3.6 and later can tell."""
    if not hasattr(figure, "get_layout_engine"):
        return False
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    return not isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine)


def _print(figure, image, kind):
    """Write a settled ``figure`` to ``image``: what ``savefig`` does, but for drawing it twice.

    From matplotlib 3.6 on that draws all once before, unseen, to lay it out.
    """
    canvas, dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = matplotlib.rcParams["savefig.dpi"]
        printing = get_registered_canvas_class(kind)(figure)
        getattr(printing, "print_" + kind)(image, metadata=METADATA.get(kind))
    finally:
        figure.dpi = dpi
        figure.set_canvas(canvas)


@styled
def draw_trajectories(figure, run, prediction=None, axes=None):
    """Draw the robots' paths in the plane on ``axes``, or on ``figure``, emptied first; return the axes."""
    axes = _emptied(figure, 1)[0] if axes is None else axes
    points = _points(run, prediction)
    _draw_obstacles(axes, run)
    _draw_paths(axes, points)
    if prediction is not None:
        _draw_predicted_paths(axes, _predicted(run, prediction)[1][:, :, :2])
    low, high = _extent(run, prediction)
    _draw_final_poses(axes, points[-1], run.pose[-1, :, 2], np.max(high - low))
    _draw_starts(axes, run.robots, points)
    _draw_collisions(axes, run)
    _frame_plane(axes, low, high)
    names = (
        "Start",
        "Trajectory",
        "Theory",
        "Final pose",
        "Land",
        "Obstacle",
        "Arena",
        "Collision",
    )
    _legend_above(axes, names)
    return axes


@styled
def draw_states(figure, run, component, prediction=None, axes=None):
    """Draw ``component`` (``"x"``, ``"y"`` or ``"z"``) of every robot against time; return the axes.

    On ``axes``, or on ``figure``, emptied first.
    """
    column = ("x", "y", "z").index(component)
    axes = _emptied(figure, 1)[0] if axes is None else axes
    if component == "z":
        if prediction is not None and _predicted(run, prediction)[1].shape[2] < 3:
            prediction = None  # theory of the plane
        values = run.spatial.z
    else:
        values = _points(run, prediction)[:, :, column]
    _draw_curves(axes, run, values)
    if prediction is not None:
        time, hand = _predicted(run, prediction)
        _draw_predicted_curves(axes, time, hand[:, :, column])
    symbol = component if prediction is None else r"\alpha_{}".format(component)
    axes.set_ylabel("${}$ [m]".format(symbol))
    _frame_time(axes, run.time)
    _name_robots(axes.figure, [axes], run.robots)
    return axes


@styled
def draw_inputs(figure, run, axes=None):
    """Draw the control inputs of every robot against time, v and omega of unicycles; return the axes.

    On ``axes``, one for each input, or on ``figure``, emptied first.
    """
    rows = _emptied(figure, len(run.axes)) if axes is None else np.atleast_1d(axes)
    if len(rows) != len(run.axes):
        raise ValueError(
            "{} axes for the inputs {}, wanted one each".format(len(rows), ", ".join(run.axes))
        )
    for column, (axes, axis) in enumerate(zip(rows, run.axes)):
        _draw_curves(axes, run, run.command[:, :, column], drawstyle="steps-post")
        _frame_time(axes, run.time)
        axes.set_ylabel(_input_label(axis, run.axes))
        if axes is not rows[-1]:
            axes.set_xlabel("")
    rows[0].figure.align_ylabels(list(rows))
    _name_robots(rows[0].figure, list(rows), run.robots)
    return tuple(rows)


def _emptied(figure, rows):
    """Return ``rows`` axes above each other on ``figure``, which is emptied."""
    figure.clear()
    return figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]


def _input_label(axis, axes):
    """Return the label of one of the ``axes`` of commands: symbol and unit."""
    part, component = axis.split(".")
    if part + "." == ARM:
        return r"$\dot q_{}$ [rad/s]".format(component)
    if part == "linear":
        return "$v$ [m/s]" if axes == UNICYCLE_AXES else "$v_{}$ [m/s]".format(component)
    return r"$\omega$ [rad/s]" if component == "z" else r"$\omega_{}$ [rad/s]".format(component)


# Curves against time


def _draw_curves(axes, run, values, **style):
    """Draw one line per column of ``values`` (m, n) against the run's time."""
    many = values.shape[1] > MOST_IN_LEGEND
    style.update({"lw": 0.7, "alpha": 0.6} if many else {"lw": 1.3})
    if len(values) == 1:
        style["marker"] = "o"
    colours, most = robot_colours(run.robots), _most_points(values.shape[1])
    if len(values) > most:
        # Steps between thinned samples would be longer than the true ones.
        style["drawstyle"] = "default"
    lines = [thin(run.time, column, most) for column in values.T]
    if len(lines) > MOST_LINES and len(values) > 1:
        _draw_many(axes, lines, color=colours, **style)
        return
    for row, (line, robot) in enumerate(zip(lines, run.robots)):
        dashes = "-" if many or row < len(PALETTE) else (0, (4, 1, 1, 1))
        axes.plot(*line, color=colours[row], ls=dashes, label="Robot {}".format(robot), **style)


def _draw_predicted_curves(axes, time, values):
    """Draw theory's ``values`` (p, n) at ``time`` (p,) as dashed black lines."""
    lines = [thin(time, column, _most_points(values.shape[1])) for column in values.T]
    _draw_alike(axes, lines, "Theory", color="k", ls=(0, (4, 3)), lw=_sized(values, 0.8, 0.5))


def _draw_alike(axes, lines, label, **style):
    """Draw ``lines``, each (x, y), in one ``style``; the legend names them once."""
    if len(lines) > MOST_LINES:
        _draw_many(axes, lines, label=label, **style)
        return
    for row, line in enumerate(lines):
        axes.plot(*line, label="_nolegend_" if row else label, **style)


def _draw_many(axes, lines, drawstyle="default", **style):
    """Draw ``lines``, each (x, y), as one artist."""
    if drawstyle == "steps-post":
        lines = [pts_to_poststep(*line) for line in lines]
    paths = [np.stack(line, axis=1) for line in lines]
    axes.add_collection(LineCollection(paths, zorder=2, **style))
    axes.autoscale_view()


def robot_colours(robots):
    """Return a colour (r, g, b, a) for each of ``robots`` (n,), their numbers."""
    if len(robots) <= MOST_IN_LEGEND:
        chosen = [PALETTE[row % len(PALETTE)] for row in range(len(robots))]
        return matplotlib.colors.to_rgba_array(chosen)
    return MANY_ROBOTS(Normalize(np.min(robots), np.max(robots))(np.asarray(robots, dtype=float)))


def _name_robots(figure, panels, robots):
    """Tell which line is which robot: a legend above the first panel, or a colour bar."""
    if len(robots) <= MOST_IN_LEGEND:
        _legend_above(panels[0])
        return
    least, most = np.min(robots), np.max(robots)
    scale = ScalarMappable(Normalize(least, most), MANY_ROBOTS)
    scale.set_array([])
    ticks = np.unique(np.linspace(least, most, 6).round())
    figure.colorbar(scale, ax=panels, label="Robot", aspect=30, pad=0.02, ticks=ticks)
    if "Theory" in panels[0].get_legend_handles_labels()[1]:
        _legend_above(panels[0], ("Theory",))


def _frame_time(axes, time):
    begin, end = float(time[0]), float(time[-1])
    if end <= begin:
        begin, end = begin - 0.5, begin + 0.5
    axes.set_xlim(begin, end)
    axes.set_xlabel("time [s]")


def thin(time, values, most=MOST_POINTS_PER_LINE):
    """Return ``time`` and ``values`` (m,) with about ``most`` samples, for drawing only.

    Of each stretch of samples the first, lowest, highest and last stay, so no peak is lost.
    """
    if len(values) <= most:
        return time, values
    stretch = -(-4 * len(values) // most)
    begins = np.arange(len(values) // stretch) * stretch
    rest = np.arange(len(begins) * stretch, len(values))
    table = values[: rest[0] if len(rest) else None].reshape(-1, stretch)
    peaks = begins + table.argmin(axis=1), begins + table.argmax(axis=1)
    chosen = np.unique(np.concatenate([begins, begins + stretch - 1, rest, *peaks]))
    return time[chosen], values[chosen]


def _most_points(n):
    return min(MOST_POINTS_PER_LINE, max(200, MOST_POINTS // n))


# Trajectories in the plane


def _draw_paths(axes, points):
    style = {"color": TRAJECTORY_COLOUR, "ls": (0, (4, 2)), "lw": _sized(points, 1.2, 0.7)}
    _draw_alike(axes, _thin_paths(points), "Trajectory", **style)


def _draw_predicted_paths(axes, hand):
    style = {"color": "k", "ls": (0, (3, 5)), "lw": _sized(hand, 0.9, 0.5)}
    _draw_alike(axes, _thin_paths(hand), "Theory", **style)


def _thin_paths(points):
    """Return the paths (n, 2, p) of ``points`` (m, n, 2), p no more than a drawing needs."""
    count = min(len(points), _most_points(points.shape[1]))
    chosen = np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))
    return points[chosen].transpose(1, 2, 0)


def _draw_final_poses(axes, points, theta, extent):
    """Draw each robot as an arrow head centred on its final point (n, 2), along its heading."""
    shapes = robot_shapes(points, theta, robot_length(points, extent))
    robots = PolyCollection(shapes, zorder=4)
    robots.set(facecolor=FINAL_COLOUR, edgecolor="none")
    axes.add_collection(robots)
    # The legend shows a robot, not the coloured box that it makes of a collection.
    look = {"marker": ROBOT_SHAPE, "ms": 9, "mew": 0, "color": FINAL_COLOUR}
    axes.plot([], [], ls="", label="Final pose", **look)


def robot_shapes(points, theta, length):
    """Return the corners (n, 4, 2) [m] of arrow heads ``length`` [m] long at ``points`` (n, 2)."""
    shape = length * np.array(ROBOT_SHAPE)
    cos, sin = np.cos(theta), np.sin(theta)
    turned = np.empty((len(points), len(shape), 2))
    turned[:, :, 0] = np.outer(cos, shape[:, 0]) - np.outer(sin, shape[:, 1])
    turned[:, :, 1] = np.outer(sin, shape[:, 0]) + np.outer(cos, shape[:, 1])
    return turned + points[:, np.newaxis]


def draw_ground(axes, run):
    """Draw obstacles and frame the plane as ``draw_trajectories`` does; return its corners (2,) [m]."""
    _draw_obstacles(axes, run)
    low, high = _extent(run, None)
    _frame_plane(axes, low, high)
    return low, high


def robot_length(points, extent):
    """Return how long to draw a robot [m]: to scale, or longer where it could not be seen."""
    least, room = ROBOT_SHARE[0] * extent, ROBOT_SHARE[1] * extent
    if len(points) > 1:
        room = min(room, 0.8 * least_distance(points))
    return max(ROBOT_LENGTH, least, room)


def _draw_obstacles(axes, run):
    """Draw the scenario's boxes and cylinders in grey, and land, where only boats cannot go, lighter."""
    named = set()
    for obstacle in _obstacles(run):
        if hasattr(obstacle, "radius"):
            patch = Circle((obstacle.x, obstacle.y), obstacle.radius)
        else:
            patch = Polygon(corners(obstacle), closed=True)
        land = is_flat(obstacle)
        label = "Land" if land else "Obstacle"
        patch.set(facecolor=LAND_COLOUR if land else OBSTACLE_COLOUR, edgecolor="#7a7a7a")
        patch.set(linewidth=0.6, zorder=0.5 if land else 1)
        patch.set_label("_nolegend_" if label in named else label)
        named.add(label)
        axes.add_patch(patch)
        if moves(obstacle):
            track = obstacle.track
            way = [(obstacle.x, obstacle.y), *track.to] + [(obstacle.x, obstacle.y)] * track.closed
            axes.plot(*zip(*way), color="#7a7a7a", linestyle=":", linewidth=1.0, zorder=1)
    for outline in _arena(run):
        style = {"edgecolor": "#7a7a7a", "linestyle": ":", "linewidth": 1.0, "label": "Arena"}
        axes.add_patch(Polygon(outline, closed=True, fill=False, zorder=1, **style))


def _arena(run):
    """Return the corners, (4, 2) [m], of the arena that the safety filter keeps, in a list."""
    safety = getattr(getattr(run.scenario, "control", None), "safety", None)
    if not getattr(safety, "arena", ()):
        return []
    x_min, y_min, x_max, y_max = safety.arena
    return [np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])]


def _obstacles(run):
    return obstacles_of(run.scenario) if run.scenario is not None else ()


def _draw_collisions(axes, run):
    if run.collisions:
        places = np.array([(collision.x, collision.y) for collision in run.collisions])
        axes.plot(*places.T, "kx", ms=6, mew=1.4, zorder=6, label="Collision")


def _draw_starts(axes, robots, points):
    """Draw red points at the starts, each with its robot's number on the side away from its path."""
    style = {"color": START_COLOUR, "zorder": 5}
    axes.plot(*points[0].T, "o", ms=_sized(points, 4.5, 2.5), label="Start", **style)
    if len(robots) > MOST_NUMBERED:
        return
    away = points[0] - points.mean(axis=0)
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.where(distance > 1e-6, away / np.maximum(distance, 1e-6), [0.0, 1.0])
    size = _sized(points, 9.0, 5.0)
    style.update(textcoords="offset points", ha="center", va="center", fontsize=size)
    style["bbox"] = {"boxstyle": "square,pad=0.02", "fc": "white", "ec": "none", "alpha": 0.7}
    style["zorder"] = 4.5  # over the paths, under the points
    for robot, start, side in zip(robots, points[0], away):
        axes.annotate(str(robot), start, xytext=side * (size + 0.5), **style)


def _frame_plane(axes, low, high):
    margin = MARGIN * np.max(high - low)
    # The aspect may shrink an axis to what is drawn, but for the margin, where numbers stand.
    axes.update_datalim([low - margin, high + margin])
    # The aspect may widen limits that count as automatic; of others matplotlib 3.9 warns.
    axes.set_xlim(low[0] - margin, high[0] + margin, auto=True)
    axes.set_ylim(low[1] - margin, high[1] + margin, auto=True)
    axes.set_aspect("equal", adjustable="datalim")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.set_xlabel("$x$ [m]")
    axes.set_ylabel("$y$ [m]")


def _extent(run, prediction):
    """Return the lowest and highest (x, y) [m] of all that is drawn in the plane."""
    shown = [_points(run, prediction), *_arena(run)]
    if prediction is not None:
        shown.append(_predicted(run, prediction)[1][:, :, :2])
    columns = [[part[..., axis] for part in shown] for axis in (0, 1)]
    low = np.array([min(map(np.nanmin, parts)) for parts in columns])
    high = np.array([max(map(np.nanmax, parts)) for parts in columns])
    side = max(LEAST_EXTENT, np.max(high - low))
    lacking = (side - np.max(high - low)) / 2.0
    return with_obstacles(low - lacking, high + lacking, _obstacles(run), REACH * side)


def inputs_height(run):
    """Return the height [in] of the figure of the inputs of ``run``, of the usual width."""
    return max(INPUTS_HEIGHT, INPUT_HEIGHT * len(run.axes))


def trajectories_height(run, prediction=None, page=WIDTH):
    """Return the height [in] at which a figure of width ``page`` [in] shows the plane without waste."""
    low, high = _extent(run, prediction)
    width, height = (high - low) + 2.0 * MARGIN * np.max(high - low)
    bounds = np.array(TRAJECTORIES_HEIGHT) * max(0.62, page / WIDTH)
    return float(np.clip((page - 0.7) * height / width + 0.8, *bounds))


# What all drawings share


def _points(run, prediction):
    """Return the points to draw, (m, n, 2) [m]: centres, or hand points to hold against theory."""
    return run.pose[:, :, :2] if prediction is None else run.hand[:, :, :2]


def _predicted(run, prediction):
    """Return theory's times (p,) [s] and hand points (p, n, 2) [m]."""
    if isinstance(prediction, dict):
        return np.asarray(prediction["time"]), np.asarray(prediction["hand"])
    return run.time, np.asarray(prediction)


def _sized(table, few, many):
    """Return a size between ``few``, for a team that a legend can name, and ``many``, for 50."""
    return float(np.interp(table.shape[1], [MOST_IN_LEGEND, 50], [few, many]))


def _legend_above(axes, labels=None):
    """Put the legend above ``axes``, where it covers no data; only ``labels``, in order, if given."""
    handles, names = axes.get_legend_handles_labels()
    named = dict(zip(names, handles))
    shown = [(named[name], name) for name in labels or names if name in named]
    fitting = int(axes.figure.get_figwidth() / ENTRY_WIDTH + 0.5)
    rows = -(-len(shown) // max(2, min(MOST_IN_LEGEND_ROW, fitting)))
    columns = -(-len(shown) // rows)
    # A legend fills column by column; people read row by row.
    shown = [pair for column in range(columns) for pair in shown[column::columns]]
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 0.3}
    axes.legend(*zip(*shown), ncol=columns, **place)
