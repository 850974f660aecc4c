"""One figure of chosen panels, robots and times, by the command ``figure``."""

import numpy as np
import pytest
from PIL import Image

from mrs_simulator import simulate
from mrs_simulator.study.draw.composed_figure import (
    Choice,
    chosen_part,
    composed_figure,
    numbers_in,
)
from mrs_simulator.study.draw.style import LookError, look
from mrs_simulator.study.results.figure_command import main


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    out = tmp_path_factory.mktemp("figure") / "run"
    simulate("paper_four.yaml", duration=6.0, out=str(out))
    return out


@pytest.fixture(scope="module")
def run(directory):
    from mrs_simulator.study.results.report import read_run

    return read_run(str(directory))


def drawn(run, *panels, **choice):
    theory = {"time": run.time, "hand": run.hand + 0.5}
    return composed_figure(run, Choice(panels, **choice), theory, look())


def curves(axes):
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def test_lists_of_robots():
    assert (
        numbers_in("1, 3-5") == (1, 3, 4, 5) and numbers_in(" ") == () and numbers_in("2 2") == (2,)
    )
    for wrong in ("a", "3-1", "-1", "1;2"):
        with pytest.raises(LookError, match="wanted numbers such as 1,3-5"):
            numbers_in(wrong)


def test_a_figure_has_the_robots_times_and_theory_that_were_chosen(run):
    panel = drawn(run, "x", robots=(2, 4), between=(1.0, 3.0)).axes[0]
    lines = curves(panel)
    assert set(lines) == {"Robot 2", "Robot 4", "Theory"}
    kept = (run.time >= 1.0) & (run.time <= 3.0)
    for number in (2, 4):
        own = lines["Robot {}".format(number)]
        np.testing.assert_array_equal(own.get_xdata(), run.time[kept])
        np.testing.assert_array_equal(own.get_ydata(), run.hand[kept, number - 1, 0])
    np.testing.assert_array_equal(lines["Theory"].get_ydata(), run.hand[kept, 1, 0] + 0.5)


def test_panels_stand_in_the_order_chosen_and_share_their_times(run):
    figure = drawn(run, "inputs", "trajectories", "y")
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
    assert labels == [
        ("", "$v$ [m/s]"),
        ("time [s]", r"$\omega$ [rad/s]"),
        ("$x$ [m]", "$y$ [m]"),
        ("time [s]", r"$\alpha_y$ [m]"),
    ]


@pytest.mark.parametrize(
    "choice, said",
    [
        ({"panels": ("q",)}, "unknown 'q'"),
        ({"panels": ()}, "one at least"),
        ({"panels": ("x", "x")}, "each once"),
        ({"panels": ("z",)}, "no robot of this run leaves the ground"),
        ({"robots": (7,)}, "robot 7: wanted those of 1 to 4"),
        ({"between": (9.0, 12.0)}, "there are 0 samples, wanted 2 at least of 0 to 6 s"),
        ({"between": (float("nan"), 1.0)}, "there are 0 samples"),
    ],
)
def test_what_the_run_does_not_have_is_refused(run, choice, said):
    with pytest.raises(LookError, match=said):
        composed_figure(run, Choice(**choice), None, look())


def test_the_command_draws_the_same_bytes_in_the_width_asked_for(directory, tmp_path):
    paths = [tmp_path / name for name in ("a.png", "b.png")]
    for path in paths:
        main([str(directory), "--out", str(path), "--panels", "x,inputs", "--width", "column"])
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert Image.open(str(paths[0])).size[0] == 700  # 3.5 in at 200 dots an inch


def test_the_command_refuses_bad_input_in_one_line(directory, tmp_path, capsys):
    for more, said in (
        (["--out", "a.bmp"], "wanted a file that ends in .png, .pdf, .svg"),
        (["--out", str(tmp_path / "a.pdf"), "--robots", "9"], "wanted those of 1 to 4"),
    ):
        with pytest.raises(SystemExit) as end:
            main([str(directory), *more])
        assert end.value.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith("figure: ") and said in line
    assert not list(tmp_path.iterdir())


def test_collisions_outside_the_times_are_left_out(run):
    from mrs_simulator.record.recording import Collision

    met = run.replace()
    met.collisions = [Collision(time, "robot1", "robot2", 0.0, 0.0) for time in (0.5, 2.0)]
    assert [each.time for each in chosen_part(met, Choice(between=(1.0, 3.0))).collisions] == [2.0]
