"""The figures show the run's own numbers, in the paper's style, for one robot and for a hundred."""

import io
import os
import re
import stat
import tracemalloc
import zlib
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from fontTools import ttLib
from matplotlib.backends import _backend_pdf_ps as fonts_of_pdf
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from matplotlib.image import imread
from matplotlib.ticker import LogLocator
from PIL import Image

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.record.recording import Collision, Run
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.study.draw import canvas, curve_figures, figure_parts, pdf_fonts, plane_figure
from mrs_simulator.study.draw import figures as report
from mrs_simulator.study.draw.style import FORMATS, LookError, look

NAMES = ("trajectories", "x_states", "y_states", "inputs")


def make_run(n=7, m=50, **fields):
    """Return a run of ``n`` robots on arcs of their own, ``m`` samples at 10 Hz."""
    time = 0.1 * np.arange(m)
    row = np.arange(n)
    pose = np.empty((m, n, 3))
    pose[:, :, 2] = 0.3 * row + 0.2 * time[:, np.newaxis]
    pose[:, :, 0] = 2.0 * row + np.sin(pose[:, :, 2])
    pose[:, :, 1] = (row % 5) - np.cos(pose[:, :, 2])
    command = np.stack([0.2 + 0.0 * pose[:, :, 0], np.cos(pose[:, :, 0])], axis=2)
    run = Run(time, row + 1, pose, hand_points(pose, 0.05), command)
    return run._replace(**fields)


def named(axes, label):
    """Return the one line of ``axes`` with ``label``."""
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return line


def legend_texts(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def content(path):
    with open(path, "rb") as file:
        return file.read()


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Return the folder of the figures of one run by default, their paths and the global style after it."""
    folder, before = (
        tmp_path_factory.mktemp("figures") / "made" / "here",
        matplotlib.rcParams.copy(),
    )
    paths = report.figures(make_run(7), str(folder))
    return folder, paths, matplotlib.rcParams.copy() == before


def check_files(folder, paths, kinds):
    """Check that ``paths`` are all figures, whole and valid, and alone in their ``folder``."""
    wanted = [name + "." + kind for name in NAMES for kind in kinds]
    assert [os.path.basename(path) for path in paths] == wanted
    assert sorted(os.listdir(str(folder))) == sorted(wanted)
    for path in paths:
        written = content(path)
        if path.endswith(".png"):
            assert np.ptp(imread(path)[:, :, :3]) > 0.5
        elif path.endswith(".pdf"):
            assert written.startswith(b"%PDF") and written.rstrip().endswith(b"%%EOF")
        else:
            assert written.rstrip().endswith(b"</svg>")


def test_png_and_pdf_are_written_by_default_whole_and_valid(drawn):
    folder, paths, _ = drawn
    check_files(folder, paths, ("png", "pdf"))


@pytest.mark.parametrize("n", [pytest.param(1, marks=pytest.mark.release), 100])
def test_four_figures_of_one_robot_and_of_many_are_written(tmp_path, n):
    check_files(tmp_path, report.figures(make_run(n), str(tmp_path), ("png",)), ("png",))


@pytest.mark.parametrize("color, mode", [("white", "RGB"), ((1.0, 1.0, 1.0, 0.5), "RGBA")])
def test_png_shows_what_matplotlib_would_write_with_alpha_only_where_it_is_needed(
    tmp_path, color, mode
):
    figure = report.new_figure()
    figure.subplots().plot([0.0, 3.0], [1.0, 2.0], color="C1", alpha=0.4)
    figure.set_facecolor(color)
    canvas.settle(figure)
    path, expected = str(tmp_path / "a.png"), str(tmp_path / "b.png")
    canvas.save(figure, path, "a stamp")
    canvas.styled(figure.savefig)(expected, facecolor=color)
    with Image.open(path) as image, Image.open(expected) as other:
        assert image.mode == mode and np.ptp(np.asarray(image)[:, :, :3]) > 100
        assert image.convert("RGBA").tobytes() == other.convert("RGBA").tobytes()
        assert image.info == {**other.info, "Description": "a stamp"}


def fonts_in(path):
    """Return the font files in the PDF of ``path``, as bytes."""
    streams = re.findall(rb"stream\n(.*?)\nendstream", content(path), re.DOTALL)
    plain = (zlib.decompressobj().decompress(stream) for stream in streams)
    return [font for font in plain if font.startswith(b"\0\1\0\0")]


def test_pdfs_share_what_they_carry_of_fonts_and_lack_no_character(tmp_path):
    """Whatever was drawn before, the same bytes; a sign of few figures is in the file that shows it."""
    characters = ttLib.TTFont(findfont("STIXGeneral")).getBestCmap()

    @canvas.styled
    def drawn(name, text):
        figure = report.new_figure()
        figure.subplots().set_xlabel(text)
        canvas.settle(figure)
        return fonts_in(canvas.save(figure, str(tmp_path / name)))

    cut = fonts_of_pdf.get_glyphs_subset
    pdf_fonts._part.cache_clear()
    rare = drawn("a.pdf", "Robot 1 \N{INFINITY}")
    usual, other = drawn("b.pdf", "Robot 1 $x$"), drawn("c.pdf", "Robot 2 and 3")
    assert fonts_of_pdf.get_glyphs_subset is cut  # as others find it
    shown = [set(ttLib.TTFont(io.BytesIO(*fonts)).getBestCmap()) for fonts in (rare, other)]
    assert {ord("\N{INFINITY}")} == shown[0] - shown[1] and shown[1] < set(characters)
    if not hasattr(fonts_of_pdf, "font_as_file"):
        assert usual[:1] == other and pdf_fonts._part.cache_info().misses == 3
    pdf_fonts._part.cache_clear()
    assert drawn("d.pdf", "Robot 2 and 3") == other
    assert content(tmp_path / "d.pdf") == content(tmp_path / "c.pdf")


def test_pdf_embeds_its_fonts_as_outlines_that_journals_accept(drawn):
    for path in drawn[1][1::2]:
        written = content(path)
        assert path.endswith(".pdf") and b"/FontFile2" in written and b"/Type3" not in written


def test_the_same_run_gives_the_same_bytes(drawn, tmp_path):
    kinds = FORMATS if matplotlib.__version__ >= "3.4" else ("png", "pdf")
    paths = report.figures(make_run(7), str(tmp_path / "a"), kinds)
    check_files(tmp_path / "a", paths, kinds)
    others = [*drawn[1], *report.figures(make_run(7), str(tmp_path / "b"), kinds[2:])]
    assert sorted(map(os.path.basename, others)) == sorted(map(os.path.basename, paths))
    for other in others:
        assert content(other) == content(tmp_path / "a" / os.path.basename(other)), other


def test_unknown_format_and_empty_run_are_refused(tmp_path):
    with pytest.raises(ValueError, match="'gif'.*png"):
        report.figures(make_run(2), str(tmp_path), ("png", "gif"))
    with pytest.raises(ValueError, match="without samples"):
        report.figures(make_run(2, m=0), str(tmp_path))
    assert not os.listdir(str(tmp_path))


def test_a_save_that_fails_leaves_the_old_figure_and_no_litter(tmp_path, monkeypatch):
    first = {"formats": ("png",), "part": slice(1)}
    (path,) = report.figures(make_run(2), str(tmp_path), **first)
    before = content(path)

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        report.figures(make_run(5), str(tmp_path), **first)
    assert content(path) == before
    assert os.listdir(str(tmp_path)) == [os.path.basename(path)]


def test_files_have_the_usual_permissions(drawn, tmp_path):
    usual = tmp_path / "usual"
    usual.write_text("")
    modes = {stat.S_IMODE(os.stat(path).st_mode) for path in drawn[1]}
    assert modes == {stat.S_IMODE(os.stat(str(usual)).st_mode)}


def test_global_style_is_left_alone(drawn):
    assert drawn[2]


@pytest.mark.parametrize("n", [1, 7, figure_parts.MOST_LINES])
def test_trajectories_are_dashed_green_and_are_the_runs(n):
    run = make_run(n)
    axes = report.draw_trajectories(report.new_figure(), run)
    for row, line in enumerate(axes.lines[:n]):
        np.testing.assert_array_equal(line.get_xydata(), run.pose[:, row, :2])
        red, green, blue = to_rgb(line.get_color())
        assert green > 2 * red and green > 2 * blue
        assert line.is_dashed()


def test_starts_are_red_points_with_the_robots_numbers():
    run = make_run(4, robots=np.array([2, 3, 5, 8]))
    axes = report.draw_trajectories(report.new_figure(), run)
    starts = named(axes, "Start")
    np.testing.assert_array_equal(starts.get_xydata(), run.pose[0, :, :2])
    red, green, blue = to_rgb(starts.get_color())
    assert red > 0.8 and green < 0.2 and blue < 0.2 and starts.get_marker() == "o"
    assert [text.get_text() for text in axes.texts] == ["2", "3", "5", "8"]


def test_final_poses_point_along_the_headings():
    run = make_run(3)
    axes = report.draw_trajectories(report.new_figure(), run)
    for shape, (x, y, theta) in zip(axes.collections[0].get_paths(), run.pose[-1]):
        tip = shape.vertices[0] - (x, y)
        assert np.arctan2(tip[1], tip[0]) == pytest.approx((theta + np.pi) % (2 * np.pi) - np.pi)


def test_plane_has_equal_axes_in_metres_and_holds_all_that_is_drawn():
    wall = Box("wall", 10.0, 3.0, np.pi / 2, 8.0, 1.0, 0.5)
    scenario = SimpleNamespace(map=None, obstacles=(wall, Cylinder("post", -9.0, 0.0, 2.0, 1.0)))
    figure = report.new_figure()
    axes = report.draw_trajectories(figure, make_run(3, scenario=scenario))
    figure.canvas.draw()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ [m]", "$y$ [m]")
    box = axes.get_window_extent()
    assert box.width / np.ptp(axes.get_xlim()) == pytest.approx(
        box.height / np.ptp(axes.get_ylim())
    )
    assert axes.get_xlim()[0] < -11.0 and axes.get_xlim()[1] > 10.5
    assert axes.get_ylim()[0] < -2.0 and axes.get_ylim()[1] > 7.0


def test_obstacles_and_collisions_are_drawn_and_named():
    box = Box("box", 1.0, 2.0, np.pi / 2, 4.0, 2.0, 0.5)
    scenario = SimpleNamespace(map=None, obstacles=(box, Cylinder("post", 3.0, 4.0, 0.5, 1.0)))
    collisions = [Collision(1.0, "robot1", "box", 1.5, 2.5)]
    run = make_run(2, scenario=scenario, collisions=collisions)
    axes = report.draw_trajectories(report.new_figure(), run)
    square, circle = axes.patches
    corners = {(round(x, 9), round(y, 9)) for x, y in square.get_xy()}
    assert corners == {(0.0, 0.0), (2.0, 0.0), (2.0, 4.0), (0.0, 4.0)}
    assert (tuple(circle.center), circle.radius) == ((3.0, 4.0), 0.5)
    np.testing.assert_array_equal(named(axes, "Collision").get_xydata(), [[1.5, 2.5]])
    wanted = ["Start", "Trajectory", "Final pose", "Obstacle", "Collision"]
    assert legend_texts(axes) == wanted


def test_land_is_named_and_drawn_beneath_what_stands_on_it():
    land = Box("land", 0.0, 0.0, 0.0, 900.0, 8.0, 0.0)
    box = Box("box", 1.0, 2.0, 0.0, 1.0, 2.0, 0.5)
    scenario = SimpleNamespace(map=None, obstacles=(box, land))
    axes = report.draw_trajectories(report.new_figure(), make_run(2, scenario=scenario))
    assert {"Land", "Obstacle"} <= set(legend_texts(axes))
    stands, lies = axes.patches
    assert lies.get_zorder() < stands.get_zorder()
    assert sum(lies.get_facecolor()) > sum(stands.get_facecolor())
    assert np.ptp(axes.get_xlim()) < 100.0


@pytest.mark.parametrize("component, column", [("x", 0), ("y", 1)])
@pytest.mark.parametrize("n", [1, 7, figure_parts.MOST_LINES])
def test_states_are_the_runs_against_time(n, component, column):
    run = make_run(n)
    axes = report.draw_states(report.new_figure(), run, component)
    assert len(axes.lines) == n
    for row, line in enumerate(axes.lines):
        np.testing.assert_array_equal(line.get_xdata(), run.time)
        np.testing.assert_array_equal(line.get_ydata(), run.pose[:, row, column])
    assert axes.get_ylabel() == "${}$ [m]".format(component)
    assert axes.get_xlabel() == "time [s]"
    assert axes.get_xlim() == (run.time[0], run.time[-1])


def test_inputs_are_the_runs_held_between_samples():
    figure, run = report.new_figure(), make_run(7)
    panels = report.draw_inputs(figure, run)
    figure.canvas.draw()
    for column, axes in enumerate(panels):
        for row, line in enumerate(axes.lines):
            np.testing.assert_array_equal(line.get_ydata(), run.command[:, row, column])
            assert line.get_drawstyle() == "steps-post"
    assert [axes.get_ylabel() for axes in panels] == ["$v$ [m/s]", r"$\omega$ [rad/s]"]
    assert panels[1].get_xlabel() == "time [s]"
    upper, lower = (axes.get_window_extent() for axes in panels)
    assert upper.y0 > lower.y1 and upper.width == pytest.approx(lower.width)


@pytest.mark.parametrize("n", [1, 7, 12])
def test_each_robot_of_a_small_team_has_its_legend_entry_and_look(n):
    figure = report.new_figure()
    axes = report.draw_states(figure, make_run(n), "x")
    assert sorted(legend_texts(axes)) == sorted("Robot {}".format(row + 1) for row in range(n))
    assert len({(str(line.get_color()), line.is_dashed()) for line in axes.lines}) == n
    assert figure.axes == [axes]


def test_a_large_team_has_a_colour_bar_from_first_to_last_robot():
    figure = report.new_figure()
    axes = report.draw_states(figure, make_run(100), "y")
    assert axes.get_legend() is None
    (bar,) = [other for other in figure.axes if other is not axes]
    assert bar.get_ylabel() == "Robot"
    assert list(bar.get_ylim()) == [1, 100]
    (curves,) = axes.collections
    assert len({tuple(colour) for colour in curves.get_color()}) == 100


def test_a_large_team_is_drawn_by_few_artists():
    n = plane_figure.MOST_NUMBERED + 1
    run = make_run(n)
    theory = run.hand + 0.1
    axes = report.draw_states(report.new_figure(), run, "y", theory)
    curves, predicted = axes.collections
    for row, (curve, line) in enumerate(zip(curves.get_segments(), predicted.get_segments())):
        np.testing.assert_array_equal(curve, np.stack([run.time, run.hand[:, row, 1]], axis=1))
        np.testing.assert_array_equal(line, np.stack([run.time, theory[:, row, 1]], axis=1))
    assert len({tuple(colour) for colour in curves.get_color()}) > 100
    assert (
        axes.get_ylim()[0] <= run.hand[:, :, 1].min() < theory[:, :, 1].max() <= axes.get_ylim()[1]
    )
    assert legend_texts(axes) == ["Theory"]
    upper, _ = report.draw_inputs(report.new_figure(), run)
    held = upper.collections[0].get_segments()[3]
    np.testing.assert_array_equal(held[::2, 1], run.command[:, 3, 0])
    np.testing.assert_array_equal(held[1::2, 1], run.command[:-1, 3, 0])
    axes = report.draw_trajectories(report.new_figure(), run, theory)
    assert legend_texts(axes) == ["Start", "Trajectory", "Theory", "Final pose"]
    assert len(axes.get_children()) < 50


@pytest.mark.parametrize("n", [1, pytest.param(7, marks=pytest.mark.release), 12, 100])
def test_nothing_is_cut_off_and_the_legend_covers_no_data(n):
    for draw in (report.draw_trajectories, report.draw_inputs):
        figure = report.new_figure(height=curve_figures.INPUTS_HEIGHT)
        first = np.ravel(draw(figure, make_run(n)))[0]
        figure.canvas.draw()
        drawn = figure.get_tightbbox(figure.canvas.get_renderer())
        assert drawn.x0 >= 0 and drawn.y0 >= 0
        assert drawn.x1 <= figure.get_figwidth() and drawn.y1 <= figure.get_figheight()
        if first.get_legend():
            inside = first.get_window_extent()
            assert first.get_legend().get_window_extent().y0 >= inside.y1
            assert inside.width > 0.7 * figure.bbox.width


@pytest.mark.parametrize("as_mapping", [False, True])
def test_theory_is_a_dashed_black_line_held_against_hand_points(as_mapping):
    run = make_run(3)
    theory = run.hand + 0.1
    given = {"time": run.time, "hand": theory} if as_mapping else theory
    axes = report.draw_states(report.new_figure(), run, "y", given)
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), run.hand[:, 0, 1])
    line = named(axes, "Theory")
    np.testing.assert_array_equal(line.get_ydata(), theory[:, 0, 1])
    assert to_rgb(line.get_color()) == (0, 0, 0) and line.is_dashed()
    assert axes.get_ylabel() == r"$\alpha_y$ [m]"
    assert "Theory" in legend_texts(report.draw_trajectories(report.new_figure(), run, given))
    crowd = make_run(20)
    assert legend_texts(report.draw_states(report.new_figure(), crowd, "x", crowd.hand)) == [
        "Theory"
    ]


@pytest.mark.filterwarnings("error")
def test_long_runs_are_not_copied_to_find_where_theory_is_near():
    hand = np.random.default_rng(0).normal(size=(20000, 20, 2))
    tracemalloc.start()
    _, found = figure_parts.predicted_of(SimpleNamespace(time=None, hand=hand), hand)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.base is hand or found is hand
    assert most < 0.3 * hand.nbytes


def test_theory_that_goes_to_infinity_is_drawn_as_far_as_the_run_is_seen(tmp_path):
    run = make_run(3)
    growth = np.append(np.logspace(-3, 300, len(run.time) - 1), np.inf)  # 1 m at the second sample
    theory = run.hand + np.where(growth < 1.0, 0.0, growth)[:, np.newaxis, np.newaxis]
    theory[1] = run.hand[1] + 1.0
    low, high = report.draw_trajectories(report.new_figure(), run, theory).get_xlim()
    assert high - low < 11.0 * figure_parts.THEORY_REACH  # of a run of less than 10 m
    line = named(report.draw_states(report.new_figure(), run, "x", theory), "Theory")
    assert np.isfinite(line.get_ydata()).tolist() == [True] * 2 + [False] * (len(run.time) - 2)
    assert len(report.figures(run, str(tmp_path), ("png",), theory)) == 4


@pytest.mark.parametrize("n", [1, 20])
def test_a_run_of_one_sample_draws(tmp_path, n):
    run = make_run(n, m=1)
    assert len(report.figures(run, str(tmp_path), ("png",), run.hand)) == 4
    axes = report.draw_states(report.new_figure(), run, "x")
    assert axes.get_xlim()[0] < 0.0 < axes.get_xlim()[1]
    assert axes.lines[0].get_marker() == "o"


def test_robots_that_stand_still_on_one_place_draw(tmp_path):
    run = make_run(2)
    still = run._replace(pose=0.0 * run.pose, command=0.0 * run.command)
    assert len(report.figures(still, str(tmp_path), ("png",))) == 4


def test_long_runs_are_thinned_for_drawing_and_keep_their_peaks_and_ends():
    time = 0.01 * np.arange(100001)
    values = np.sin(time)
    values[54321], values[77777] = 9.0, -9.0
    thinned_time, thinned = figure_parts.thin(time, values)
    assert len(thinned) <= figure_parts.MOST_POINTS_PER_LINE + 200
    assert {9.0, -9.0} <= set(thinned)
    assert np.all(np.diff(thinned_time) > 0)
    assert (thinned_time[0], thinned_time[-1]) == (time[0], time[-1])
    run = make_run(2, m=9001)
    path = report.draw_trajectories(report.new_figure(), run).lines[1].get_xydata()
    assert len(path) <= figure_parts.MOST_POINTS_PER_LINE
    np.testing.assert_array_equal(path[[0, -1]], run.pose[[0, -1], 1, :2])


def test_drawing_again_on_the_same_figure_replaces_the_drawing():
    figure = report.new_figure()
    report.draw_inputs(figure, make_run(20))
    axes = report.draw_states(figure, make_run(2), "x")
    assert figure.axes == [axes]


def test_an_obstacle_far_away_leaves_the_team_its_scale():
    near = Cylinder("post", -6.0, 0.0, 0.5, 1.0)
    far = Box("wall", 300.0, 3.0, 0.0, 8.0, 1.0, 0.5)
    long = Box("border", 0.0, -6.0, 0.0, 500.0, 1.0, 0.5)

    def limits(*obstacles):
        run = make_run(3, scenario=SimpleNamespace(map=None, obstacles=obstacles))
        axes = report.draw_trajectories(report.new_figure(), run)
        return np.array([axes.get_xlim(), axes.get_ylim()])

    np.testing.assert_array_equal(limits(near, far), limits(near))
    assert limits(long)[1, 0] < -6.5 and np.ptp(limits(long)[0]) < 3.0 * np.ptp(limits()[0])


NARROW = look("column", {"lines.linewidth": 0.5})


def test_a_columns_figures_have_its_width(tmp_path):
    report.figures(make_run(12), str(tmp_path), ("png",), look=NARROW)
    for name in NAMES:
        width = imread(str(tmp_path / (name + ".png"))).shape[1]
        assert width == round(3.5 * canvas.STYLE["savefig.dpi"]), name


@pytest.mark.parametrize("n", [3, 12, 30])
def test_a_columns_figure_holds_its_legend(n):
    with report.in_style(NARROW.style):
        figure = report.new_figure(NARROW.width, 3.0)
        axes = report.draw_states(figure, make_run(n), "x")
        figure.canvas.draw()
    assert axes.xaxis.label.get_size() == 8.0
    if axes.get_legend() is not None:
        box = axes.get_legend().get_window_extent()
        assert box.x0 > 0.0 and box.x1 < figure.bbox.x1
    assert matplotlib.rcParams["font.size"] == 10.0  # the global one


def test_robots_numbers_keep_clear_of_a_columns_frame():
    starts = np.array([(10, -5), (5, -2), (2, 8), (-5, 12.3), (-1, 6), (0, -5), (-10, 4)])
    share = np.linspace(1.0, 0.2, 9)[:, np.newaxis, np.newaxis]
    pose = np.concatenate([share * starts, np.zeros((9, 7, 1))], axis=2)
    run = make_run(7, 9, pose=pose, hand=pose[..., :2])
    with report.in_style(look("column").style):
        figure = report.new_figure(3.5, report.trajectories_height(run, page=3.5))
        axes = report.draw_trajectories(figure, run)
        report.settle(figure)
        figure.canvas.draw()
    frame, numbers = axes.get_window_extent(), [text.get_window_extent() for text in axes.texts]
    room = min(min(n.y0 - frame.y0, frame.y1 - n.y1) for n in numbers)
    assert len(numbers) == 7 and room > 0.02 * frame.height


def test_drawings_go_onto_the_axes_of_others():
    figure = report.new_figure()
    own = figure.subplots(2, 2)
    assert report.draw_trajectories(None, make_run(), axes=own[0, 0]) is own[0, 0]
    assert report.draw_states(None, make_run(), "y", axes=own[0, 1]) is own[0, 1]
    assert report.draw_inputs(None, make_run(), axes=own[1]) == tuple(own[1])
    assert all(axes.lines for axes in own.flat)
    with pytest.raises(ValueError, match="1 axes for the inputs linear.x, angular.z"):
        report.draw_inputs(None, make_run(), axes=own[0, 0])


@pytest.mark.parametrize(
    "given, inches",
    [("", 6.5), ("column", 3.5), ("88mm", 88 / 25.4), (5, 5.0), ("8.9 cm", 8.9 / 2.54)],
)
def test_widths_are_names_or_lengths(given, inches):
    assert look(given).width == pytest.approx(inches)


@pytest.mark.parametrize(
    "width, style, told",
    [
        ("wide", "", "width 'wide': wanted page, column, slide, or from 1.5 to 40 in"),
        ("0.1in", "", "width '0.1in'"),
        ("", "nowhere.mplstyle", "style 'nowhere.mplstyle': neither a file nor a style"),
        ("", {"font.sise": 3}, "style: .*font.sise"),
        ("", {"font.size": "big"}, "style: .*big"),
    ],
)
def test_looks_that_cannot_be_had_are_named(width, style, told):
    with pytest.raises(LookError, match=told):
        look(width, style)


def test_the_legend_names_theory_only_where_its_lines_show():
    run = make_run(n=2)
    assert not figure_parts.is_seen(np.full((2, 5), np.nan))
    standing = np.repeat(run.hand[:1], len(run.time), axis=0)
    for prediction, shown in ((run.hand, True), (standing, False)):
        axes = report.draw_trajectories(report.new_figure(), run, prediction)
        names = [text.get_text() for text in axes.get_legend().get_texts()]
        assert ("Theory" in names) is shown and "Trajectory" in names


@pytest.mark.parametrize("count", [1, 2, 7, 20])
def test_paths_of_different_kinds_have_looks_of_their_own(count, monkeypatch):
    looks = {}
    original = plane_figure.draw_alike

    def recorded(axes, lines, label, **style):
        looks[label] = len(lines), style["color"], style["ls"]
        original(axes, lines, label, **style)

    monkeypatch.setattr(plane_figure, "draw_alike", recorded)
    kinds = tuple("kind{}".format(row % count) for row in range(20))
    axes = plane_figure.draw_trajectories(Figure(), make_run(20, kinds=kinds))
    labels = {text.get_text() for text in axes.get_legend().get_texts()}
    names = {"Trajectory"} if count == 1 else set(kinds)
    assert set(looks) == names and labels == names | {"Start", "Final pose"}
    assert len({look[1:] for look in looks.values()}) == count
    assert sum(look[0] for look in looks.values()) == 20


def test_what_drawings_leave_out_changes_no_bytes(monkeypatch, tmp_path):
    """A figure with a title, one without, and minor ticks of a logarithmic axis that lie on major ones."""

    def drawn(name):
        figure = report.new_figure()
        plain, logarithmic = figure.subplots(2, 1)
        plain.plot([0.0, 3.0], [1.0, 2.0])
        logarithmic.plot([1.0, 2.0], [0.1, 20.0])
        logarithmic.set_yscale("log")
        logarithmic.yaxis.set_minor_locator(LogLocator(subs=(1.0, 2.0), numticks=99))
        logarithmic.yaxis.set_tick_params(which="minor", length=20.0)
        logarithmic.set_title("Title")
        logarithmic.xaxis.tick_top()
        canvas.settle(figure)
        return [
            content(canvas.save(figure, str(tmp_path / (name + kind)))) for kind in (".png", ".pdf")
        ]

    found = drawn("found")
    monkeypatch.setattr(canvas, "_leave_out", lambda figure: None)
    assert drawn("expected") == found
