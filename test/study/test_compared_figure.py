"""Runs laid over each other in one figure, and its panel of the formation error."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from mrs_simulator import simulate
from mrs_simulator.study.draw import composed_figure as module
from mrs_simulator.study.draw.compared_panels import NamedRun, TeamError
from mrs_simulator.study.draw.composed_figure import Choice, composed_figure
from mrs_simulator.study.draw.figure_parts import PALETTE, RUN_DASHES
from mrs_simulator.study.draw.style import LookError, look
from mrs_simulator.study.results import figure_command
from mrs_simulator.study.results.report import read_run

GAINS = (0.02, 0.05)


@pytest.fixture(scope="module")
def directories(tmp_path_factory):
    outs = [tmp_path_factory.mktemp("compared") / name for name in ("slow", "fast")]
    for out, gain in zip(outs, GAINS):
        simulate("paper_four.yaml", parameters={"k": gain}, duration=6.0, out=str(out))
    return list(map(str, outs))


@pytest.fixture(scope="module")
def runs(directories):
    return [read_run(path) for path in directories]


def drawn(runs, *panels, names=("slow", "fast"), **choice):
    """Return the figure of two runs whose errors are 1 and 2 [m], and theory's half of that."""
    errors = [
        TeamError(run.time, np.full(len(run.time), k), (run.time, np.full(len(run.time), 0.5 * k)))
        for run, k in zip(runs, (1.0, 2.0))
    ]
    other = NamedRun(names[1], runs[1], errors[1])
    given = errors[0], names[0], [other]
    return composed_figure(runs[0], Choice(panels, **choice), None, look(), *given)


def of_points(axes):
    """Return the lines of ``axes`` that have points along which something moves."""
    return [line for line in axes.lines if len(line.get_xdata()) > 10]


def test_each_runs_paths_and_curves_have_its_line_and_the_robots_colours(runs):
    paths, curves = drawn(runs, "trajectories", "x").axes
    for axes, moving in ((paths, 3), (curves, 4)):  # the last robot stands
        lines = of_points(axes)
        found = {(to_hex(line.get_color()), line.get_linestyle() == "-") for line in lines}
        assert found == {(c, solid) for c in PALETTE[:moving] for solid in (True, False)}
        names = [text.get_text() for text in axes.get_legend().get_texts()]
        assert names.count("slow") == names.count("fast") == 1 and "Trajectory" not in names
    for row in range(4):
        own, other = of_points(curves)[row], of_points(curves)[4 + row]
        for line, run in ((own, runs[0]), (other, runs[1])):
            np.testing.assert_array_equal(line.get_ydata(), run.pose[:, row, 0])
            np.testing.assert_array_equal(line.get_xdata(), run.time)


def look_of(line):
    return to_hex(line.get_color()), line.get_linestyle(), line.get_marker()


@pytest.mark.parametrize("n, marked", [(7, 0), (10, 3), (12, 5)])
def test_robots_that_share_a_colour_differ_by_marks_and_runs_by_their_lines(n, marked, tmp_path):
    runs = []
    for gain in (0.2, 0.6):
        out = str(tmp_path / str(gain))
        simulate("consensus.yaml", robots=n, parameters={"gain": gain}, duration=2.0, out=out)
        runs.append(read_run(out))
    figure = drawn(runs, "x", "inputs")
    for axes in figure.axes:
        lines = of_points(axes)
        assert len(lines) == 2 * n and len(set(map(look_of, lines[:n]))) == n
        assert len(set(map(look_of, lines))) == 2 * n
        assert sum(line.get_marker() == "o" for line in lines) == 2 * marked
    names = {text.get_text() for text in figure.axes[0].get_legend().get_texts()}
    assert names >= {"Robot {}".format(number) for number in range(1, n + 1)}


def test_the_error_panel_has_each_run_and_its_theory_by_name(runs):
    (axes,) = drawn(runs, "error", between=(1.0, 3.0)).axes
    by_name = {line.get_label(): line for line in axes.lines}
    assert list(by_name) == ["slow", "Theory, slow", "fast", "Theory, fast"]
    assert axes.get_yscale() == "log"
    for name, value in (("slow", 1.0), ("fast", 2.0)):
        run, theory = by_name[name], by_name["Theory, " + name]
        assert (run.get_ydata() == value).all() and (theory.get_ydata() == 0.5 * value).all()
        assert run.get_xdata()[0] >= 1.0 and run.get_xdata()[-1] <= 3.0
        assert run.get_color() == theory.get_color()
        assert run.get_linestyle() == theory.get_linestyle()
    assert by_name["slow"].get_color() != by_name["fast"].get_color()
    assert by_name["slow"].get_linestyle() != by_name["fast"].get_linestyle()


def test_a_lone_run_beside_theory(runs):
    error = TeamError(runs[0].time, runs[0].time + 1.0, (runs[0].time, runs[0].time + 2.0))
    (axes,) = composed_figure(runs[0], Choice(("error",)), None, look(), error).axes
    assert [line.get_label() for line in axes.lines] == ["Run", "Theory"]


def test_lines_of_runs_differ():
    assert len(set(map(str, RUN_DASHES))) == len(RUN_DASHES) == 5


def test_only_robots_that_the_first_run_has_are_drawn(runs):
    part = module.chosen_part(runs[0], Choice(robots=(1, 2)))
    (axes,) = drawn([part, runs[1]], "x").axes
    assert len(of_points(axes)) == 4
    with pytest.raises(LookError, match="fast: has none of the robots"):
        lone = module.chosen_part(runs[1], Choice(robots=(4,)))
        drawn([part, lone], "x")


def test_no_error_is_refused(runs):
    with pytest.raises(LookError, match="defines no formation error"):
        composed_figure(runs[0], Choice(("error",)), None, look())


def test_the_command_lays_runs_over_each_other(directories, tmp_path, monkeypatch):
    seen = []

    def figure(run, choice, prediction, own_look, *given):
        seen.append((run, choice, prediction, *given))
        return composed_figure(run, choice, prediction, own_look, *given)

    monkeypatch.setattr(module, "composed_figure", figure)
    words = [directories[0], "--compare", directories[1], "--panels", "x,error"]
    paths = [tmp_path / name for name in ("a.pdf", "b.pdf")]
    for path in paths:
        figure_command.main([*words, "--out", str(path)])
    assert paths[0].read_bytes() == paths[1].read_bytes()
    run, _, prediction, error, name, others = seen[0]
    assert prediction is None and name == "slow" and [each.name for each in others] == ["fast"]
    errors = [error, others[0].error]
    assert all(each.values[-1] < 0.7 * each.values[0] for each in errors)
    assert errors[0].values[-1] != errors[1].values[-1]
    for each in errors:
        assert each.theory[1][0] == pytest.approx(each.values[0])
        assert each.theory[0][0] == each.time[0] == run.time[0]
        assert each.theory[0][-1] == pytest.approx(each.time[-1])
    figure_command.main([*words, "--no-theory", "--names", "one", "two", "--out", str(paths[0])])
    assert seen[-1][4] == "one" and seen[-1][5][0].name == "two" and seen[-1][3].theory is None


@pytest.mark.parametrize(
    "names, said", [(["a"], "1 names, wanted 2"), (["a", "a"], "all different")]
)
def test_the_command_refuses_names_that_do_not_fit(directories, tmp_path, capsys, names, said):
    words = [directories[0], "--compare", directories[1], "--out", str(tmp_path / "a.png")]
    with pytest.raises(SystemExit):
        figure_command.main([*words, "--names", *names])
    assert said in capsys.readouterr().err
