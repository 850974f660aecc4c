"""Paints one run of the list: its box, picture, name, verdict, and what differs from another run."""

import time

from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, QRect, QRectF, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QFont, QPainter, QPalette, QPen, QPolygonF
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QApplication,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)
from mrs_simulator.rqt_plugin.shelf.entry import BAG
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint
from mrs_simulator.verdict.verdict import FAILED, NOT_JUDGED, PASSED, SELF_CONSISTENT

ENTRY = Qt.UserRole + 1  # an ``Entry``, and in words what differs
LINES, LOW_LINES = 3, 2  # of text, where there is room and where not; a note is one more
WORDS = {
    PASSED: ("passed", "good"),
    FAILED: ("FAILED", "error"),
    NOT_JUDGED: ("not judged", "aside"),
    SELF_CONSISTENT: ("self-consistent", "aside"),
    "": ("no verdict", "aside"),
}
PIN = "\u2605 "
INDENT = 1  # [lines of text] of the runs of a sweep
WIDE = 4.0 / 3.0  # [-] of a picture, over its height


class RunRow(QStyledItemDelegate):
    """Rows of a ``RunList``."""

    def __init__(self, thumbnails, parent):
        super().__init__(parent)
        self._thumbnails, self.lines = thumbnails, LINES

    def sizeHint(self, option, index):
        """Return the size of a row."""
        lines, found = self.lines, index.data(ENTRY)
        if found and self.lines == LINES:
            width = self._text_place(self.parent().viewport().rect(), option).width()
            differs = broken(found[1], option.fontMetrics, width)
            lines += bool(found[0].marks.note) + len(differs) - 1
        return QSize(100, int((1.15 * lines + 0.6) * option.fontMetrics.height()))

    def box(self, rect):
        """Return where the box of a row at ``rect`` is, with room for a finger."""
        line = self.parent().fontMetrics().height()
        return QRect(rect.left(), rect.top(), int(1.7 * line), rect.height())

    @guarded
    def paint(self, painter, option, index):
        """Paint the row."""
        (entry, difference), line = index.data(ENTRY), option.fontMetrics.height()
        option = QStyleOptionViewItem(option)
        self.initStyleOption(option, index)
        chosen, palette = bool(option.state & QStyle.State_Selected), option.palette
        style, view = QApplication.style(), self.parent()
        style.drawPrimitive(QStyle.PE_PanelItemViewItem, option, painter, view)
        painter.save()
        painter.setRenderHint(QPainter.SmoothPixmapTransform)
        shown = view.runs.shown == entry.path
        if shown:  # a bar in the colour of what is chosen
            painter.fillRect(
                QRect(option.rect.topLeft(), QSize(3, option.rect.height())), palette.highlight()
            )
        role = QPalette.HighlightedText if chosen else QPalette.Text
        colour = palette.color(QPalette.Active, role)
        if entry.sweep is None:
            self._paint_box(painter, option, index, colour, line)
        else:
            self._paint_arrow(painter, option, entry.path in view.runs.unfolded, colour, line)
        rect = option.rect.adjusted(INDENT * line if entry.within else 0, 0, 0, 0)
        self._paint_picture(painter, self._picture_place(rect, line), entry, palette)
        place = self._text_place(rect, option)
        self._paint_texts(painter, place, entry, difference, colour, chosen)
        painter.restore()

    def _text_place(self, rect, option):
        """Return where the first line of text of a row at ``rect`` is."""
        line = option.fontMetrics.height()
        picture = self._picture_place(rect, line)
        left = picture.right() + line // 2
        return QRect(left, picture.top(), rect.right() - left - line // 3, line)

    def _paint_box(self, painter, option, index, colour, line):
        """Paint the box, in the colour of the text: a style's own is not seen on every ground."""
        box, side = self.box(option.rect), 0.95 * line
        middle = QPointF(box.center().x() + 2.0, box.center().y() + 0.5)
        painter.setRenderHint(QPainter.Antialiasing)
        painter.setPen(QPen(faint(colour), max(1.0, line / 16.0)))
        painter.setBrush(Qt.NoBrush)
        frame = QRectF(middle.x() - side / 2, middle.y() - side / 2, side, side)
        painter.drawRoundedRect(frame, 0.15 * side, 0.15 * side)
        if index.data(Qt.CheckStateRole) == Qt.Checked:
            painter.setPen(QPen(colour, line / 7.0, Qt.SolidLine, Qt.RoundCap, Qt.RoundJoin))
            places = (-0.25, 0.0), (-0.08, 0.2), (0.28, -0.24)
            tick = [middle + QPointF(x * side, y * side) for x, y in places]
            painter.drawPolyline(QPolygonF(tick))

    def _paint_arrow(self, painter, option, unfolded, colour, line):
        """Paint what a click unfolds, or folds."""
        box, side = self.box(option.rect), 0.4 * line
        x, y = box.center().x() + 2.0, box.center().y() + 0.5
        corners = (-0.6, -1.0), (0.9, 0.0), (-0.6, 1.0)
        turned = [(b, a) for a, b in corners] if unfolded else corners
        painter.setRenderHint(QPainter.Antialiasing)
        painter.setPen(Qt.NoPen)
        painter.setBrush(faint(colour))
        points = [QPointF(x + a * side, y + b * side) for a, b in turned]
        painter.drawPolygon(QPolygonF(points))
        painter.setBrush(Qt.NoBrush)

    def _picture_place(self, rect, line):
        high = int((1.15 * self.lines) * line)
        left = self.box(rect).right() + 2
        return QRect(left, rect.top() + int(0.3 * line), int(WIDE * high), high)

    def _paint_picture(self, painter, place, entry, palette):
        ground = palette.color(QPalette.Base)
        image = self._thumbnails.of(entry, place.width(), place.height(), ground)
        if image is None:
            painter.fillRect(place, ground)
        else:
            painter.drawImage(place, image)
        painter.setPen(palette.color(QPalette.Mid))
        painter.drawRect(place.adjusted(0, 0, -1, -1))

    def _paint_texts(self, painter, first, entry, difference, colour, chosen):
        """Paint name and verdict in the line ``first``, and the others below."""
        word, kind = WORDS[entry.outcome]
        # Its verdict, made when it is opened, is in no file of its own.
        if entry.path.endswith(BAG):
            word = "bag"
        if entry.sweep is not None:
            word = "{} of {} passed".format(entry.sweep.passed, entry.sweep.runs)
        palette, font = self.parent().palette(), QFont(self.parent().font())
        bold = QFont(font)
        bold.setBold(True)
        when = when_text(entry.time)
        lines = [
            ((PIN if entry.marks.pinned else "") + entry.name, bold, colour),
            (when, font, faint(colour)),
        ]
        painter.setFont(font)
        parts = broken(difference, painter.fontMetrics(), first.width())
        lines += [(part, font, colour) for part in parts]
        if self.lines < LINES:
            lines[1:] = [(", ".join(filter(None, (when, difference))), font, colour)]
        elif entry.marks.note:
            italic = QFont(font)
            italic.setItalic(True)
            lines.append((entry.marks.note, italic, faint(colour)))
        painter.setFont(font)
        painter.setPen(colour if chosen else QColor(tint(kind, palette)))
        second = first.translated(0, int(1.15 * first.height()))
        painter.drawText(second, Qt.AlignRight | Qt.AlignVCenter, word)
        taken = painter.fontMetrics().horizontalAdvance(word + "  ")
        with_law = ", ".join(filter(None, (when, entry.protocol)))
        fits = painter.fontMetrics().horizontalAdvance(with_law) <= first.width() - taken
        if fits and self.lines == LINES:
            lines[1] = (with_law, font, faint(colour))  # whole, or not at all
        for row, (text, face, shade) in enumerate(lines):
            painter.setFont(face)
            painter.setPen(shade)
            width = first.width() - (taken if row == 1 else 0)
            # The end of a name tells runs apart, as in "with k 0.02".
            how = Qt.ElideMiddle if row == 0 else Qt.ElideRight
            cut = painter.fontMetrics().elidedText(text, how, width)
            place = first.translated(0, int(1.15 * row * first.height()))
            painter.drawText(place, Qt.AlignLeft | Qt.AlignVCenter, cut)


def broken(text, metrics, width):
    """Return ``text`` in a line of ``width`` [px], or in two, broken after a comma or a blank."""
    if metrics.horizontalAdvance(text) <= width:
        return [text]
    for gap in (", ", " "):
        parts = text.split(gap)
        fitting = [
            count
            for count in range(1, len(parts))
            if metrics.horizontalAdvance(gap.join(parts[:count]) + gap.rstrip()) <= width
        ]
        if fitting:
            return [gap.join(parts[: fitting[-1]]) + gap.rstrip(), gap.join(parts[fitting[-1] :])]
    return [text]


def faint(colour):
    """Return ``colour``, less strong."""
    result = QColor(colour)
    result.setAlphaF(0.7)
    return result


def when_text(when):
    """Return a time [s] since 1970 as it is written."""
    return time.strftime(day_form(when), time.localtime(when))


def day_form(when):
    """Return how a time is written: of today without the day."""
    today = time.strftime("%Y%m%d") == time.strftime("%Y%m%d", time.localtime(when))
    return "%H:%M:%S" if today else "%Y-%m-%d %H:%M"
