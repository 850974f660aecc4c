"""Gives all panels the whole width where there is too little for settings beside the map."""

NARROW = 40  # [lines of text] of width, below which there is one column


class OneColumn:
    """Moves the settings among the results, below the map, while the window is narrow."""

    def __init__(self, settings_tabs, results_tabs, splitter):
        """``splitter``: has map and results, one above the other."""
        self._settings, self._results, self._splitter = settings_tabs, results_tabs, splitter
        self._pages = [
            (settings_tabs.widget(place), settings_tabs.tabText(place))
            for place in range(settings_tabs.count())
        ]
        self.is_narrow = False

    def fit(self, width, line):
        """Take the arrangement for ``width`` [px], where a line of text is ``line`` [px] high."""
        if (width < NARROW * line) != self.is_narrow:
            self.is_narrow = not self.is_narrow
            self._move()

    def _move(self):
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
        # Settings need more height than curves do.
        height = sum(self._splitter.sizes())
        if self.is_narrow and height:
            self._splitter.setSizes([height // 2, height - height // 2])
