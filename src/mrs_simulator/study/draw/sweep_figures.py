"""The figures of a sweep: curves over one key, heat maps over two or three, stability maps.

A *table* is a list of rows ``(values by key, verdict)``, one for each run.  Runs that differ in
further keys alone, such as the seed, share a cell, which shows their mean.
"""

import math

import numpy as np
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mrs_simulator.study.draw.canvas import WIDTH, new_figure, settle, styled
from mrs_simulator.study.draw.figure_parts import ABOVE, legend_of_all
from mrs_simulator.verdict.requirements.results import known_bound

PASSED, FAILED, UNJUDGED = "#2e8b57", "#c00000", "#8a8a8a"
POOLED = ("seed",)  # keys that are never an axis where there are others: their runs are averaged
NOT_DRAWN = ("collisions", "ended")
MOST_PANELS = 6  # panels of a third key's values, evenly chosen where there are more
MOST_TICKS = 9
BOUNDARY_POINTS = 33  # along each axis, at which the theorem is asked
ROBUSTNESS = "robustness of {}"
PANEL = 1.7  # [in], height of a heat map
# colours of the marks in the legend, and of cells without a value
CELL, NOTHING = "0.35", "#dddddd"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of red, green, blue
BRIGHT = 0.6  # luminance from which on marks are dark
# [-] of values that ask for a logarithmic scale; of its least value
SPREAD, LEAST_SHARE = 1e3, 1e-9
NEITHER = 1e-6  # [1/s] within which nothing decays or grows: the threshold itself
ROUNDING = 1e-3  # [-] of a value, below which differences are not shown


def varied_keys(table):
    """Return the keys that have more than one value in ``table``; those that are pooled come last."""
    keys = [key for key in table[0][0] if len(_values(table, key)) > 1]
    return sorted(keys, key=lambda key: key in POOLED)


def sweep_figure(table, units=None):
    """Return the figure of all checks in ``table``, or None where there is nothing to draw.

    One varied key of numbers: a panel for each check.  Two keys: a heat map for each check.  Three:
    a row of heat maps for each check, one for each value of the third key.  ``units``: by key.
    """
    series = _series(table)
    keys = varied_keys(table)
    axes = [key for key in keys if key not in POOLED] or keys
    if not series:
        return None
    if len(axes) >= 2:
        return _heat_maps(table, axes[:3], series, units or {})
    numeric = [key for key in axes or list(table[0][0]) if _is_numeric(table, key)]
    return _curves(numeric[0], series, units or {}) if numeric else None


def stability_figure(table, boundary=None, units=None):
    """Return the stability map of ``table``, or None unless two keys of numbers vary.

    Each run is a point: a disc where what was measured decays, a cross where it grows.  The zero line
    of ``boundary``, from ``sweep.theorem_boundary``, is drawn dashed.  ``units``: by key.
    """
    keys = [key for key in varied_keys(table) if key not in POOLED]
    measured = [
        (values, verdict["growth_rate"])
        for values, verdict in table
        if _finite(verdict.get("growth_rate"))
    ]
    if len(keys) != 2 or not measured or not all(_is_numeric(table, key) for key in keys):
        return None
    return _stability_map(keys, measured, boundary, units or {})


# What is drawn


def _values(table, key):
    """Return the distinct values of ``key``, sorted where they are numbers."""
    found = []
    for values, _ in table:
        if values[key] not in found:
            found.append(values[key])
    return sorted(found) if _is_numeric(table, key) else found


def _is_numeric(table, key):
    return all(_finite(values[key]) for values, _ in table)


def _finite(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and math.isfinite(value)


def _series(table):
    """Return by check's name the rows ``(values by key, measured, predicted, passed)``.

    Requirements follow, each with its robustness as what was measured.
    """
    series, robustness = {}, {}
    for values, verdict in table:
        for each in verdict.get("requirements", []):
            name, margin = ROBUSTNESS.format(each["name"]), known_bound(each)
            name += " [{}]".format(each["unit"]) if each["unit"] else ""
            if _finite(margin):
                robustness.setdefault(name, []).append((values, margin, None, each["met"]))
        for check in verdict["checks"]:
            if check["name"] not in NOT_DRAWN and _finite(check["measured"]):
                row = (values, check["measured"], check["predicted"], check["passed"])
                series.setdefault(check["name"], []).append(row)
    return {**series, **robustness}


def axis_label(key, units):
    """Return the last part of a scenario's key and its unit: ``control.rate`` is ``rate [Hz]``."""
    unit = units.get(key, "")
    return key.rpartition(".")[2].replace("_", " ") + (" [{}]".format(unit) if unit else "")


def _two_lines(name):
    return name.replace(" [", "\n[")


# Curves over one key


@styled
def _curves(key, series, units):
    figure = new_figure(WIDTH, 1.2 + 1.6 * len(series))
    panels = figure.subplots(len(series), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, rows) in zip(panels, series.items()):
        _draw_curve(axes, sorted(rows, key=lambda row: row[0][key]), key)
        axes.set_ylabel(_two_lines(name), fontsize=8)
    panels[-1].set_xlabel(axis_label(key, units))
    legend_of_all(panels)
    settle(figure)
    return figure


def _draw_curve(axes, rows, key):
    """Draw measured values: filled green if passed, open red if failed, grey if not judged."""
    for passed, label, style in (
        (True, "passed", {"color": PASSED}),
        (False, "failed", {"mec": FAILED, "mfc": "none"}),
        (None, "not judged", {"mec": UNJUDGED, "mfc": "none", "marker": "s"}),
    ):
        chosen = [(row[0][key], row[1]) for row in rows if row[3] is passed]
        if chosen:
            axes.plot(*zip(*chosen), **{"marker": "o", "ls": "", "ms": 4, "label": label, **style})
    predicted = [(row[0][key], row[2]) for row in rows if _finite(row[2])]
    if predicted:
        alone = "_" if len(predicted) == 1 else ""  # of one point no line is seen
        axes.plot(*zip(*predicted), "k--", lw=1.0, marker=alone, ms=12, label="Theory")


# Heat maps


@styled
def _heat_maps(table, keys, series, units):
    x, y = keys[:2]
    across = _chosen(_values(table, keys[2])) if len(keys) > 2 else [None]
    height = PANEL * len(series) + 0.7
    figure = new_figure(max(WIDTH * 0.75, 1.2 + 1.9 * len(across)), height)
    panels = figure.subplots(len(series), len(across), sharex=True, sharey=True, squeeze=False)
    ticks = _values(table, x), _values(table, y)
    for row, (name, found) in zip(panels, series.items()):
        cells = [
            _cells([r for r in found if value is None or r[0][keys[2]] == value], x, y, *ticks)
            for value in across
        ]
        _draw_row(figure, row, cells, name)
    for axes in panels[-1]:
        _name_ticks(axes.xaxis, ticks[0], axis_label(x, units))
    for axes in panels[:, 0]:
        _name_ticks(axes.yaxis, ticks[1], axis_label(y, units))
    if across != [None]:
        for axes, value in zip(panels[0], across):
            axes.set_title("{} = {}".format(axis_label(keys[2], {}), _shown(value)), fontsize=9)
    _heat_legend(panels[0, 0], series, len(table), across != [None])
    settle(figure)
    return figure


def _chosen(values):
    if len(values) <= MOST_PANELS:
        return values
    return [values[i] for i in np.linspace(0, len(values) - 1, MOST_PANELS).round().astype(int)]


def _cells(rows, x, y, columns, lines):
    """Return ``(means, failed, unjudged)``, each (rows of y, columns of x), of the runs in each cell."""
    shape = len(lines), len(columns)
    total, count = np.zeros(shape), np.zeros(shape)
    failed, unjudged = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for values, measured, _, passed in rows:
        place = lines.index(values[y]), columns.index(values[x])
        total[place] += measured
        count[place] += 1
        failed[place] |= passed is False
        unjudged[place] |= passed is None
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, total / count, np.nan), failed, unjudged


def _draw_row(figure, panels, cells, name):
    means = np.array([mean for mean, _, _ in cells])
    centred = name.startswith(ROBUSTNESS.format(""))
    norm, colours = (about_zero(means), "RdBu") if centred else (scale_of(means), "viridis")
    for axes, (mean, failed, unjudged) in zip(panels, cells):
        image = axes.imshow(
            np.maximum(mean, norm.vmin), origin="lower", aspect="auto", norm=norm, cmap=colours
        )
        axes.grid(False)
        axes.set_facecolor(NOTHING)
        for chosen, marker in ((failed, "x"), (unjudged & ~failed, ".")):
            _mark(axes, marker, chosen, _is_bright(image.to_rgba(np.ma.masked_invalid(mean))))
    bar = figure.colorbar(image, ax=list(panels), pad=0.02, aspect=18)
    bar.set_label(_two_lines(name), fontsize=8)
    if not isinstance(norm, LogNorm):  # whole numbers beside the bar, no "+1" above it
        bar.ax.ticklabel_format(axis="y", useOffset=False)


def _is_bright(cells):
    """Return of the colours ``cells`` (..., 4) whether marks on them have to be dark."""
    return cells[..., :3] @ LUMINANCE > BRIGHT


def _mark(axes, marker, chosen, bright):
    """Draw a ``marker`` on each ``chosen`` cell, in the colour that is seen on it."""
    for on, colour in ((bright, CELL), (~bright, "white")):
        places = np.argwhere(chosen & on)
        if len(places):
            style = {"ls": "", "ms": 5, "mew": 1.1, "mec": colour, "mfc": colour}
            axes.plot(places[:, 1], places[:, 0], marker, **style)


def about_zero(means):
    """Return a scale of colours whose middle is zero, where a requirement breaks."""
    most = float(np.nanmax(np.abs(means))) or 1.0
    return Normalize(-most, most)


def scale_of(means):
    """Return a scale of colours: linear, or logarithmic where values span many powers of ten.

    Values that differ by rounding alone get one colour.
    """
    finite = means[np.isfinite(means)]
    low, high = float(finite.min()), float(finite.max())
    least = LEAST_SHARE * high
    if low >= 0.0 and high > SPREAD * max(float(np.percentile(finite, 25)), least):
        return LogNorm(max(low, least), high)
    room = max(ROUNDING * max(abs(low), abs(high)) - (high - low), 0.0) or float(high <= low)
    return Normalize(low - 0.5 * room, high + 0.5 * room)


def _name_ticks(axis, values, label):
    step = -(-len(values) // MOST_TICKS)
    places = list(range(0, len(values), step))
    axis.set_ticks(places)
    axis.set_ticklabels([_shown(values[place]) for place in places])
    axis.set_label_text(label)


def _shown(value):
    if isinstance(value, float):
        return "{:.3g}".format(value)
    text = str(value)
    return text if len(text) <= 18 else text[:17] + "…"


def _heat_legend(axes, series, most, titled):
    """Name the marks that there are, above the first panel and its title; of ``most`` runs."""
    style = {"ls": "", "mew": 1.1, "mec": CELL, "mfc": CELL, "ms": 6}
    outcomes = {row[3] for rows in series.values() for row in rows}
    marks = ((False, "x", "failed"), (None, ".", "not judged"))
    handles = [
        Line2D([], [], marker=marker, label=label, **style)
        for outcome, marker, label in marks
        if outcome in outcomes
    ]
    if any(len(rows) < most for rows in series.values()):
        handles.append(Patch(facecolor=NOTHING, label="not measurable"))
    if handles:
        place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.12 if titled else 1.0)}
        axes.legend(handles=handles, ncol=3, borderaxespad=0.3, **place)


# Stability maps


@styled
def _stability_map(keys, measured, boundary, units):
    x, y = keys
    figure = new_figure(WIDTH * 0.85, 3.9)
    axes = figure.add_subplot(1, 1, 1)
    rates = np.array([rate for _, rate in measured])
    points = np.array([[values[x], values[y]] for values, _ in measured], dtype=float)
    span = max(float(np.percentile(np.abs(rates), 80)), 1e-12)
    scale = {"norm": TwoSlopeNorm(0.0, -span, span), "cmap": "RdBu_r", "zorder": 3}
    for chosen, marker, label in (
        (rates < -NEITHER, "o", "measured: decays"),
        (rates > NEITHER, "X", "measured: grows"),
        (np.abs(rates) <= NEITHER, "D", "measured: neither"),
    ):
        if chosen.any():
            image = axes.scatter(
                *points[chosen].T, c=rates[chosen], marker=marker, s=42,
                edgecolors="0.25", linewidths=0.5, label=label, **scale
            )  # fmt: skip
    bar = figure.colorbar(image, ax=axes, pad=0.02, extend="both")
    bar.set_label("measured growth rate [1/s]")
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.06 * np.maximum(high - low, 1e-9)
    handles, names = axes.get_legend_handles_labels()
    handles = [
        Line2D([], [], ls="", marker=m, mfc="0.7", mec="0.25", ms=6) for m in _markers(names)
    ]
    if boundary is not None:
        others = {key: value for key, value in measured[0][0].items() if key not in keys}
        line = _draw_boundary(axes, boundary, (*keys, others), low - margin, high + margin)
        handles, names = handles + line[0], names + line[1]
    axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
    axes.set_ylim(low[1] - margin[1], high[1] + margin[1])
    axes.set_xlabel(axis_label(x, units))
    axes.set_ylabel(axis_label(y, units))
    axes.legend(handles, names, ncol=3 if len(names) < 4 else 2, **ABOVE)
    settle(figure)
    return figure


def _markers(names):
    return [{"decays": "o", "grows": "X", "neither": "D"}[name.split()[-1]] for name in names]


def _draw_boundary(axes, boundary, keys, low, high):
    """Draw the theorem's boundary; return its legend's handles and names, none where it is outside.

    ``keys``: (x key, y key, values of the others).
    """
    name, known = boundary_within(boundary, keys, low, high)
    if known is None:
        return [], []
    style = {"levels": [0.0], "colors": "k", "linewidths": 1.6, "linestyles": "dashed"}
    axes.contour(*known, zorder=2, **style)
    return [Line2D([], [], color="k", ls="--", lw=1.6)], ["theory: " + name]


def boundary_within(boundary, keys, low, high):
    """Return the name of the theorem's threshold, "" without one, and what contours take of its margins.

    x values, y values and margins (rows y, columns x), whose zero line is the ``boundary``; None where it
    does not lie between ``low`` and ``high``, (2,).  ``keys``: (x key, y key, values of the others).
    """
    for grids in _boundary_grids(low, high):
        name, margins = boundary(*keys[:2], *grids, keys[2])
        finite = np.isfinite(margins)
        # Between whole numbers of robots, say, there is no scenario.
        if finite.any(axis=0).sum() < 2 or finite.any(axis=1).sum() < 2:
            continue
        crosses = margins[finite].min() < 0.0 < margins[finite].max()
        return name, (*grids, np.ma.masked_invalid(margins)) if crosses else None
    return "", None


def _boundary_grids(low, high):
    """Yield (x values, y values) from ``low`` to ``high``, (2,): real ones, then whole for x, y, both."""
    real = [np.linspace(a, b, BOUNDARY_POINTS) for a, b in zip(low, high)]
    whole = [np.arange(math.ceil(a), math.floor(b) + 1) for a, b in zip(low, high)]
    yield real
    yield whole[0], real[1]
    yield real[0], whole[1]
    yield whole
