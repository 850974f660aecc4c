"""The team: number of robots and initial poses."""

import math

import numpy as np

from mrs_simulator import vehicles
from mrs_simulator.core.compiling import in_time
from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QLabel, QPushButton, QWidget
from mrs_simulator.rqt_plugin.team.altitude_field import AltitudeField
from mrs_simulator.rqt_plugin.team.layout_box import LayoutBox
from mrs_simulator.rqt_plugin.team.model import NO_PAIRS, TeamModel, kind_name
from mrs_simulator.rqt_plugin.team.spreadsheet import read_rows
from mrs_simulator.rqt_plugin.team.table import TeamTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import NoWheelComboBox, PatientSpinBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.scenario.team.layouts import extend_poses
from mrs_simulator.world.contact.bodies import Bodies

MOST_ROBOTS = 1000
# [-] so that a number beyond the limit is refused, and not cut off as it is typed
MOST_TYPED = 999999
NUMBER_TIP = (
    "<p>Number of robots, 1 to {}. New ones are placed where there is room; the last are removed first.</p>"
).format(MOST_ROBOTS)
KIND_TIP = "Kind of the robots selected in the table, or of all if none is selected"
MIXED = "several kinds"
ROOM = (20.0, 2.5)  # [m] side of the square for new robots: at least, and times root n
MOST_PAIRS = 3  # named in the line below the table


@guarded
class TeamPanel(QWidget):
    """Number of robots, their initial poses, and ready-made layouts."""

    team_changed = Signal()  # the user changed the number, a pose or a kind
    robot_chosen = Signal(int)  # number of the one row that the user has selected
    arranged = Signal()  # all robots were put to a layout
    open_requested = Signal()
    save_requested = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self._refusal = ""  # of what was typed last, until it is asked for
        self._bodies, self._selects = None, False  # the latter: whether the window selects a row
        self._find = vehicles.kind  # returns the Kind that a name means
        self.model = TeamModel(vehicles.KINDS, self)
        self.model.accepted.connect(self._on_edited)
        self.set_real = self.model.set_real
        self.table = TeamTable(self.model)
        self.table.pasted.connect(self._on_pasted)
        self.table.arranged.connect(self._on_arranged)
        self.follow_asked = self.table.follow_asked
        self.message, self.overlaps = MessageLabel(), MessageLabel()
        self.locked = MessageLabel("aside")  # why nothing can be changed
        self.layouts = LayoutBox(lambda: len(self.kinds()))
        self.layouts.chosen.connect(self._on_layout)
        self.layouts.refused.connect(self._refuse)
        self._build_number()
        first = self._build_scenario_buttons()
        self.model.refused.connect(self._refuse)
        below = self.locked, self.message, self.overlaps, self.layouts
        column_of(*first, (self.table, 1), *below, owner=self)
        self.set_editable(True)
        self.set_team([[0.0, 0.0, 0.0]], vehicles.KINDS[:1])

    def _build_number(self):
        self.number = PatientSpinBox()
        self.number.setRange(1, MOST_TYPED)
        self.number.setToolTip(NUMBER_TIP)
        self.number.valueChanged.connect(self._on_number)

        self.kind = NoWheelComboBox()
        self.kind.setToolTip(KIND_TIP)
        self.kind.activated.connect(self._on_kind)
        self.altitude_field = AltitudeField()
        self.altitude_field.chosen.connect(self._on_altitude)
        self.table.selectionModel().selectionChanged.connect(self._on_selection)

    def _build_scenario_buttons(self):
        self._open = QPushButton("Open scenario...")
        self._open.clicked.connect(guarded(lambda *_: self.open_requested.emit()))
        self._open.setToolTip("Load team, protocol and surroundings from a scenario file")
        self._save = QPushButton("Save scenario...")
        self._save.clicked.connect(guarded(lambda *_: self.save_requested.emit()))
        self._save.setToolTip("Write team, protocol and surroundings to a scenario file")
        number = row_of(QLabel("Robots"), self.number, QLabel("Kind"), (self.kind, 1))
        return row_of((self._open, 1), (self._save, 1)), number, self.altitude_field

    # What is shown -------------------------------------------------------------------------------

    def poses(self):
        """Return the initial poses, (n, 3) [m, m, rad]; a copy."""
        return self.model.poses.copy()

    def kinds(self):
        """Return the robots' kinds."""
        return self.model.kinds

    def altitude(self):
        """Return the heights (n,) [m] at which robots begin, None where all begin on the ground."""
        return self._heights.copy() if self._heights.any() else None

    @property
    def overlapping(self):
        """Return the numbers of the robots that overlap another one."""
        return {row + 1 for row in self.model.overlapping}

    def set_kinds(self, find, own=()):
        """Use ``find(name)``, which returns a ``Kind``; offer the names ``own`` too."""
        self._find = find
        self.model.kind_choices = tuple(dict.fromkeys((*vehicles.KINDS, *own)))

    def set_team(self, poses, kinds, altitude=None):
        """Show ``poses`` (n, 3) [m, m, rad], ``kinds`` and ``altitude`` (n,) [m]; no signal.

        Robots that do not fly begin on the ground, and without an ``altitude`` the others too.
        """
        poses, kinds = np.array(poses, dtype=float).reshape(-1, 3), tuple(kinds)
        if len(poses) != len(kinds):
            text = "{} poses and {} kinds, wanted as many kinds as poses"
            raise ValueError(text.format(len(poses), len(kinds)))
        found = {name: self._find(name) for name in dict.fromkeys(kinds)}
        self._bodies = Bodies([found[name] for name in kinds]) if kinds else None
        flies = np.array([found[name].module.MEDIUM == "air" for name in kinds], dtype=bool)
        self._flies, self._heights = flies, np.zeros(len(kinds))
        if altitude is not None:
            self._heights[flies] = np.asarray(altitude, dtype=float)[flies]
        pairs = self._overlapping_pairs(poses)
        self.model.set_team(poses, kinds, pairs)
        self._report_overlaps(pairs)
        self.message.say("")
        self._refusal = ""
        self._show_kind()
        blocked = self.number.blockSignals(True)
        self.number.setRange(min(1, len(kinds)), MOST_TYPED)
        self.number.setValue(len(kinds))
        self.number.blockSignals(blocked)

    def _group_rows(self):
        """Return the rows that are selected, all where none is."""
        selected = {index.row() for index in self.table.selectionModel().selectedRows()}
        return sorted(selected) or list(range(len(self.model.kinds)))

    def _show_kind(self):
        """Show the kind of the robots selected, or of all, among those that may be chosen."""
        kinds = self.model.kinds
        offered = list(dict.fromkeys((*self.model.kind_choices, *kinds)))
        chosen = {kinds[row] for row in self._group_rows() if row < len(kinds)}
        if len(chosen) > 1:
            offered.insert(0, "")
        self.kind.blockSignals(True)
        self.kind.clear()
        for name in offered:
            self.kind.addItem(kind_name(name) or MIXED, name)
            self.kind.setItemData(self.kind.count() - 1, self._title(name), Qt.ToolTipRole)
        shown = chosen.pop() if len(chosen) == 1 else ""
        self.kind.setCurrentIndex(max(0, self.kind.findData(shown)))
        self.kind.blockSignals(False)
        rows = [row for row in self._group_rows() if row < len(kinds) and self._flies[row]]
        self.altitude_field.show_heights(self._heights[rows])
        self.altitude_field.setVisible(bool(self._flies.any()))

    def select(self, number):
        """Select the row of robot ``number`` alone, 0 for none; no signal."""
        rows = [index.row() for index in self.table.selectionModel().selectedRows()]
        if rows == [number - 1] or (not number and len(rows) != 1):
            return
        self._selects = True
        try:
            self.table.clearSelection()
            if 0 < number <= len(self.model.kinds):
                self.table.selectRow(number - 1)
        finally:
            self._selects = False

    def _on_selection(self, *_):
        self._show_kind()
        rows = self.table.selectionModel().selectedRows()
        if len(rows) == 1 and not self._selects:
            self.robot_chosen.emit(rows[0].row() + 1)

    def _on_kind(self, index):
        chosen, kinds = self.kind.itemData(index), list(self.kinds())
        if chosen:
            for row in self._group_rows():
                kinds[row] = chosen
            self._change(self.poses(), kinds, self._heights)

    def _on_altitude(self, height):
        heights = self._heights.copy()
        heights[self._group_rows()] = height
        self._change(self.poses(), self.kinds(), heights)

    def set_pose(self, number, x, y, theta):
        """Move robot ``number`` to a pose [m, m, rad], as when dragged; no signal."""
        if not 1 <= number <= len(self.model.poses):
            raise ValueError("robot{}: wanted 1 to {}".format(number, len(self.model.poses)))
        poses = self.model.poses
        poses[number - 1] = x, y, theta
        self.set_poses(poses)

    def set_poses(self, poses):
        """Move all robots to ``poses`` (n, 3) [m, m, rad]; no signal."""
        pairs = self._overlapping_pairs(poses)
        self.model.set_team(poses, self.model.kinds, pairs)
        self._report_overlaps(pairs)

    def set_editable(self, editable, why="", may_open=False):
        """Allow changes of the team or not; saving stays possible.

        ``why`` not, in a line and the tooltips; ``may_open``: another scenario may be opened all the same.
        """
        self.table.set_editable(editable)
        self._open.setEnabled(editable or may_open)
        for widget in (self.number, self.kind, self.altitude_field, self.layouts):
            widget.setEnabled(editable)
        self.locked.say("" if editable or not why else "{}{}".format(why[0].upper(), why[1:]))
        remark = "" if editable or not why else "<p>Not now: {}</p>".format(why)
        self.number.setToolTip(NUMBER_TIP + remark)
        self.layouts.setToolTip(remark)
        self.table.setToolTip(remark)

    def _overlapping_pairs(self, poses):
        if self._bodies is None:
            return NO_PAIRS
        with in_time():
            return self._bodies.overlaps(poses, self._heights if self._heights.any() else None)[:2]

    def _report_overlaps(self, pairs):
        order = np.lexsort(pairs[::-1])[:MOST_PAIRS]
        text = ", ".join(
            "robot{} and robot{}".format(first + 1, second + 1)
            for first, second in zip(pairs[0][order].tolist(), pairs[1][order].tolist())
        )
        more = len(pairs[0]) - MOST_PAIRS
        text += " overlap" if text else ""
        self.overlaps.say(text + (", and {} more pairs".format(more) if more > 0 else ""))

    # What the user does --------------------------------------------------------------------------

    def _change(self, poses, kinds, heights=None):
        """Show a new team and emit it if it differs; added robots begin as high as the last one."""
        heights = self._heights if heights is None else heights
        more = len(poses) - len(heights)
        if more > 0:
            heights = np.concatenate([heights, np.full(more, heights[-1] if len(heights) else 0.0)])
        same = tuple(kinds) == self.kinds() and np.array_equal(poses, self.model.poses)
        before = self._heights
        self.set_team(poses, kinds, heights[: len(poses)])
        if not same or not np.array_equal(before, self._heights):
            self.team_changed.emit()

    def _resized(self, n):
        """Return poses and kinds of the team with ``n`` robots; ``ValueError`` of too many."""
        poses, kinds = self.poses(), self.kinds()
        most = max(MOST_ROBOTS, len(poses))
        if n > most:
            raise ValueError("{} robots: the window edits at most {}".format(n, most))
        if n > len(poses):
            size = max(ROOM[0], ROOM[1] * math.sqrt(n))
            poses = extend_poses(poses, n, size=size)
            kinds += (kinds[-1] if kinds else vehicles.KINDS[0],) * (n - len(kinds))
        return poses[:n], kinds[:n]

    @guarded
    def _refuse(self, text):
        self.message.say(text)
        self._refusal = text

    def take_refusal(self):
        """Return why the newest of what was typed was refused, "" where it was not; once."""
        refusal, self._refusal = self._refusal, ""
        return refusal

    def _on_number(self, n):
        try:
            self._change(*self._resized(n))
        except ValueError as error:
            self.set_team(self.poses(), self.kinds(), self._heights)
            self._refuse(str(error))

    def _on_edited(self):
        self.set_team(self.poses(), self.kinds(), self._heights)
        self.team_changed.emit()

    def _on_arranged(self, arrangement):
        poses, rows = self.poses(), self._group_rows()
        poses[rows] = arrangement(poses[rows])
        self._change(poses, self.kinds())

    def _on_pasted(self, text):
        row = max(0, self.table.currentIndex().row())
        try:
            self._change(*self._with_pasted(row, read_rows(text)))
        except ValueError as error:
            self._refuse(str(error))

    def _with_pasted(self, row, pasted):
        n = len(self.poses())
        end = row + len(pasted)
        if not pasted:
            raise ValueError("the clipboard is empty, wanted rows of x [m], y [m], heading [deg]")
        if end > max(n, MOST_ROBOTS):
            raise ValueError(
                "{} rows pasted, wanted at most {}".format(len(pasted), max(n, MOST_ROBOTS) - row)
            )
        if end > n and row:
            text = "{} rows pasted at robot{} of {}; to get more robots paste at robot1"
            raise ValueError(text.format(len(pasted), row + 1, n))
        poses = np.vstack([self.poses(), np.zeros((max(0, end - n), 3))])
        for place, values in enumerate(pasted, row):
            poses[place, : len(values)] = values[:2] + [math.radians(v) for v in values[2:]]
        kinds = self.kinds()
        return poses, kinds + (kinds[-1] if kinds else vehicles.KINDS[0],) * (len(poses) - n)

    def _on_layout(self, poses):
        self._change(poses, self.kinds())
        self.arranged.emit()

    def _title(self, name):
        """Return the title of a kind, its name where it cannot be read."""
        try:
            return self._find(name).title if name else ""
        except (ValueError, OSError):
            return name
