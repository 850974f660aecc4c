"""Gives all panels the whole width, and the map half the height, where there is too little room."""

from mrs_simulator.rqt_plugin.widgets.guard import guarded

NARROW = 40  # [lines of text] of width, below which there is one column
LEAST_RESULTS = 6  # [lines of text] of height that is left below the map


@guarded
class OneColumn:
    """Moves the settings among the results, below the map, while the window is narrow."""

    def __init__(self, settings_tabs, results_tabs, splitter, map_panel):
        """``splitter``: has map and results, one above the other."""
        self._settings, self._results, self._splitter = settings_tabs, results_tabs, splitter
        self._pages = [
            (settings_tabs.widget(place), settings_tabs.tabText(place))
            for place in range(settings_tabs.count())
        ]
        self._map, self.is_narrow, self._is_chosen = map_panel, False, False
        self._wide = splitter.sizes()  # of map and results beside the settings
        splitter.splitterMoved.connect(self._on_moved)

    def is_setting(self, page):
        """Return whether ``page`` is one of the settings."""
        return any(page is each for each, _ in self._pages)

    def _on_moved(self, *_):
        self._is_chosen = True

    def fit(self, size, line):
        """Take the arrangement for a window of ``size``, where a line of text is ``line`` [px] high."""
        if (size.width() < NARROW * line) != self.is_narrow:
            self.is_narrow, self._is_chosen = not self.is_narrow, False
            self._move(line)
        if self.is_narrow and not self._is_chosen:
            # Its buttons are above the map.
            above = self._map.height() - self._map.map.height()
            high = self._splitter.height() - self._splitter.handleWidth()
            wanted = min(size.height() // 2 + above, high - LEAST_RESULTS * line)
            self._splitter.setSizes([wanted, high - wanted])

    def _move(self, line):
        target = self._results if self.is_narrow else self._settings
        shown, seen = self._settings.currentWidget(), self._results.currentWidget()
        for place, (page, title) in enumerate(self._pages):
            target.insertTab(place, page, title)
        if self.is_narrow:
            begins = not self._results.isVisible()  # with what comes first
            target.setCurrentWidget(shown if begins else seen)
        elif shown is None:
            target.setCurrentIndex(0)
        self._settings.setVisible(not self.is_narrow)
        self._results.setMinimumHeight(LEAST_RESULTS * line if self.is_narrow else 0)
        if self.is_narrow:
            self._wide = self._splitter.sizes()
        else:
            self._splitter.setSizes(self._wide)
