"""Tabs whose texts change, and that stay where they are."""

from mrs_simulator.rqt_plugin.qt.QtWidgets import QTabBar


class SteadyTabs(QTabBar):
    """A bar on which a tab keeps the width that it once had; ``reserve`` gives it that before."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self._widths = {}  # [px] by the first word of a text, which stays

    def reserve(self, text):
        """Keep room for ``text`` on the tab that begins with its first word."""
        for place in range(self.count()):
            if _name(self.tabText(place)) == _name(text):
                now = self.tabText(place)
                self.setTabText(place, text)
                self._widths[_name(text)] = self.tabSizeHint(place).width()
                self.setTabText(place, now)

    def tabSizeHint(self, index):
        """Return the size of a tab, as wide as it has been."""
        size, name = super().tabSizeHint(index), _name(self.tabText(index))
        width = max(size.width(), self._widths.get(name, 0))
        self._widths[name] = width
        size.setWidth(width)
        return size


def _name(text):
    return text.partition(":")[0].partition(" (")[0]
