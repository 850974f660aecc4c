"""The panels of a study and their layout; their signals are connected elsewhere."""

from mrs_simulator.protocols import HOMES
from mrs_simulator.rqt_plugin.curves.panel import CurvesPanel
from mrs_simulator.rqt_plugin.map.panel import MapPanel
from mrs_simulator.rqt_plugin.protocol.panel import ProtocolPanel
from mrs_simulator.rqt_plugin.qt.QtCore import QLocale, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QLabel,
    QSizePolicy,
    QSplitter,
    QTabWidget,
    QWidget,
)
from mrs_simulator.rqt_plugin.replay.time_line import TimeLine
from mrs_simulator.rqt_plugin.run.bar import RunBar
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.run.preflight_panel import PreflightPanel
from mrs_simulator.rqt_plugin.run.programs_panel import ProgramsPanel
from mrs_simulator.rqt_plugin.search.panel import SearchPanel
from mrs_simulator.rqt_plugin.sensing.panel import SensorsPanel
from mrs_simulator.rqt_plugin.shelf.comparison_panel import ComparisonPanel
from mrs_simulator.rqt_plugin.shelf.panel import ShelfPanel
from mrs_simulator.rqt_plugin.sweep.panel import SweepPanel
from mrs_simulator.rqt_plugin.team.panel import TeamPanel
from mrs_simulator.rqt_plugin.team.topology_panel import TopologyPanel
from mrs_simulator.rqt_plugin.verdict.panel import VerdictPanel
from mrs_simulator.rqt_plugin.view.panel import ViewPanel
from mrs_simulator.rqt_plugin.widgets.banners import Banners
from mrs_simulator.rqt_plugin.widgets.boxes import column_of
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.messages import MessageList
from mrs_simulator.rqt_plugin.widgets.overlay import Overlay
from mrs_simulator.rqt_plugin.widgets.saved_place import SavedPlace
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled
from mrs_simulator.rqt_plugin.widgets.steady_tabs import SteadyTabs
from mrs_simulator.rqt_plugin.window.one_column import OneColumn
from mrs_simulator.rqt_plugin.window.side_by_side import TITLE, SideBySide

SIZE = (1180, 720)  # [px] that shows everything
WIDEST = "Verdict: not judged"  # usual text of a tab, for which there is room from the start
SETTINGS = 21  # [lines of text] that the settings are wide at first
GAP = 16  # [px] between parts of the status line
STATUS = ("master", "stage", "controller", "robots", "time")


@guarded
class StudyPanels(QWidget):
    """Run bar on top, settings on the left, map above results on the right, status below.

    Banners lie over the map.  In a narrow window the settings are among the results, in a wide one the 3D
    view is beside the map.
    """

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setObjectName("MrsSimulator")
        self.setWindowTitle("Multi-robot simulator")
        self.setLocale(QLocale.c())  # numbers as files have them, in any country
        self.bar, self.banners = RunBar(self), Banners(self)
        self.right, self.across = QSplitter(Qt.Vertical), QSplitter(Qt.Horizontal)
        # of the team: the map, and the 3D view where there is room
        self.views = QSplitter(Qt.Horizontal)
        self.views.addWidget(self._build_map())
        self.right.addWidget(self.views)
        self.right.addWidget(self._build_results())
        self.right.setStretchFactor(0, 3)
        self.right.setStretchFactor(1, 2)
        self.right.setSizes([400, 290])
        self.across.addWidget(self._build_settings())
        self.across.addWidget(self.right)
        self.across.setStretchFactor(1, 1)
        settings = SETTINGS * self.fontMetrics().height()
        self.across.setSizes([settings, max(settings, SIZE[0] - settings)])
        parts = self.bar, (self.across, 1), self._build_status()
        column_of(*parts, owner=self, margins=4, spacing=4)
        Overlay(self.banners, self.map)
        self.columns = OneColumn(self.settings_tabs, self.results_tabs, self.right, self.map_panel)
        self.beside = SideBySide(self.view, self.results_tabs, self.views)

    def resizeEvent(self, event):
        """Put the settings beside the map where there is room for both."""
        super().resizeEvent(event)
        self._fit()

    def showEvent(self, event):
        """Share the room between map and results, whose sizes are known from now on."""
        super().showEvent(event)
        self._fit()

    def _fit(self):
        self.columns.fit(self.size(), self.fontMetrics().height())
        self.beside.fit(self.size(), self.fontMetrics().height())
        if self.time_line is not None:
            self.time_line.give_room(not self.columns.is_narrow)

    def sizeHint(self):
        """Return the size that a dock of rqt, or a window, begins with."""
        return QSize(*SIZE)

    def _build_settings(self):
        self.team, self.protocol, self.topology = TeamPanel(), ProtocolPanel(), TopologyPanel()
        self.team.follow_asked.connect(self._on_follow)
        self.protocol.set_protocols(sorted(HOMES))
        self.shelf = ShelfPanel()
        self.settings_tabs = QTabWidget()
        for widget, title in (
            (self.team, "Team"),
            (self.protocol, "Protocol"),
            (self.topology, "Topology"),
        ):
            page = scrolled(widget)
            page.setObjectName(title)
            self.settings_tabs.addTab(page, title)
        self.shelf.setObjectName("Runs")
        self.settings_tabs.addTab(self.shelf, "Runs")
        return self.settings_tabs

    def _build_map(self):
        self.map_panel = panel = MapPanel()
        panel.bind_keys(self)
        self.map, self.modes, self.shown = panel.map, panel.modes, panel.shown
        self.time_line = None
        return panel

    def _build_results(self):
        self.curves = CurvesPanel()
        self.view = ViewPanel(self.map.scene, lambda: self.map.revision)
        self.map.follow_asked.connect(self._on_follow)
        self.preflight, self.verdict = PreflightPanel(), VerdictPanel()
        self.comparison = ComparisonPanel()
        self.sensors, self.programs = SensorsPanel(), ProgramsPanel()
        self.sweep, self.search = SweepPanel(), SearchPanel()
        self.messages = MessageList()
        self.messages.unseen_changed.connect(self._on_unseen)
        self.results_tabs = QTabWidget()
        bar = SteadyTabs(self.results_tabs)
        self.results_tabs.setTabBar(bar)
        for widget, title in (
            (self.curves, "Curves"),
            (self.view, TITLE),
            (self.preflight, "Preflight"),
            (self.verdict, "Verdict"),
            (self.comparison, "Compare"),
            (self.sweep, "Sweep"),
            (self.search, "Search"),
            (self.sensors, "Robot"),
            (self.programs, "Programs"),
            (self.messages, "Messages"),
        ):
            widget.setObjectName(title.replace(" ", "-"))  # by which settings know it
            self.results_tabs.addTab(widget, title)
        bar.reserve(WIDEST)
        self.results_tabs.setMovable(True)
        return self.results_tabs

    def _on_follow(self, number):
        self.bring_forward(self.view.objectName())
        self.view.follow(number)

    def _build_status(self):
        row = FlowLayout()
        row.setSpacing(GAP)
        row.line_spacing = 2
        self.status = {}
        for name in STATUS:
            label = QLabel(textFormat=Qt.RichText)
            # However long the trouble is, the window stays as wide as it is.
            label.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
            self.status[name] = label
            row.addWidget(label)
        self.saved = SavedPlace()
        self.saved.not_opened.connect(self._on_not_opened)
        row.addWidget(self.saved)
        return row

    def say_saved(self, path, text="saved {}"):
        """Say in a message that ``path`` was saved, and below until a run begins or ends."""
        self.say(text.format(path))
        taken = sum(
            label.sizeHint().width() + GAP for label in self.status.values() if label.text()
        )
        self.saved.name(path, self.width() - taken - 2 * GAP)

    def _on_not_opened(self, folder):
        self.say(ErrorMessage("no program opens folders here: {}".format(folder)))

    def show_time_line(self, cursor):
        """Show the line of the ``TimeCursor`` below the map."""
        self.time_line = TimeLine(cursor)
        self.map_panel.layout().addWidget(self.time_line)
        self._fit()

    def tab_order(self):
        """Return the names of the results' pages from left to right."""
        pages = [self.results_tabs.widget(place) for place in range(self.results_tabs.count())]
        return [page.objectName() for page in pages if not self.columns.is_setting(page)]

    def set_tab_order(self, names):
        """Put the results' pages called ``names`` first, in this order; names of none are left out."""
        known = self.tab_order()
        first, bar = self.results_tabs.count() - len(known), self.results_tabs.tabBar()
        for place, name in enumerate(name for name in dict.fromkeys(names) if name in known):
            page = self.results_tabs.findChild(QWidget, name)
            bar.moveTab(self.results_tabs.indexOf(page), first + place)

    def bring_forward(self, name):
        """Show the page called ``name``, if there is one."""
        for tabs in (self.settings_tabs, self.results_tabs):
            page = tabs.findChild(QWidget, name) if name else None
            if page is not None and tabs.indexOf(page) >= 0:
                tabs.setCurrentWidget(page)

    def hide_absent(self, absent):
        """Hide the buttons and the tab of what is ``absent``, names as of ``Connection.absent``."""
        self.bar.hide_absent(absent)
        self.programs.hide_absent(absent)
        if "preflight" in absent:
            self.results_tabs.removeTab(self.results_tabs.indexOf(self.preflight))

    def say(self, text):
        """Add ``text`` to the messages; show an ``ErrorMessage`` as a banner.  Return whether not empty."""
        if text:
            trouble = isinstance(text, ErrorMessage)
            self.messages.add(text, trouble)
            if trouble:
                buttons = ("Messages", self._show_messages), ("Close", self.close_error)
                self.banners.notify("error", "error", text, *buttons)
        return bool(text)

    def _show_messages(self):
        self.results_tabs.setCurrentWidget(self.messages)

    def close_error(self):
        """Take the newest error off the message bar."""
        self.banners.clear("error")

    def _on_unseen(self, count):
        title = "Messages ({})".format(count) if count else "Messages"
        self.results_tabs.setTabText(self.results_tabs.indexOf(self.messages), title)
