"""The picker of scenarios: picture, title, law and theorem of each; recent ones first."""

import os

from mrs_simulator.rqt_plugin.qt.QtCore import QRect, QSize, Qt, QTimer, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QFont, QPainter, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QApplication,
    QCheckBox,
    QDialog,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)
from mrs_simulator.rqt_plugin.start.cards import SIZE, Cards
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen
from mrs_simulator.scenario.shipped import shipped_scenarios

CARD = Qt.UserRole + 1  # a ``Card``, and to which group it belongs
POLL = 60  # [ms] between looks for cards that have been made
FIRST = ("paper.yaml", "consensus.yaml", "displacement_formation.yaml")  # of those shipped
RECENT, EDITS, SHIPPED = "Recent", "Unsaved edits", "Shipped"
HEIGHT = 5.6  # [lines of text] of a row
TEXT_ROOM = 46  # [lines of text] of width of the window


class CardRow(QStyledItemDelegate):
    """Paints cards."""

    def sizeHint(self, option, index):
        """Return the size of a row."""
        return QSize(200, int(HEIGHT * option.fontMetrics.height()))

    @guarded
    def paint(self, painter, option, index):
        """Paint the picture at the left, and three texts."""
        (card, group), line = index.data(CARD), option.fontMetrics.height()
        option = QStyleOptionViewItem(option)
        self.initStyleOption(option, index)
        option.text = ""
        style = QApplication.style()
        style.drawControl(QStyle.CE_ItemViewItem, option, painter, self.parent())
        chosen, palette = bool(option.state & QStyle.State_Selected), option.palette
        colour = palette.color(QPalette.HighlightedText if chosen else QPalette.Text)
        painter.save()
        painter.setRenderHint(QPainter.SmoothPixmapTransform)
        high = int((HEIGHT - 0.5) * line)
        place = QRect(
            option.rect.left() + 4, option.rect.top() + 4, high * SIZE[0] // SIZE[1], high
        )
        if card.image is not None:
            painter.drawImage(place, card.image)
        painter.setPen(palette.color(QPalette.Mid))
        painter.drawRect(place)
        painter.setPen(colour)
        left = place.right() + line // 2
        width = option.rect.right() - left - line // 2
        top = QRect(left, place.top(), width, line)
        self._write(painter, option.font, top, card, group)
        painter.restore()

    @staticmethod
    def _write(painter, font, top, card, group):
        bold, line = QFont(font), top.height()
        bold.setBold(True)
        painter.setFont(bold)
        title = painter.fontMetrics().elidedText(
            card.title or os.path.basename(card.path), Qt.ElideRight, top.width()
        )
        painter.drawText(top, Qt.AlignLeft | Qt.AlignVCenter, title)
        painter.setFont(font)
        name = os.path.basename(card.path)
        where = {SHIPPED: name, EDITS: EDITS}.get(group, "{}: {}".format(group, name))
        about = "{} \u00b7 {}".format(card.about, where) if card.about else where
        about = painter.fontMetrics().elidedText(about, Qt.ElideMiddle, top.width())
        painter.drawText(top.translated(0, line), Qt.AlignLeft | Qt.AlignVCenter, about)
        rest = QRect(top.left(), top.top() + int(2.1 * line), top.width(), 3 * line)
        painter.drawText(rest, Qt.AlignLeft | Qt.TextWordWrap, card.wrong or card.theorem)


@guarded
class ScenarioPicker(QDialog):
    """Offers recent and shipped scenarios; it holds up no other window."""

    chosen = Signal(str)  # path of a scenario's file
    browse_asked = Signal()  # for a file by the usual dialog

    def __init__(self, memory, parent=None):
        """``memory``: a ``StartMemory``."""
        super().__init__(parent)
        self._memory = memory
        self.setWindowTitle("Choose a scenario")
        OnScreen(self)
        self._find, self.list = QLineEdit(clearButtonEnabled=True), QListWidget()
        self._find.setPlaceholderText("Find by title, law, kind of robots or theorem")
        self._find.textChanged.connect(self._on_find)
        self.list.setItemDelegate(CardRow(self.list))
        self.list.setVerticalScrollMode(QListWidget.ScrollPerPixel)
        self.list.setAccessibleName("Scenarios")
        self.list.itemActivated.connect(self._on_item)
        note = QLabel("A scenario's file can also be dragged onto the window.")
        column_of(self._find, (self.list, 1), note, self._build_buttons(), owner=self)
        line = self.fontMetrics().height()
        self.resize(TEXT_ROOM * line, 38 * line)
        self.cards, self._groups = None, {}
        self.timer = QTimer(self, interval=POLL, timeout=self._follow)
        self._begin()

    def _build_buttons(self):
        self.at_start = QCheckBox("Show at the start", checked=self._memory.kept()["picker"])
        self.at_start.toggled.connect(guarded(lambda on: self._memory.change(picker=on)))
        browse, opens, closes = (QPushButton(t) for t in ("Other file...", "Open", "Close"))
        browse.clicked.connect(self._on_browse)
        opens.setDefault(True)
        opens.clicked.connect(guarded(lambda *_: self._on_item(self.list.currentItem())))
        closes.clicked.connect(self.close)
        return row_of(self.at_start, 0, browse, opens, closes)

    def _begin(self):
        recent = self._memory.recent()
        folder = shipped_scenarios()
        names = sorted(n for n in os.listdir(folder) if n.endswith((".yaml", ".yml")))
        paths = [os.path.join(folder, name) for name in names]
        self._groups = dict.fromkeys(paths, SHIPPED)
        for path in recent:
            self._groups[path] = EDITS if self._memory.is_edits(path) else RECENT
        paths.sort(key=lambda path: _place(os.path.basename(path)))
        order = [*recent, *(path for path in paths if path not in recent)]
        palette = self.palette()
        colours = palette.color(QPalette.Base), palette.color(QPalette.Text)
        self.cards = Cards(order, *colours)
        self.timer.start()

    @guarded
    def _follow(self):
        done = self.cards.is_done()
        for card in self.cards.take():
            self._add(card)
        if done:
            self.timer.stop()

    def _add(self, card):
        group = self._groups[card.path]
        item = QListWidgetItem()
        item.setData(CARD, (card, group))
        words = " ".join((card.title, card.about, card.theorem, card.path))
        item.setData(Qt.AccessibleTextRole, words)
        item.setToolTip("{}: {}\n{}".format(group, card.path, card.theorem))
        item.setHidden(not _matches(words, self._find.text()))
        self.list.addItem(item)
        if self.list.count() == 1:
            self.list.setCurrentRow(0)

    def _on_find(self, text):
        items = [self.list.item(row) for row in range(self.list.count())]
        for item in items:
            item.setHidden(not _matches(item.data(Qt.AccessibleTextRole), text))
        shown = [item for item in items if not item.isHidden()]
        if shown and self.list.currentItem() not in shown:
            self.list.setCurrentItem(shown[0])

    def _on_item(self, item):
        if item is not None and not item.isHidden() and not item.data(CARD)[0].wrong:
            self.close()
            self.chosen.emit(item.data(CARD)[0].path)

    def _on_browse(self, *_):
        self.close()
        self.browse_asked.emit()

    def hideEvent(self, event):
        """Make no more cards, and go."""
        super().hideEvent(event)
        self.timer.stop()
        self.cards.close()


def _place(name):
    """Return what shipped scenarios are sorted by."""
    return FIRST.index(name) if name in FIRST else len(FIRST)


def _matches(words, wanted):
    return all(each in words.lower() for each in wanted.lower().split())
