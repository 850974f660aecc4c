"""Logarithmic axes have labels that can be read, whatever is in view."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mrs_simulator.study.draw.log_ticks import label_log


def labels(low, high, height=3.0):
    figure = Figure(figsize=(6.0, height))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(1, 1, 1)
    axes.set_yscale("log")
    label_log(axes.yaxis)
    axes.set_ylim(low, high)
    figure.canvas.draw()
    found = [(tick.get_loc(), tick.label1.get_text()) for tick in axes.yaxis.get_major_ticks()]
    minor = [tick.label1.get_text() for tick in axes.yaxis.get_minor_ticks()]
    assert not any(minor)
    return [(place, text) for place, text in found if low <= place <= high and text]


@pytest.mark.parametrize(
    "low, high",
    [(1.2, 3.4), (0.5, 9.0), (0.93, 1.02), (2.3, 2.4), (0.08, 0.9), (0.004, 12.0), (1e-12, 30.0)]
    + [(2e-5, 9e-5), (1.5e-7, 2e-6), (110.0, 870.0)],
)
def test_at_least_three_labels_are_in_view_and_say_where_they_are(low, high):
    found = labels(low, high)
    assert 3 <= len(found) <= 12
    plain = [(place, text) for place, text in found if "$" not in text]
    assert all(float(text) == pytest.approx(place, rel=1e-5) for place, text in plain)
    assert len({text for _, text in found}) == len(found)


def test_wide_ranges_have_powers_of_ten_alone():
    found = labels(1e-6, 50.0)
    assert all("$" in text for _, text in found)
    exponents = np.log10([place for place, _ in found])
    np.testing.assert_allclose(exponents, exponents.round(), atol=1e-9)


def test_small_ranges_have_round_numbers():
    assert [text for _, text in labels(0.4, 9.0)] == ["0.5", "1", "2", "5"]


def test_labels_have_room_in_a_low_picture():
    found = labels(1e-12, 30.0, height=1.0)
    assert 2 <= len(found) <= 4 and all("$" in text for _, text in found)
    assert 2 <= len(labels(0.5, 90.0, height=0.8)) <= 4
