"""How figures for a paper look: width and style."""

import contextlib
import os
import sys
from importlib.util import find_spec
from typing import Any, Dict, NamedTuple

WIDTHS = {"page": 6.5, "column": 3.5, "slide": 9.0}  # [in]
FORMATS = ("png", "pdf", "svg")
NARROW = 5.0  # [in] below it text is that of a column
COLUMN_STYLE = {
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.handlelength": 1.4,
    "legend.columnspacing": 1.0,
}
MISSING = "matplotlib is not installed: no figures are drawn, wanted `pip install matplotlib`"
NARROWEST, WIDEST = 1.5, 40.0  # [in]
INCH = {"in": 1.0, "cm": 1.0 / 2.54, "mm": 1.0 / 25.4, "pt": 1.0 / 72.27}


class LookError(ValueError):
    """A width or style that cannot be had; the message names it and what was wanted."""

    page = "docs/figures.md"


class Look(NamedTuple):
    """``width`` [in] of figures, rcParams of matplotlib that go over the paper's own style, and what
    files carry as metadata, a hash of what went into their run."""

    width: float = WIDTHS["page"]
    style: Dict[str, Any] = {}
    stamp: str = ""

    def scaled(self, height):
        """Return the height [in] of a figure that is ``height`` high at a page's width."""
        return height * max(0.62, self.width / WIDTHS["page"])


def look(width="", style=""):
    """Return the ``Look`` of a ``width`` and a ``style``, "" for the usual ones.

    ``width``: a key of ``WIDTHS``, a number of inches, or a text with a unit such as ``"88 mm"``;
    ``style``: a mapping of rcParams, the name of one of matplotlib's styles, or the path of an
    ``.mplstyle`` file.  Raises ``LookError``.
    """
    inches = _inches(width) if width != "" else WIDTHS["page"]
    own = dict(COLUMN_STYLE) if inches < NARROW else {}
    own.update(_parameters(style) if style else {})
    return Look(inches, own)


def _inches(width):
    if width in WIDTHS:
        return WIDTHS[width]
    text, factor = str(width).strip(), 1.0
    if text[-2:] in INCH:
        text, factor = text[:-2], INCH[text[-2:]]
    with contextlib.suppress(ValueError):
        inches = float(text) * factor
        if NARROWEST <= inches <= WIDEST:
            return inches
    raise LookError(
        "width {!r}: wanted {}, or from {:g} to {:g} in, such as 88mm".format(
            width, ", ".join(WIDTHS), NARROWEST, WIDEST
        )
    )


def _parameters(style):
    """Return the rcParams of ``style``, checked."""
    import matplotlib  # slow to import
    from matplotlib import style as named_styles

    if isinstance(style, dict):
        given = style
    elif style in named_styles.library:
        given = named_styles.library[style]
    elif os.path.isfile(style):
        given = matplotlib.rc_params_from_file(style, use_default_template=False)
    else:
        text = "style {!r}: neither a file nor a style of matplotlib ({}, ...)"
        raise LookError(text.format(style, ", ".join(named_styles.available[:3])))
    try:
        return dict(matplotlib.RcParams(given))
    except (KeyError, ValueError) as error:
        raise LookError("style: {}".format(error)) from None


def check_formats(formats):
    """Raise ``LookError`` for a format that figures cannot have."""
    for wanted in formats:
        if wanted not in FORMATS:
            raise LookError("figure format {!r}, wanted one of {}".format(wanted, FORMATS))


def add_look(parser):
    """Give ``parser`` the options ``--width``, ``--style`` and ``--formats``; ``look_of`` takes them."""
    add_width_and_style(parser)
    parser.add_argument("--formats", default="png,pdf", help="of figures: png, pdf, svg")


def add_width_and_style(parser):
    """Give ``parser`` the options ``--width`` and ``--style``, which ``look`` takes."""
    parser.add_argument(
        "--width", default="", help="of figures: page (6.5 in), column (3.5 in), slide, 88mm, 3.4in"
    )
    parser.add_argument(
        "--style", default="", help="of figures: an .mplstyle file, or a style of matplotlib"
    )


def look_of(arguments):
    """Return the ``Look`` and the formats that the options of ``add_look`` ask for.

    No formats, with a message on standard error, where there is no matplotlib.
    """
    formats = [kind.strip() for kind in arguments.formats.split(",") if kind.strip()]
    check_formats(formats)
    return look(arguments.width, arguments.style), formats if formats and can_draw() else []


def can_draw():
    """Return whether matplotlib is installed; where it is not, say so on standard error."""
    if find_spec("matplotlib") is None:
        print(MISSING, file=sys.stderr)
        return False
    return True
