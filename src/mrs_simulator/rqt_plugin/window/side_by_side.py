"""Puts the 3D view beside the map where there is room, and among the results where there is not."""

from mrs_simulator.rqt_plugin.widgets.guard import guarded

WIDE = 1280  # [px] of the window from which there is room for both
WIDE_TEXT = 68  # [lines of text], the same with large fonts
TITLE = "3D view"


@guarded
class SideBySide:
    """Moves the view between a tab and the right end of the map's splitter."""

    def __init__(self, view, tabs, splitter):
        """``view``: the ``ViewPanel``, a page of ``tabs``; ``splitter``: has the map."""
        self._view, self._tabs, self._splitter = view, tabs, splitter
        self._after = tabs.widget(tabs.indexOf(view) - 1)  # the page before its own
        self.is_beside, self._has_room = False, False
        self._sizes = []  # [px] of the two, none yet: each a half
        splitter.setChildrenCollapsible(False)
        view.beside.toggled.connect(guarded(lambda *_: self._arrange()))

    def fit(self, size, line):
        """Take the place for a window of ``size``, where a line of text is ``line`` [px] high."""
        self._has_room = size.width() >= max(WIDE, WIDE_TEXT * line)
        self._view.beside.setVisible(self._has_room)
        self._arrange()

    def sizes(self):
        """Return the widths [px] of map and view, none where they never were beside each other."""
        return self._splitter.sizes() if self.is_beside else self._sizes

    def set_sizes(self, sizes):
        """Give map and view these widths [px], now or once they are beside each other."""
        self._sizes = sizes
        if self.is_beside:
            self._splitter.setSizes(sizes)

    def _arrange(self):
        beside = self._has_room and self._view.beside.isChecked()
        if beside == self.is_beside:
            return
        self.is_beside = beside
        if beside:
            self._tabs.removeTab(self._tabs.indexOf(self._view))
            self._splitter.addWidget(self._view)
            half = self._splitter.width() // 2
            self._splitter.setSizes(self._sizes or [half, half])
            self._view.show()
        else:
            self._sizes = self._splitter.sizes()
            place = self._tabs.indexOf(self._after) + 1
            self._tabs.insertTab(place, self._view, TITLE)
        self._view.set_beside(beside)
