"""A person at the GUI: mouse and keys, where a window shows something for them.

Presses go the way that those of a screen go: to the window, which gives them to what lies there, or to what
has the focus.  What is hidden, covered or disabled is not reached.
"""

import os
import re
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import QPoint, QPointF, Qt, QTimer
from PyQt5.QtGui import QPainter
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDialog,
    QLabel,
    QLineEdit,
    QMenu,
    QScrollArea,
    QTabBar,
    QToolButton,
    QWidget,
)

PICTURES = "MRS_PICTURES"  # names the directory that pictures go to, if any
LIMIT = 120.0  # [s] of wall time for anything to come about
STEPS = 6  # [-] of a drag
MARKUP = re.compile("<[^>]*>|&(?!amp;)")


class Person:
    """Uses a window and its dialogs; ``clicks`` counts presses of the mouse."""

    def __init__(self, window, name=""):
        """``name``: that pictures begin with."""
        self.window, self.clicks = window, 0
        self._name, self._pictures = name, 0

    # Looking -------------------------------------------------------------------------------------

    def until(self, condition):
        """Wait until ``condition()`` holds."""
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                self.picture("late")
                said = self.window.study.messages.toPlainText()
                raise AssertionError("not within {:g} s; messages: {}".format(LIMIT, said))
            QTest.qWait(10)

    def seen(self, kind, text, within=None):
        """Return the one widget of ``kind`` that is called ``text``, by itself or its tooltip.

        Where none is called so, the one whose name begins with it; as soon as it is visible.
        """

        def called():
            found = (within or self.window).findChildren(kind)
            found = [(each, names_of(each)) for each in found if each.isVisible()]
            exact = [each for each, names in found if text in names]
            return exact or [e for e, names in found if any(n.startswith(text) for n in names)]

        self.until(called)
        (chosen,) = called()
        return chosen

    def button(self, text, within=None):
        """Return the visible button called ``text``."""
        return self.seen(QAbstractButton, text, within)

    def field(self, text, within=None):
        """Return the field that the label ``text`` stands before."""
        label = self.seen(QLabel, text, within)
        if label.buddy() is not None:
            return label.buddy()
        around = label.parentWidget()
        here, beside = label.geometry(), []
        for each in around.findChildren(QWidget, options=Qt.FindDirectChildrenOnly):
            at = each.geometry()
            level = at.top() <= here.center().y() <= at.bottom()
            if each.isVisible() and level and at.left() >= here.right():
                beside.append((at.left(), each))
        assert beside, text
        return min(beside, key=lambda each: each[0])[1]

    def dialog(self, title):
        """Return the dialog whose title begins with ``title``, once it is shown."""
        self.until(lambda: _dialogs(title))
        return _dialogs(title)[0]

    def picture(self, name):
        """Keep a picture of what is shown, where the environment says that pictures are wanted."""
        folder = os.environ.get(PICTURES)
        if not folder:
            return
        QTest.qWait(300)
        image, self._pictures = self.window.grab().toImage(), self._pictures + 1
        painter = QPainter(image)
        for each in QApplication.topLevelWidgets():
            if each is not self.window and each.isVisible() and isinstance(each, (QDialog, QMenu)):
                place = (self.window.size() - each.size()) / 2
                painter.drawPixmap(place.width(), place.height(), each.grab())
        painter.end()
        image.save(os.path.join(folder, "{}_{}_{}.png".format(self._name, self._pictures, name)))

    # The mouse -----------------------------------------------------------------------------------

    def click(self, widget, at=None, button=Qt.LeftButton, held=Qt.NoModifier):
        """Click on ``widget``, at ``at`` [px] in it or in its middle, once it can be used."""
        window, place = self._place(widget, at)
        self.clicks += 1
        QTest.mouseClick(window, button, held, place)

    def drag(self, widget, begin, end, held=Qt.NoModifier, letting_go=True):
        """Drag from ``begin`` to ``end`` [px] in ``widget``, and let go there."""
        window, place = self._place(widget, begin)
        self.clicks += 1
        QTest.mousePress(window, Qt.LeftButton, held, place)
        for step in range(1, STEPS + 1):
            at = QPointF(begin) + QPointF(end - begin) * (step / STEPS)
            QTest.mouseMove(window, widget.mapTo(widget.window(), at.toPoint()))
        if letting_go:
            self.let_go(widget, end)

    def let_go(self, widget, at):
        """Let go of the mouse's button at ``at`` [px] in ``widget``."""
        place = widget.mapTo(widget.window(), at)
        QTest.mouseRelease(widget.window().windowHandle(), Qt.LeftButton, Qt.NoModifier, place)

    def move(self, widget, at=None):
        """Move the mouse to ``at`` [px] in ``widget``."""
        window, place = self._place(widget, at)
        QTest.mouseMove(window, place)

    def tab(self, text):
        """Click on the tab that begins with ``text``."""
        bar, index = self._tab(text)
        while bar.tabRect(index).right() > bar.width():  # there are more than it has room for
            (arrow,) = (
                each
                for each in bar.findChildren(QToolButton)
                if each.isVisible() and each.arrowType() == Qt.RightArrow
            )
            self.click(arrow)
        self.click(bar, bar.tabRect(index).center())

    def _tab(self, text):
        bars = [each for each in self.window.findChildren(QTabBar) if each.isVisible()]
        found = [
            (bar, index)
            for bar in bars
            for index in range(bar.count())
            if re.sub("&", "", bar.tabText(index)).startswith(text)
        ]
        assert len(found) == 1, (text, found)
        return found[0]

    def choose(self, box, text):
        """Choose ``text`` in a combo box: one click opens it, another takes the line."""
        self.click(box, QPoint(box.width() - 8, box.height() // 2))
        view = box.view()
        self.until(view.isVisible)
        row = box.findText(text)
        assert row >= 0, [box.itemText(each) for each in range(box.count())]
        view.scrollTo(view.model().index(row, 0))
        before = self.clicks
        while view.isVisible():  # a release just after the press that opened it counts for nothing
            at = view.visualRect(view.model().index(row, 0)).center()
            self.move(view.viewport(), at)
            self.click(view.viewport(), at)
            QTest.qWait(20)
        self.clicks = before + 1
        assert box.currentText() == text

    def menu(self, button, text, at=None):
        """Open the menu of ``button``, which holds this program up until an entry is taken: ``text``."""
        trouble = []

        def pick():
            try:
                self.entry(text)
            except AssertionError as error:
                trouble.append(error)
                while QApplication.activePopupWidget() is not None:
                    QApplication.activePopupWidget().close()

        QTimer.singleShot(0, pick)
        self.click(button, at)
        assert not trouble, trouble

    def entry(self, text):
        """Click on the entry that begins with ``text`` of the menu that is open."""
        self.until(lambda: isinstance(QApplication.activePopupWidget(), QMenu))
        menu = QApplication.activePopupWidget()
        entries = [each for each in menu.actions() if each.isVisible()]
        found = [each for each in entries if each.text().startswith(text)]
        assert len(found) == 1 and found[0].isEnabled(), [each.text() for each in entries]
        self.picture("menu")
        self.click(menu, menu.actionGeometry(found[0]).center())

    def _place(self, widget, at=None):
        """Return the window of ``widget`` and ``at`` [px] in it, once a press there reaches the widget."""

        def place():
            return widget.mapTo(widget.window(), widget.rect().center() if at is None else at)

        def is_reached():
            under = widget.window().childAt(place()) or widget.window()
            return under is widget or widget.isAncestorOf(under)

        self.until(lambda: widget.isVisible() and widget.isEnabled())
        self._scroll_to(widget)
        self.until(is_reached)
        return widget.window().windowHandle(), place()

    @staticmethod
    def _scroll_to(widget):
        """Scroll to ``widget`` where it lies in something that scrolls, as a person would."""
        around = widget.parentWidget()
        while around is not None:
            if isinstance(around, QScrollArea):
                around.ensureWidgetVisible(widget)
            around = None if around.isWindow() else around.parentWidget()

    # Keys ----------------------------------------------------------------------------------------

    def key(self, key, held=Qt.NoModifier, times=1):
        """Press ``key`` in the window that has the focus."""
        for _ in range(times):
            QTest.keyPress(self._in_front(), key, held)
            QTest.keyRelease(self._in_front(), key, held)  # another one, where that was closed

    def write(self, text):
        """Type ``text`` where the focus is."""
        for letter in text:
            self.key(letter)

    def fill(self, field, text):
        """Click on ``field``, and type ``text`` in place of what it has, and Return."""
        self.click(field)
        self.replace(text)

    def replace(self, text):
        """Type ``text`` in place of what the field with the focus has, and Return."""
        self.key(Qt.Key_A, Qt.ControlModifier)
        self.write(text)
        self.key(Qt.Key_Return)

    def name_file(self, title, path):
        """Type ``path`` into the file dialog called ``title``, and Return."""
        self.dialog(title)
        self.until(lambda: isinstance(QApplication.focusWidget(), QLineEdit))
        self.picture("dialog")
        self.replace(str(path))
        self.until(lambda: not _dialogs(title))
        self.go_back()

    def go_back(self):
        """Have the keys in the window again, as window managers do once a dialog is closed."""
        self.window.activateWindow()
        self.until(self.window.isActiveWindow)

    def _in_front(self):
        """Return the window that keys go to."""
        widget = QApplication.activePopupWidget() or QApplication.activeWindow() or self.window
        return widget.windowHandle()


def names_of(widget):
    """Return what a person calls ``widget``: its text, what its tooltip begins with, its other names."""
    names = [widget.toolTip().split("\n")[0], widget.objectName(), widget.accessibleName()]
    if isinstance(widget, (QAbstractButton, QLabel, QLineEdit)):
        names.append(widget.text())
    return [MARKUP.sub("", name).strip() for name in names if name]


def _dialogs(title):
    """Return the dialogs that are shown whose titles begin with ``title``."""
    windows = QApplication.topLevelWidgets()
    shown = [each for each in windows if isinstance(each, QDialog) and each.isVisible()]
    return [each for each in shown if each.windowTitle().startswith(title)]
