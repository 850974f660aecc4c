"""The figure of margins: along each axis, how far each requirement holds."""

from matplotlib.lines import Line2D

from mrs_simulator.study.draw.canvas import new_figure, settle, styled
from mrs_simulator.study.draw.sweep_figures import FAILED, PASSED
from mrs_simulator.study.search.margins import acts

STRIP, REST = 0.2, 0.62  # [in], height of one requirement's bar, and of the rest of an axis
BEYOND = 0.03  # [-] of an axis, drawn beyond its ends
LEGEND, WIDE = 0.3, 5.0  # [in], height of a row, and width that four entries need
CORNER, NEUTRAL = "tab:blue", "0.75"
WORDS = {  # with units, for the usual axes
    "mismatch.delay": "delay of commands [s]",
    "links.loss": "share of lost messages [-]",
    "control.rate": "rate of commands [Hz]",
    "mismatch.speed": "speed over commanded speed [-]",
    "mismatch.track": "track over its nominal value [-]",
    "noise": "noise over that of the scenario [-]",
}


@styled
def margins_figure(report, width):
    """Return the figure of a ``report`` of the program ``margins``, ``width`` [in] wide.

    A panel for each axis, in its own unit from the nominal value on; a bar for each requirement, up to
    where it breaks, grey along an axis of no effect; where several differ together, the corner at which
    one breaks first.
    """
    panels, names = {}, list(report["nominal"])
    corner = (report.get("together") or {}).get("corner") or {}
    for axis in report["axes"]:
        panels.setdefault(axis["key"], []).append(axis)
    handles = _legend(corner, all(map(acts, report["axes"])))
    columns = len(handles) if len(handles) < 4 or width >= WIDE else 2
    rows = -(-len(handles) // columns)
    figure = new_figure(width, LEGEND * rows + len(panels) * (REST + STRIP * len(names)))
    for row, (key, axes) in enumerate(panels.items()):
        panel = figure.add_subplot(len(panels), 1, row + 1)
        _draw_axes(panel, axes, names)
        if key in corner:
            panel.axvline(corner[key], color=CORNER, linestyle="-.", linewidth=1.0)
        unit = axes[0]["unit"]
        panel.set_xlabel(WORDS.get(key, "{} [{}]".format(key, unit) if unit else key))
        if row == 0:
            place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
            panel.legend(handles=handles, ncol=columns, **place)
    settle(figure)
    return figure


def _legend(corner, all_act):
    idle = Line2D([], [], color=NEUTRAL, linewidth=6.0, label="no effect")
    worst = Line2D([], [], color=CORNER, linestyle="-.", label="worst corner, together")
    return [
        Line2D([], [], color="0.2", linestyle=":", label="scenario"),
        Line2D([], [], color=PASSED, linewidth=6.0, label="holds"),
        Line2D([], [], color=FAILED, marker="x", linestyle="", markersize=6.0, label="breaks"),
        *([] if all_act else [idle]),
        *([worst] if corner else []),
    ]


def _draw_axes(panel, axes, names):
    """Draw the bars of ``axes`` of one key, all of which begin at its nominal value."""
    ends = [axes[0]["nominal"], *(axis["end"] for axis in axes)]
    for axis in axes:
        color = PASSED if acts(axis) else NEUTRAL
        for row, name in enumerate(names):
            pair = axis["breaks"][name]
            bar = [axis["nominal"], pair[0] if pair else axis["end"]]
            panel.plot(bar, [row, row], color=color, linewidth=6.0, solid_capstyle="butt")
            if pair:
                panel.plot([pair[1]], [row], "x", color=FAILED, markersize=6.0)
    panel.axvline(ends[0], color="0.2", linestyle=":", linewidth=1.0)
    panel.set_yticks(range(len(names)))
    panel.set_yticklabels(names)
    panel.set_ylim(len(names) - 0.4, -0.6)
    margin = BEYOND * (max(ends) - min(ends))
    panel.set_xlim(min(ends) - margin, max(ends) + margin)
    panel.grid(axis="y", visible=False)
