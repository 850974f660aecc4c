"""The map's lesser modes in a menu, where there is no room for their buttons."""

from mrs_simulator.rqt_plugin.qt.QtWidgets import QMenu, QToolButton
from mrs_simulator.rqt_plugin.widgets.guard import guarded

LESSER = ("ahead", "push", "measure")


@guarded
class ModeMenu(QToolButton):
    """Stands for the buttons of the ``LESSER`` modes, which choose what the mouse does all the same."""

    def __init__(self, buttons):
        """``buttons``: those of all modes, by name."""
        super().__init__()
        self._buttons, menu = {mode: buttons[mode] for mode in LESSER}, QMenu(self)
        self.setText("\u2026")
        self.setToolTip("What if, push, measure")
        self.setPopupMode(QToolButton.InstantPopup)
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(self._on_show)
        for button in self._buttons.values():
            entry = menu.addAction(button.text())
            entry.setCheckable(True)
            entry.triggered.connect(guarded(lambda _=False, b=button: b.setChecked(True)))
        self.setMenu(menu)
        self.hide()

    def _on_show(self):
        """Show of each mode whether it is on, and whether it can be chosen."""
        for entry, button in zip(self.menu().actions(), self._buttons.values()):
            entry.setChecked(button.isChecked())
            entry.setEnabled(button.isEnabled())
            entry.setToolTip(button.toolTip())

    def fold(self, folds):
        """Show the menu in place of the buttons, or these."""
        self.setVisible(folds)
        for button in self._buttons.values():
            button.setVisible(not folds)
