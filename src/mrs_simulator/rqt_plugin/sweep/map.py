"""The sweep map: a cell for each run, theory's boundary over them, a colour bar and a legend."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map.style import MapStyle, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, QRectF, QSize, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPainter, QPen
from mrs_simulator.rqt_plugin.qt.QtWidgets import QSizePolicy, QToolTip, QWidget
from mrs_simulator.rqt_plugin.sweep.cells import MARGIN, UNITS, scale_for
from mrs_simulator.rqt_plugin.sweep.legend import (
    BAR,
    DASHES,
    UNKNOWN,
    WAITING,
    draw_bar,
    draw_legend,
    draw_mark,
    draw_upwards,
)
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic
from mrs_simulator.study.draw.sweep_figures import axis_label
from mrs_simulator.verdict.verdict import PASSED

LEAST = 12, 9  # [lines of text] least width and height
ARROWS = {Qt.Key_Left: (0, -1), Qt.Key_Right: (0, 1), Qt.Key_Up: (1, 0), Qt.Key_Down: (-1, 0)}


@guarded
class SweepMap(QWidget):
    """Paints ``SweepCells``; a click on a cell asks for its run."""

    cell_asked = Signal(str)  # the name of a run that has ended

    def __init__(self, parent=None):
        super().__init__(parent)
        self.cells, self.quantity = None, MARGIN
        self._current, self._opened, self._hovered = None, "", None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    def minimumSizeHint(self):
        """Return a size in which labels, bar and some cells fit."""
        return QSize(*(each * self.fontMetrics().height() for each in LEAST))

    def sizeHint(self):
        """Return twice the least size."""
        return 2 * self.minimumSizeHint()

    def show_cells(self, cells, quantity):
        """Show ``SweepCells``, None for none, coloured by the quantity of that name."""
        if cells is not self.cells:
            self._current = self._hovered = None
        self.cells, self.quantity = cells, quantity
        self.update()

    def show_opened(self, run):
        """Mark the cell of the ``run`` that is shown, "" for none."""
        if run != self._opened:
            self._opened = run
            self.update()

    # Where things are ----------------------------------------------------------------------------

    def area(self):
        """Return the rectangle [px] of all cells."""
        line, metrics = self.fontMetrics().height(), self.fontMetrics()
        labels = [_number(value) for value in self.cells.values[1]]
        left = max(map(metrics.horizontalAdvance, labels)) + 2.0 * line
        bar = (BAR + 4.4) * line + metrics.horizontalAdvance("\u2212000")
        area = QRectF(self.rect()).adjusted(left, 1.9 * line, -bar, -2.7 * line)
        return QRectF(area.x(), area.y(), max(1.0, area.width()), max(1.0, area.height()))

    def _to_screen(self, places):
        """Return where ``places`` (m, 2), in cells, are [px]."""
        area, (rows, columns) = self.area(), self.cells.cells.shape
        x = area.left() + (places[:, 0] + 0.5) / columns * area.width()
        return np.column_stack([x, area.bottom() - (places[:, 1] + 0.5) / rows * area.height()])

    def cell_box(self, row, column):
        """Return the rectangle [px] of a cell."""
        corners = np.array([[column - 0.5, row + 0.5], [column + 0.5, row - 0.5]])
        return QRectF(*(QPointF(*corner) for corner in self._to_screen(corners)))

    def _cell_at(self, position):
        if self.cells is None:
            return None
        area, (rows, columns) = self.area(), self.cells.cells.shape
        x = (position.x() - area.left()) / area.width() * columns - 0.5
        return self.cells.at(x, (area.bottom() - position.y()) / area.height() * rows - 0.5)

    # Mouse and keys ------------------------------------------------------------------------------

    def mouseMoveEvent(self, event):
        """Tell of the cell under the mouse."""
        place = self._cell_at(event.pos())
        if place != self._hovered:
            self._hovered = place
            self.update()
        QToolTip.showText(event.globalPos(), self.text_of(place) if place else "", self)

    def leaveEvent(self, event):
        """Mark no cell any longer."""
        self._hovered = None
        self.update()
        super().leaveEvent(event)

    def mousePressEvent(self, event):
        """Ask for the run of the cell under the mouse."""
        place = self._cell_at(event.pos()) if event.button() == Qt.LeftButton else None
        if place is not None:
            self._choose(place)
            self.ask(place)

    def keyPressEvent(self, event):
        """Go from cell to cell by arrows; Return asks for the run."""
        if self.cells is None or event.key() not in (*ARROWS, Qt.Key_Return, Qt.Key_Enter):
            super().keyPressEvent(event)
            return
        if event.key() not in ARROWS:
            if self._current is not None:
                self.ask(self._current)
            return
        shape, current = self.cells.cells.shape, self._current
        step = ARROWS[event.key()] if current is not None else (0, 0)
        moved = [a + b for a, b in zip(current or (0, 0), step)]
        self._choose(tuple(min(max(0, a), n - 1) for a, n in zip(moved, shape)))

    def _choose(self, place):
        self._current = place
        self.setAccessibleDescription(self.text_of(place))
        self.update()

    def ask(self, place):
        """Ask for the run of the cell at ``place`` (row, column), if it has ended."""
        cell = self.cells.cells[place]
        if cell is not None and cell.outcome:
            self.cell_asked.emit(cell.run)

    def text_of(self, place):
        """Return what is known of the cell at ``place`` (row, column), in lines."""
        cells, cell = self.cells, self.cells.cells[place]
        values = cells.values[0][place[1]], cells.values[1][place[0]]
        pairs = zip(cells.keys, values)
        lines = [", ".join("{} = {}".format(_label(k, cells.units), _number(v)) for k, v in pairs)]
        if cell is None:
            return lines[0]
        if cell.holds is not None or cell.why:
            word = {True: "its theorem holds", False: "it fails", None: "no theorem applies"}
            why = ": " + cell.why if cell.why else ""
            lines.append("theory: {}{}".format(word[cell.holds], why))
        if not cell.outcome:
            return "\n".join([*lines, "not run yet"])
        lines.append("run: {}".format(cell.outcome))
        if cell.ended != "complete":
            lines.append(cell.ended)
        for name, value in cell.measured.items():
            if value is not None:
                lines.append("{}: {:.4g}".format(_with_unit(name), value))
        if cell.worst and cell.worst != cell.ended:
            lines.append("least margin: {}".format(cell.worst))
        return symbolic("\n".join([*lines, "click: show the run"]))

    # Painting ------------------------------------------------------------------------------------

    def paintEvent(self, _):
        """Paint all of it."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.Antialiasing)
        style = MapStyle.of(self)
        painter.fillRect(self.rect(), style.base)
        if self.cells is None:
            return
        values = self.cells.measured(self.quantity)
        scale = scale_for(self.quantity, values)
        self._paint_cells(painter, style, values, scale)
        self._paint_lines(painter, style)
        self._paint_chosen(painter, style)
        self._paint_axes(painter, style)
        draw_legend(painter, style, self.area(), self.width(), self.cells, values)
        if scale is not None:
            draw_bar(painter, style, self.area(), scale, symbolic(_with_unit(self.quantity)))

    def _boxes(self):
        """Return the rectangles [px] of all cells by their places, faster than one by one."""
        area, (rows, columns) = self.area(), self.cells.cells.shape
        x = np.linspace(area.left(), area.right(), columns + 1).tolist()
        y = np.linspace(area.bottom(), area.top(), rows + 1).tolist()
        return {
            (row, column): QRectF(
                x[column], y[row + 1], x[column + 1] - x[column], y[row] - y[row + 1]
            )
            for row, column in np.ndindex(rows, columns)
        }

    def _paint_cells(self, painter, style, values, scale):
        painter.setRenderHint(QPainter.Antialiasing, False)
        shades = None if scale is None else scale.shades(values).tolist()
        finite, boxes = np.isfinite(values).tolist(), self._boxes()
        waiting, unknown = style.mixed(WAITING), style.mixed(UNKNOWN)
        for (row, column), cell in np.ndenumerate(self.cells.cells):
            shade = waiting
            if cell is not None and cell.outcome:
                shade = QColor(*shades[row][column]) if finite[row][column] else unknown
            painter.fillRect(boxes[row, column].adjusted(0.5, 0.5, -0.5, -0.5), shade)
        painter.setRenderHint(QPainter.Antialiasing)
        for place, cell in np.ndenumerate(self.cells.cells):
            if cell is not None and cell.outcome not in ("", PASSED):
                box = boxes[place]
                size = min(0.22 * min(box.width(), box.height()), 0.35 * style.line)
                draw_mark(painter, style, box.center(), size, cell.outcome)

    def _paint_lines(self, painter, style):
        painter.save()
        painter.setClipRect(self.area())
        for colour, width, dashes in ((style.base, 4.0, None), (style.text, 1.8, DASHES)):
            pen = QPen(colour, width * style.unit)
            pen.setCapStyle(Qt.FlatCap)
            if dashes:
                pen.setDashPattern(dashes)
            painter.setPen(pen)
            for line in self.cells.lines:
                painter.drawPolyline(polygon(self._to_screen(line)))
        painter.restore()

    def _paint_chosen(self, painter, style):
        painter.setBrush(Qt.NoBrush)
        for place, cell in np.ndenumerate(self.cells.cells):
            opened = cell is not None and cell.run == self._opened
            if opened or place in (self._hovered, self._current if self.hasFocus() else None):
                box = self.cell_box(*place)
                painter.setPen(QPen(style.base, 4.0 * style.unit))
                painter.drawRect(box)
                painter.setPen(QPen(style.highlight if opened else style.text, 2.0 * style.unit))
                painter.drawRect(box)

    def _paint_axes(self, painter, style):
        area, line, metrics = self.area(), style.line, self.fontMetrics()
        painter.setPen(QPen(style.mixed(0.6), 1))
        painter.drawRect(area)
        painter.setPen(style.mixed(0.85))
        columns, rows = (list(map(_number, values)) for values in self.cells.values)
        wide = max(map(metrics.horizontalAdvance, columns)) + line
        for i in range(0, len(columns), max(1, math.ceil(wide * len(columns) / area.width()))):
            x = self._to_screen(np.array([[i, 0.0]]))[0, 0]
            box = QRectF(x - wide, area.bottom() + 0.2 * line, 2 * wide, line)
            painter.drawText(box, Qt.AlignCenter, columns[i])
        for i in range(0, len(rows), max(1, math.ceil(1.2 * line * len(rows) / area.height()))):
            y = self._to_screen(np.array([[0.0, i]]))[0, 1]
            box = QRectF(0, y - 0.5 * line, area.left() - 0.35 * line, line)
            painter.drawText(box, Qt.AlignRight | Qt.AlignVCenter, rows[i])
        x_label, y_label = (_label(key, self.cells.units) for key in self.cells.keys)
        below = QRectF(area.left(), area.bottom() + 1.3 * line, area.width(), 1.2 * line)
        painter.drawText(below, Qt.AlignCenter, x_label)
        draw_upwards(painter, 0.15 * line, area, line, y_label)


def _label(key, units):
    return symbolic(axis_label(key, units))


def _with_unit(name):
    return "{} [{}]".format(name, UNITS[name]) if name in UNITS else name


def _number(value):
    text = "{:.3g}".format(value) if isinstance(value, float) else str(value)
    return text.replace("-", "\u2212")
