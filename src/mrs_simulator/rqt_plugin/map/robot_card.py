"""What the map says of the robot selected: pose, speeds, command, neighbours, distance to its target."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map.style import faded
from mrs_simulator.rqt_plugin.qt.QtCore import QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPen
from mrs_simulator.sensors.number_texts import degrees, number
from mrs_simulator.state.columns import COMMAND, TWIST, Z

MOST_NAMED = 8  # [-] neighbours
WIDEST = 0.6  # [-] of the map's width
NONE = "none"


def card_lines(team, edges, directed, targets, chosen):
    """Return lines of text on the robot numbered ``chosen``, none where it is not in the ``MapTeam``.

    ``edges``: (receiver, sender, weight), by numbers; ``targets``: (n, d) [m] or None.
    """
    if chosen not in team.numbers:
        return []
    row, state = team.numbers.index(chosen), team.state
    lines = ["Robot {}".format(chosen), _pose(state, row)]
    if state.has(TWIST):
        along, across, turn = state.twist[row]
        speed = along if not across else float(np.hypot(along, across))
        lines.append("v {}, \u03c9 {}".format(number(speed, 2, " m/s"), number(turn, 2, " rad/s")))
    if state.has(COMMAND):
        lines.append("command {}".format(_command(state.axes, state.command[row])))
    lines += _neighbours(edges, directed, chosen)
    if targets is not None and len(targets) == len(team.numbers):
        away = float(np.hypot(*(targets[row, :2] - team.pose[row, :2])))
        lines.append("{} from its target".format(number(away, 2, " m")))
    return lines


def _pose(state, row):
    x, y, theta = state.pose[row]
    place = [number(x, 2), number(y, 2)] + ([number(state.z[row], 2)] if state.has(Z) else [])
    turned = (
        degrees(math.remainder(theta, 2.0 * math.pi)) if math.isfinite(theta) else number(theta, 0)
    )
    return "({}) m, \u03b8 {}".format(", ".join(place), turned)


def _command(axes, command):
    units = (" rad/s" if axis.startswith("angular") else " m/s" for axis in axes)
    return ", ".join(number(float(value), 2, unit) for value, unit in zip(command, units))


def _neighbours(edges, directed, chosen):
    """Return from whom the robot receives, and to whom it sends; of an undirected graph one line."""
    senders = sorted({j for i, j, _ in edges if i == chosen})
    receivers = sorted({i for i, j, _ in edges if j == chosen})
    if not directed:
        return ["neighbours: {}".format(_listed(sorted({*senders, *receivers})))]
    texts = "receives from: {}", "sends to: {}"
    return [text.format(_listed(who)) for text, who in zip(texts, (senders, receivers))]


def _listed(numbers):
    more = ["..."] if len(numbers) > MOST_NAMED else []
    return ", ".join([*map(str, numbers[:MOST_NAMED]), *more]) or NONE


def draw_card(painter, style, frame, lines, shade):
    """Draw ``lines`` on a card in the upper right corner, with a rim in the robot's ``shade``."""
    area, line, metrics = frame.area, style.line, painter.fontMetrics()
    wide = max(map(metrics.horizontalAdvance, lines)) + 1.2 * line
    if wide > WIDEST * area.width():
        return  # it would hide the team
    box = QRectF(
        area.right() - 0.4 * line - wide,
        area.top() + 0.4 * line,
        wide,
        (1.1 * len(lines) + 0.4) * line,
    )
    painter.setPen(QPen(style.mixed(0.25), 1))
    painter.setBrush(faded(style.base, 0.85))
    painter.drawRect(box)
    painter.fillRect(QRectF(box.left(), box.top(), 0.3 * line, box.height()), shade)
    painter.setPen(style.text)
    for row, text in enumerate(lines):
        place = QRectF(
            box.left() + 0.7 * line, box.top() + (0.2 + 1.1 * row) * line, wide, 1.1 * line
        )
        painter.drawText(place, Qt.AlignLeft | Qt.AlignVCenter, text)
