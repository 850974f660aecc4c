"""Pictures of the views, curves as a table, and results with a video."""

import os

from mrs_simulator.core.writing import write_bytes
from mrs_simulator.rqt_plugin.qt.QtCore import QBuffer, QMarginsF, QSizeF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QImage, QPageSize, QPainter, QPdfWriter
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.window.composer import Composer

FINE = 3.0  # [-] pixels of a picture for one of the screen
OF_WIDGETS, OF_FIGURES = ("png", "pdf"), ("png", "pdf", "svg")
NOT_SAVED = (
    "no figure to compose: no run of this window is saved yet, by Save... or at the end of Run"
)
VIDEO = {"video": ("--video", "--beside-curves"), "film": ("--video", "--beside-curves", "--space")}


class Export:
    """Does what the menu beside *Save...* offers."""

    def __init__(self, panels, results, files, processes, opened, comparison):
        """``results``: the window's ``Results``; ``files``: asks for paths, a ``ScenarioFiles``.

        ``opened``: the ``OpenedRun``; ``comparison``: the ``Comparison``.
        """
        self._comparison = comparison
        self._panels, self._results, self._files = panels, results, files
        self._processes, self._opened, self.composer = processes, opened, None

    def do(self, what):
        """Export ``what``, a name of ``bar.EXPORTS``."""
        panels = self._panels
        if what == "table":
            text = panels.curves.as_csv()
            QApplication.clipboard().setText(text)
            panels.say("copied: {} lines of the curves shown".format(text.count("\n")))
        elif what == "figure":
            self._compose()
        elif what in VIDEO:
            self._results.ask_where(VIDEO[what])
        elif what == "curves":
            self._ask(what, panels.curves.save_picture, OF_FIGURES)
        else:
            widget = {"map": panels.map, "view": panels.view.canvas}[what]
            self._ask(what, lambda path: save_picture(widget, path), OF_WIDGETS)

    def _compose(self):
        directory = self._opened.path or self._results.directory
        if directory is None:
            self._panels.say(ErrorMessage(NOT_SAVED))
            return
        given = self._processes, directory, self._files.ask, self._comparison.named()
        self.composer = Composer(self._panels, *given)
        self.composer.saved.connect(self._panels.say_saved)
        self.composer.show()

    def _ask(self, name, save, kinds):
        patterns = " ".join("*." + kind for kind in kinds)

        def chosen(path):
            if os.path.splitext(path)[1][1:] not in kinds:
                wanted = "not saved: {}: wanted a file that ends in {}"
                self._panels.say(ErrorMessage(wanted.format(path, ", ".join(kinds))))
                return
            try:
                save(path)
            except (OSError, ValueError) as error:
                self._panels.say(ErrorMessage("not saved: {}".format(reason(error))))
                return
            self._panels.say_saved(path)

        title = "Save the picture"
        self._files.ask(title, name + ".png", "Pictures ({})".format(patterns), chosen, saves=True)


def save_picture(widget, path):
    """Write what ``widget`` shows to ``path``: ``.png``, finer than the screen, or ``.pdf`` of vectors.

    Raises ``OSError`` where it cannot be written.
    """
    made = QBuffer()  # Qt's own writers do not say that a disk is full
    made.open(QBuffer.WriteOnly)
    if path.endswith(".pdf"):
        _write_vectors(widget, made)
    else:
        image = QImage(widget.size() * FINE, QImage.Format_RGB32)
        image.setDevicePixelRatio(FINE)
        image.fill(Qt.white)
        widget.render(image)
        image.save(made, "PNG")
    write_bytes(path, made.data().data())


def _write_vectors(widget, made):
    writer, size = QPdfWriter(made), widget.size()
    writer.setPageSize(QPageSize(QSizeF(size), QPageSize.Point))
    writer.setPageMargins(QMarginsF(0.0, 0.0, 0.0, 0.0))
    painter = QPainter(writer)
    try:
        painter.scale(writer.width() / size.width(), writer.height() / size.height())
        widget.render(painter)
    finally:
        painter.end()
