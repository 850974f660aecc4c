"""PNG files as the product writes them, against those that matplotlib writes."""

import io

import numpy as np
import pytest

from mrs_simulator.study.draw.canvas import new_figure, print_settled, settle, styled
from mrs_simulator.study.draw.png import png

Image = pytest.importorskip("PIL.Image")
TEXTS = {"Description": "inputs sha256 0a1b"}


@styled
def both_ways():
    """Return the same drawing, part of it transparent, written here and by matplotlib."""
    figure = new_figure(3.0, 2.0)
    figure.subplots().plot([0.0, 1.0, 2.0], [1.0, 3.0, 2.0])
    figure.patch.set_alpha(0.4)
    settle(figure)
    ours, theirs = io.BytesIO(), io.BytesIO()
    print_settled(figure, ours, "png", TEXTS)
    figure.dpi = 200.0
    figure.canvas.print_png(theirs, metadata=TEXTS)
    return ours, theirs


def test_pixels_texts_and_scale_are_those_of_matplotlibs_file():
    ours, theirs = map(Image.open, both_ways())
    assert (ours.mode, ours.size) == (theirs.mode, theirs.size) == ("RGBA", (600, 400))
    np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))
    assert len(np.unique(np.asarray(ours)[..., 3])) > 1
    assert ours.info == theirs.info and ours.info["Description"] == TEXTS["Description"]


def test_files_are_whole_and_no_larger_than_matplotlibs():
    ours, theirs = both_ways()
    Image.open(ours).verify()  # each chunk's check sum
    assert len(ours.getvalue()) < 1.1 * len(theirs.getvalue())


def test_the_same_pixels_give_the_same_bytes():
    pixels = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4)
    written = png(pixels, 72.0, {})
    assert written == png(pixels.copy(order="F"), 72.0, {})
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(written))), pixels)
