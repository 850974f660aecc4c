"""A layout that breaks a row of widgets into lines where the width ends."""

from mrs_simulator.rqt_plugin.qt.QtCore import QPoint, QRect, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QLayout, QSizePolicy

SPACING = 4  # [px]


class FlowLayout(QLayout):
    """Items from left to right, line by line; its height follows from its width.

    One widget may have the corner at the right of the first line.  A widget whose horizontal size
    policy is ``Ignored`` may be cut off at the end of a line; any other fits into the least width.
    """

    def __init__(self, parent=None):
        super().__init__(parent)
        self._items, self._corner, self._gaps = [], None, []
        self.setContentsMargins(0, 0, 0, 0)
        self.setSpacing(SPACING)
        self.line_spacing = None  # [px] between lines, None: as between items

    def add_corner(self, widget):
        """Keep ``widget`` at the right end of the first line, whatever the width."""
        self.addWidget(widget)
        self._corner = self._items[-1]

    def add_gap(self, widget):
        """Put ``widget`` between the items before and after, where these share a line."""
        self.addWidget(widget)
        self._gaps.append(self._items[-1])

    def addItem(self, item):
        """Take ``item`` as the last one."""
        self._items.append(item)

    def count(self):
        """Return the number of items."""
        return len(self._items)

    def itemAt(self, index):
        """Return the item, None beyond the last."""
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index):
        """Give an item away, None beyond the last."""
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self):
        """Return no direction: more room is not used."""
        return Qt.Orientations()

    def hasHeightForWidth(self):
        """Return that the height follows from the width."""
        return True

    def heightForWidth(self, width):
        """Return the height [px] that the lines take."""
        return self._arrange(QRect(0, 0, width, 0), place=False)

    def sizeHint(self):
        """Return the size of all items in one line."""
        sizes = [item.widget().sizeHint() for item in self._shown()]
        wide = sum(size.width() + self.spacing() for size in sizes) - self.spacing()
        return self._with_margins(max(0, wide), max([size.height() for size in sizes] + [0]))

    def minimumSize(self):
        """Return the least width at which no item is cut off, and the height of one line."""
        sizes = [item.minimumSize() for item in self._shown()]
        wide, high = ([getattr(size, name)() for size in sizes] for name in ("width", "height"))
        return self._with_margins(max(wide + [0]), max(high + [0]))

    def setGeometry(self, rect):
        """Place the items within ``rect``."""
        super().setGeometry(rect)
        self._arrange(rect, place=True)

    def _with_margins(self, width, height):
        margins = self.contentsMargins()
        return QSize(
            width + margins.left() + margins.right(), height + margins.top() + margins.bottom()
        )

    def count_lines(self, width, hidden):
        """Return how many lines ``width`` [px] takes if all widgets but those ``hidden`` are shown."""
        inner = self.contentsRect().width() - self.geometry().width() + width
        shown = [item for item in self._items if item.widget() not in hidden]
        return len(self._lines(inner, shown))

    def _shown(self):
        return [item for item in self._items if not item.isEmpty()]

    def _arrange(self, rect, place):
        """Arrange the items in ``rect``, move them if ``place``; return the height needed [px]."""
        margins = self.contentsMargins()
        room = rect.adjusted(margins.left(), margins.top(), -margins.right(), -margins.bottom())
        y = room.y()
        between = self.spacing() if self.line_spacing is None else self.line_spacing
        for gap in self._gaps if place else ():
            gap.setGeometry(QRect())  # unless a line has it
        for line in self._lines(room.width(), self._shown()):
            high = max([size.height() for _, size in line] + [0])
            if place:
                self._place(line, room, y, high)
            y += high + between
        return max(0, y - between - room.y()) + margins.top() + margins.bottom()

    def _place(self, line, room, y, high):
        x = room.x()
        for item, size in line:
            at = QPoint(x, y + (high - size.height()) // 2)
            if item is self._corner:
                at.setX(room.x() + room.width() - size.width())
            else:
                x += size.width() + self.spacing()
            item.setGeometry(QRect(at, size))

    def _lines(self, width, shown):
        """Return lists of (item, size), none wider than ``width`` unless a lone item has to be."""
        items = [item for item in shown if item is not self._corner]
        lines, left, gap = [[]], width, None
        for item in ([self._corner] if self._corner else []) + items:
            size = _size_within(item, width)
            if item in self._gaps:
                gap = item, size
                continue
            before = [gap] if gap and lines[-1] and lines[-1][-1][0] is not self._corner else []
            gap = None
            wide = sum(each.width() + self.spacing() for _, each in before) + size.width()
            if lines[-1] and wide > left:
                lines.append([])
                left, before, wide = width, [], size.width()
            lines[-1] += [*before, (item, size)]
            left -= wide + self.spacing()
        return lines


def _size_within(item, width):
    widget = item.widget()
    size = widget.sizeHint().expandedTo(widget.minimumSize()).boundedTo(widget.maximumSize())
    if widget.sizePolicy().horizontalPolicy() == QSizePolicy.Ignored:
        size.setWidth(min(size.width(), width))
    return size
