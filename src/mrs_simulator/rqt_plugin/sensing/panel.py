"""The sensors of one robot, live: readings, rates and ages."""

import math

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QLabel, QSizePolicy, QWidget
from mrs_simulator.rqt_plugin.sensing.picture import Picture
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import NoWheelComboBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.sensors.number_texts import number
from mrs_simulator.sensors.types.camera import CameraReading

HEADERS = (
    ("part", "Sensor, by the name of its mount, or another source of the robot's state"),
    ("reading", "Newest reading or message"),
    ("rate", "Rate by the stamps of the last readings, and nominal rate"),
    ("age", "Age of the reading: in simulated time, of real robots in wall time"),
    ("state", "Whether readings are received; of other sources the level that they report"),
)
READING, STATE = 1, 4  # columns
SHOWN = 3  # [-] incidents, the newest
CHOOSE = "Choose a robot here, or click on one on the map."
NOT_RECORDED = "Readings of sensors are not in a recorded run."
NONE = "Robot {} has no sensors: its kind declares none, and the scenario adds none."


@guarded
class SensorsPanel(QWidget):
    """Shows the readings of the robot chosen."""

    robot_chosen = Signal(int)

    def __init__(self, parent=None):
        super().__init__(parent)
        self.number = 0  # of the robot shown, 0 for none
        self._shown = None
        self.robots, self.note = NoWheelComboBox(), MessageLabel("aside")
        self.state = MessageLabel("aside")
        self.robots.setToolTip("The robot whose sensors are shown")
        self.robots.activated.connect(self._on_chosen)
        self.table = ResultsTable(HEADERS, widest=READING)
        label = QLabel("Robot")
        label.setBuddy(self.robots)
        self.robots.setFixedWidth(int(10 * self.fontMetrics().averageCharWidth()))
        self.robots.setSizePolicy(QSizePolicy.Fixed, QSizePolicy.Fixed)  # beside the note
        self.picture, self.looks = Picture(), NoWheelComboBox()
        self.looks.addItems(["Picture", "Depth"])
        self.looks.setToolTip("What is shown of the camera")
        self.looks.hide()
        above = row_of(label, self.robots, (self.note, 1), 0)
        below = row_of((self.table, 1), column_of((self.looks, 0, Qt.AlignTop), (self.picture, 1)))
        column_of(above, self.state, (below, 1), owner=self, margins=4)
        self.note.say(CHOOSE)

    @property
    def wants_depth(self):
        """Return whether a camera's depth is shown instead of its picture."""
        return self.looks.currentIndex() == 1

    def set_robots(self, numbers):
        """Offer the robots ``numbers``."""
        wanted = [""] + [str(number) for number in numbers]
        if wanted != [self.robots.itemText(k) for k in range(self.robots.count())]:
            self.robots.clear()
            self.robots.addItems(wanted)
            self.show_robot(self.number if self.number in numbers else 0)

    def show_robot(self, number):
        """Show the robot ``number``, 0 for none; no signal."""
        self.number = number
        self.robots.setCurrentIndex(max(0, self.robots.findText(str(number))))
        self.show_sensors({}, {})

    def show_state(self, flight, incidents):
        """Show the state ``flight`` of a flying robot, "" for others, and its ``Incident``s."""
        texts = [flight.capitalize()] if flight else []
        texts += [
            "{} at {:.1f} s".format(each.text.partition(" ")[2], each.time)
            for each in incidents[-SHOWN:]
        ]
        if len(incidents) > SHOWN:
            texts.append("and {} earlier".format(len(incidents) - SHOWN))
        self.state.say("; ".join(texts), "warning" if incidents else "good")

    def _on_chosen(self, place):
        self.robot_chosen.emit(int(self.robots.itemText(place) or 0))

    def show_sensors(self, mounts, received, trouble="", depth=None, status=(), recorded=False):
        """Show the readings ``received`` of the robot's ``mounts``, by name.

        ``trouble``: why there are no mounts; ``depth``: the camera's, if shown; ``status``: ``StatusRow``s
        to list below; ``recorded``: whether this is of a recorded run.
        """
        self.looks.setVisible(any(mount.type == "camera" for mount in mounts.values()))
        self._show_picture(received, depth)
        rows = [_cells(mount, received.get(name)) for name, mount in mounts.items()]
        rows += [(each.name, each.message, "", _age(each.age), each.level) for each in status]
        note = CHOOSE if not self.number else NONE.format(self.number) if not mounts else ""
        note = NOT_RECORDED if recorded and self.number else note
        self.note.say(trouble or note, "error" if trouble else "aside")
        tints = [(k, STATE, TINTS.get(cells[STATE], "error")) for k, cells in enumerate(rows)]
        tips = [
            _tip(mount, received.get(name), cells)
            for (name, mount), cells in zip(mounts.items(), rows)
        ]
        tips += [each.tip or "{}: {}".format(each.name, each.message) for each in status]
        fixed = [(cells[0], cells[STATE]) for cells in rows]
        if fixed == self._shown:
            self.table.change_texts(rows, tips)
        else:
            self._shown = fixed
            self.table.set_rows(rows, tips, tints)

    def _show_picture(self, received, depth):
        """Show the picture of the first camera that has one, or its ``depth``."""
        if self.wants_depth:
            reading = depth.reading if depth is not None else None
            return self.picture.show_depth(None if reading is None else reading.depth)
        readings = [each.reading for each in received.values() if each is not None]
        pictures = [each.image for each in readings if isinstance(each, CameraReading)]
        return self.picture.show_pixels(pictures[0] if pictures else None)


TINTS = {"received": "good", "waiting": "aside", "not published": "aside", "stale": "warning"}
TINTS.update(good="good", warning="warning")


def _age(seconds):
    return "" if math.isnan(seconds) else number(seconds, 2, " s")


def _cells(mount, received):
    """Return the texts of a row."""
    state, name = _state(mount, received), mount.name
    if received is None or received.reading is None:
        return name, "", "of {:g} Hz".format(mount.rate), "", state
    rate = (
        "" if math.isnan(received.rate) else number(received.rate, int(received.rate < 9.95), " ")
    )
    rate += "of {:g} Hz".format(mount.rate)
    return name, received.reading.text(), rate, number(received.age, 2, " s"), state


def _tip(mount, received, cells):
    """Return the whole text of a row, and its topic."""
    topic = received.topic if received is not None else ""
    first = "{}: {}{}".format(mount.name, mount.type, " on " + topic if topic else "")
    return "\n".join(filter(None, (first, cells[READING], cells[STATE])))


def _state(mount, received):
    if received is None or not received.topic:
        return "not published"
    if received.trouble:
        return "refused: {}".format(received.trouble)
    if received.reading is None:
        return "waiting"
    return "stale" if received.is_stale(mount) else "received"
