"""A tour of the window: six notes, each beside what it is about."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QPoint, QRect, Qt, QTimer, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import QFrame, QLabel, QPushButton
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

WIDE = 20  # [lines of text] of a note
RING = "QFrame#ring {{ border: 2px solid {}; border-radius: 4px; background: transparent; }}"
NOTE = "QFrame#note {{ border: 2px solid {}; border-radius: 4px; background: palette(base); }}"


@guarded
class Tour(QFrame):
    """One note over the window at a time; it takes no mouse or keys but on itself."""

    ended = Signal()  # by its last step, or its button

    def __init__(self, panels, steps):
        """``steps``: of a function that returns the widget, and a text, each."""
        super().__init__(panels)
        self._panels, self._steps, self._step = panels, steps, 0
        self.setObjectName("note")
        hue = self.palette().color(QPalette.Highlight).name()
        self.setStyleSheet(NOTE.format(hue))
        self._ring = QFrame(panels, objectName="ring", styleSheet=RING.format(hue))
        self._ring.setAttribute(Qt.WA_TransparentForMouseEvents)
        self.text, self._count = QLabel(wordWrap=True, textFormat=Qt.RichText), QLabel()
        self.next, self.close_button = QPushButton("Next"), QPushButton("Close, never show again")
        self.next.clicked.connect(self._on_next)
        self.close_button.clicked.connect(self._on_close)
        below = row_of((self._count, 1), self.close_button, self.next)
        column_of(self.text, below, owner=self)
        self.setFixedWidth(max(WIDE * self.fontMetrics().height(), below.sizeHint().width() + 24))
        self._again = QTimer(self, singleShot=True, timeout=self._place)
        self._followed = []  # what the note is about, and what that lies in
        self._show()

    def eventFilter(self, watched, event):
        """Stay beside what the note is about."""
        if event.type() in (QEvent.Resize, QEvent.Move):
            self._again.start()  # once panels have taken their places
        return False

    def _follow(self, target):
        """Follow the moves of ``target`` in the window, and of no other any more."""
        for each in self._followed:
            each.removeEventFilter(self)
        self._followed = [] if target is None else [target]
        while self._followed and self._followed[-1] is not self._panels:
            self._followed.append(self._followed[-1].parentWidget())
        for each in self._followed:
            each.installEventFilter(self)

    def _show(self):
        self.text.setText(self._steps[self._step][1])
        self._count.setText("{} of {}".format(self._step + 1, len(self._steps)))
        is_last = self._step == len(self._steps) - 1
        self.next.setText("Done" if is_last else "Next")
        self.close_button.setVisible(not is_last)
        self._place()
        self.show()
        self.raise_()

    @guarded
    def _place(self):
        """Put ring and note; where there is no room below what it is about, above or over it."""
        target = self._steps[self._step][0]()
        if self._followed[:1] != [target]:
            self._follow(target)
        corner = target.mapTo(self._panels, QPoint(0, 0))
        about = QRect(corner, target.size()).intersected(self._panels.rect())
        self._ring.setVisible(target.isVisible())
        self._ring.setGeometry(about.adjusted(-2, -2, 2, 2))
        self._ring.raise_()
        self.resize(self.width(), self.heightForWidth(self.width()))
        room = self._panels.rect().adjusted(6, 6, -6, -6)
        top = about.bottom() + 8
        if top + self.height() > room.bottom():
            top = about.top() - 8 - self.height()
        if top < room.top():
            top = about.center().y() - self.height() // 2
        left = max(room.left(), min(about.left(), room.right() - self.width()))
        self.move(left, max(room.top(), top))
        self.raise_()

    def _on_next(self, *_):
        if self._step + 1 == len(self._steps):
            self._on_close()
        else:
            self._step += 1
            self._show()

    def _on_close(self, *_):
        self._follow(None)
        self.hide()
        self._ring.hide()
        self._ring.deleteLater()
        self.deleteLater()
        self.ended.emit()


def steps_of(panels):
    """Return the six steps of the window ``panels``."""
    tabs = panels.settings_tabs, panels.results_tabs

    def bar_of(page):
        found = next(each for each in tabs if each.indexOf(_page(each, page)) >= 0)
        return found.tabBar()

    return (
        (
            lambda: bar_of("Team"),
            "<b>What is run.</b> The team and its initial poses, the protocol with its parameters, and the "
            "topology. <i>Open scenario...</i> offers scenarios to begin with.",
        ),
        (
            lambda: panels.map_panel.modes["look"].parentWidget(),
            "<b>By mouse.</b> Choose here what the mouse does on the map: move robots, connect them, draw "
            "obstacles, measure.",
        ),
        (
            lambda: panels.bar.button("run"),
            "<b>Run</b> (F5) simulates the scenario from its beginning for its duration, and judges "
            "the run.",
        ),
        (
            lambda: panels.bar.button("emergency"),
            "<b>Emergency stop</b> (F8) stops all robots, also real ones, until it is released.",
        ),
        (
            lambda: panels.time_line,
            "<b>Any moment.</b> Drag here, during a run or after it: map, 3D view and curves follow.",
        ),
        (
            lambda: panels.results_tabs.tabBar(),
            "<b>Results.</b> Curves, the verdict claim by claim, and what robots sense. Each run is kept "
            "in the tab <i>Runs</i>; <i>Save...</i> writes it with its figures where you want it.",
        ),
    )


def _page(tabs, name):
    pages = (tabs.widget(place) for place in range(tabs.count()))
    return next((page for page in pages if page.objectName() == name), None)
