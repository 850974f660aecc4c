"""Figures of sweeps: heat maps over two keys, grids over three, and stability maps."""

import itertools
import os

import numpy as np
import pytest

from mrs_simulator.core.stability import growth_rate, share_left
from mrs_simulator.study.draw import sweep_figures
from mrs_simulator.study.draw.canvas import save
from mrs_simulator.study.draw.sweep_figures import stability_figure, sweep_figure
from mrs_simulator.study.run.sweep import (
    SweepError,
    make_runs,
    read_axis,
    run_sweep,
    theorem_boundary,
)

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DELAYED = os.path.join(ROOT, "scenarios", "delayed_consensus.yaml")
GAIN, TAU = "control.parameters.gain", "control.parameters.tau"


def row(measured, passed=True, growth=None, **values):
    check = {"name": "limit [m]", "predicted": 0.0, "measured": measured, "passed": passed}
    return values, {"checks": [check], "growth_rate": growth}


def test_evenly_spaced_values_read_back_alike():
    assert read_axis("k=0.1..0.5/5") == ("k", [0.1, 0.2, 0.3, 0.4, 0.5])
    assert read_axis("k=-1..1e1/2") == ("k", [-1.0, 10.0])
    for bad in ("k=0..1/1", "k=e..1/3", "k=0..1e999/3"):
        with pytest.raises(SweepError, match="wanted"):
            read_axis(bad)


def test_two_keys_give_a_heat_map_of_means_over_the_seeds(tmp_path):
    table = [
        row(10 * a + b + s, a=a, b=b, seed=s) for a in (1, 2) for b in (3, 5, 7) for s in (0, 2)
    ]
    figure = sweep_figure(table, {"a": "m"})
    (image,) = [image for axes in figure.axes for image in axes.images]
    np.testing.assert_allclose(image.get_array(), [[14, 24], [16, 26], [18, 28]])
    assert figure.axes[0].get_xlabel() == "a [m]" and figure.axes[0].get_ylabel() == "b"
    assert os.path.getsize(save(figure, str(tmp_path / "sweep.pdf"))) > 1000


def test_the_second_key_is_not_ignored_and_marks_tell_the_outcome():
    table = [
        row(1.0, a=a, b=b, passed={0: True, 1: False, 2: None}[a]) for a in range(3) for b in (0, 1)
    ]
    axes = sweep_figure(table).axes[0]
    marks = {line.get_marker(): sorted(zip(*line.get_data())) for line in axes.lines}
    assert marks == {"x": [(1, 0), (1, 1)], ".": [(2, 0), (2, 1)]}
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["failed", "not judged"]


def test_robustness_has_a_heat_map_about_zero(tmp_path):
    table = []
    for a, b in itertools.product((0, 1), (0, 1)):
        met = a <= b
        own = {"name": "kept", "unit": "m", "met": met, "low": b - a, "high": b - a - 0.5}
        table.append(({"a": a, "b": b}, {"checks": [], "requirements": [own]}))
    table[0][1]["requirements"][0]["met"] = None  # open: nothing is known, and nothing is drawn
    figure = sweep_figure(table)
    (image,) = [image for axes in figure.axes for image in axes.images]
    shown = np.ma.filled(image.get_array(), np.nan)
    np.testing.assert_array_equal(shown, [[np.nan, -1.5], [1.0, 0.0]])
    assert (image.norm.vmin, image.norm.vmax) == (-1.5, 1.5)
    marks = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert [sorted(zip(*line.get_data())) for line in marks] == [[(1, 0)]]
    assert "robustness of kept\n[m]" in [axes.get_ylabel() for axes in figure.axes]


def test_marks_are_dark_on_bright_cells_and_white_on_dark_ones():
    table = []
    for a, b in itertools.product((0, 1), (0, 1)):
        low = -5.0 if a and b else -0.01  # dark red, and nearly white
        own = {"name": "kept", "unit": "m", "met": False, "low": low, "high": low}
        table.append(({"a": a, "b": b}, {"checks": [], "requirements": [own]}))
    marks = [line for line in sweep_figure(table).axes[0].lines if line.get_marker() == "x"]
    places = {line.get_markeredgecolor(): sorted(zip(*line.get_data())) for line in marks}
    assert places == {"0.35": [(0, 0), (0, 1), (1, 0)], "white": [(1, 1)]}


def test_three_keys_give_a_grid_and_words_are_an_axis():
    table = [row(a, a=a, b=b, c=c) for a in (0.1, 0.2) for b in ("x", "y") for c in (1, 2, 3)]
    figure = sweep_figure(table)
    titles = [axes.get_title() for axes in figure.axes if axes.images]
    assert titles == ["c = 1", "c = 2", "c = 3"]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["x", "y"]


def test_one_key_gives_curves_with_three_outcomes():
    table = [row(k, a=k, passed=[True, False, None][k]) for k in range(3)]
    (axes,) = sweep_figure(table).axes
    names = axes.get_legend_handles_labels()[1]
    assert names == ["passed", "failed", "not judged", "Theory"]
    assert sweep_figure([row(None, a=0), row(None, a=1)]) is None


def test_theory_of_one_value_alone_is_a_mark_not_an_invisible_line():
    table = [row(k, a=k) for k in range(2)]
    table[0][1]["checks"][0]["predicted"] = None
    (line,) = [line for line in sweep_figure(table).axes[0].lines if line.get_label() == "Theory"]
    assert len(line.get_xdata()) == 1 and line.get_marker() == "_"


def test_the_growth_rate_of_an_oscillation_is_that_of_its_envelope():
    time = np.arange(0.0, 60.0, 0.1)
    for rate in (-0.3, 0.1):
        values = np.exp(rate * time) * np.abs(np.cos(2.0 * time)) + 0.0
        values[0] = 1.0
        assert growth_rate(time, values) == pytest.approx(rate, abs=0.01)
    assert growth_rate(time, 0.0 * time) is None
    assert (
        share_left(0.5, 2.0) == 0.75
        and share_left(3.0, 2.0) == -0.5
        and share_left(-1.0, 2.0) < 0.0
    )


def test_the_boundary_is_the_theorems_and_not_the_runs():
    name, margins = theorem_boundary(DELAYED)(
        GAIN, TAU, np.array([0.5, 1.0]), np.array([0.1, 0.4]), {"topology": {"preset": "complete"}}
    )
    # pi/(2 gain lambda_max) with lambda_max = n = 6: 0.5236 s and 0.2618 s.
    np.testing.assert_allclose(margins, [[0.8090, 0.6180], [0.2361, -0.5279]], atol=1e-4)
    assert r"\tau" in name


def test_a_stability_map_draws_the_boundary_between_decay_and_growth(tmp_path, monkeypatch):
    monkeypatch.setattr(
        sweep_figures, "BOUNDARY_POINTS", 12
    )  # between which margins are linear here
    axes = [(GAIN, [0.4, 1.2]), (TAU, [0.2, 0.9]), ("duration", [12.0])]
    given = {"fidelity": "point_mass", "limits": "none"}
    runs = make_runs(DELAYED, axes, given)
    verdicts = run_sweep(runs, str(tmp_path), jobs=1, boundary=theorem_boundary(DELAYED, given))
    for verdict in verdicts:
        # What the condition rules out is measured all the same.
        limit = next(
            c for c in verdict["checks"] if c["name"].startswith("distance from agreement")
        )
        assert limit["measured"] is not None
        assert (verdict["growth_rate"] < 0.0) == (verdict["stability_margin"] > 0.0)
    assert [verdict["stability_margin"] > 0.0 for verdict in verdicts] == [True, True, True, False]
    assert (tmp_path / "stability.png").exists() and (tmp_path / "stability.pdf").exists()
    table = [(values, verdict) for (_, values, _), verdict in zip(runs, verdicts)]
    drawn = stability_figure(table, theorem_boundary(DELAYED, given), {TAU: "s"}).axes[0]
    (line,) = [c for c in drawn.collections if np.all(c.get_linestyle()[0][1] is not None)]
    names = [text.get_text() for text in drawn.get_legend().get_texts()]
    assert names[:2] == ["measured: decays", "measured: grows"] and names[2].startswith("theory: ")
    points = np.concatenate([path.vertices for path in line.get_paths()])
    np.testing.assert_allclose(points[:, 0] * points[:, 1], np.pi / 8.0, rtol=0.02)
    for _, verdict in table[:1]:  # as on the threshold itself
        verdict["growth_rate"] = 1e-16
    legend = stability_figure(table).axes[0].get_legend()
    assert [each.get_text().split()[-1] for each in legend.get_texts()] == [
        "decays", "grows", "neither",
    ]  # fmt: skip
