"""The sensors of one robot, live: what each reads, how often, and how old that is."""

import math

from python_qt_binding.QtCore import Qt, Signal
from python_qt_binding.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from mrs_simulator.rqt_plugin.sensing.picture import Picture
from mrs_simulator.rqt_plugin.sensing.texts import number, told
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.fields import PatientComboBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
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
NONE = "Robot {} has no sensors: its kind declares none, and the scenario adds none."


class SensorsPanel(QWidget):
    """Shows the readings of the robot chosen."""

    robot_chosen = Signal(int)

    def __init__(self, parent=None):
        super().__init__(parent)
        self.number = 0  # of the robot shown, 0 for none
        self._shown = None
        self._robots, self._note = PatientComboBox(), MessageLabel("aside")
        self.state = MessageLabel("aside")
        self._robots.setToolTip("The robot whose sensors are shown")
        self._robots.activated.connect(self._on_chosen)
        self.table = ResultsTable(HEADERS, widest=READING)
        row = QHBoxLayout()
        label = QLabel("Robot")
        label.setBuddy(self._robots)
        self._robots.setFixedWidth(int(10 * self.fontMetrics().averageCharWidth()))
        for widget, stretch in ((label, 0), (self._robots, 0), (self._note, 1)):
            row.addWidget(widget, stretch)
        row.addStretch(0)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addLayout(row)
        layout.addWidget(self.state)
        below, beside = QHBoxLayout(), QVBoxLayout()
        self.picture, self.looks = Picture(), PatientComboBox()
        self.looks.addItems(["Picture", "Depth"])
        self.looks.setToolTip("What is shown of the camera")
        self.looks.hide()
        beside.addWidget(self.looks, 0, Qt.AlignTop)
        beside.addWidget(self.picture, 1)
        below.addWidget(self.table, 1)
        below.addLayout(beside)
        layout.addLayout(below, 1)
        self._note.say(CHOOSE)

    @property
    def wants_depth(self):
        """Return whether the depth of a camera is shown, not its picture."""
        return self.looks.currentIndex() == 1

    def set_robots(self, numbers):
        """Offer the robots ``numbers``."""
        wanted = [""] + [str(number) for number in numbers]
        if wanted != [self._robots.itemText(k) for k in range(self._robots.count())]:
            self._robots.clear()
            self._robots.addItems(wanted)
            self.show_robot(self.number if self.number in numbers else 0)

    def show_robot(self, number):
        """Show the robot ``number``, 0 for none; no signal."""
        self.number = number
        self._robots.setCurrentIndex(max(0, self._robots.findText(str(number))))
        self.show_sensors({}, {})

    def show_state(self, flight, incidents):
        """Show what the robot does that flies, ``flight`` in words or "", and its ``Incident``s."""
        texts = [flight.capitalize()] if flight else []
        texts += ["{} at {:.1f} s".format(what_of(each), each.time) for each in incidents[-SHOWN:]]
        if len(incidents) > SHOWN:
            texts.append("and {} earlier".format(len(incidents) - SHOWN))
        self.state.say("; ".join(texts), "warning" if incidents else "good")

    @guarded
    def _on_chosen(self, place):
        self.robot_chosen.emit(int(self._robots.itemText(place) or 0))

    def show_sensors(self, mounts, heard, trouble="", depth=None, told=()):
        """Show what was ``heard`` of the robot's ``mounts``, by name; ``trouble``: why there are none.

        ``depth``: the ``Heard`` of its camera's depth, where that is shown; ``told``: ``Told`` each of
        what is said of the robot besides.
        """
        self.looks.setVisible(any(mount.type == "camera" for mount in mounts.values()))
        self._show_picture(heard, depth)
        rows = [_cells(mount, heard.get(name)) for name, mount in mounts.items()]
        rows += [(each.name, each.message, "", _age(each.age), each.level) for each in told]
        note = CHOOSE if not self.number else NONE.format(self.number) if not mounts else ""
        self._note.say(trouble or note, "error" if trouble else "aside")
        tints = [(k, STATE, TINTS.get(cells[STATE], "error")) for k, cells in enumerate(rows)]
        tips = [
            _tip(mount, heard.get(name), cells)
            for (name, mount), cells in zip(mounts.items(), rows)
        ]
        tips += [each.tip or "{}: {}".format(each.name, each.message) for each in told]
        fixed = [(cells[0], cells[STATE]) for cells in rows]
        if fixed == self._shown:
            self.table.change_texts(rows, tips)
        else:
            self._shown = fixed
            self.table.set_rows(rows, tips, tints)

    def _show_picture(self, heard, depth):
        """Show the picture of the first camera that has one, or its ``depth``."""
        if self.wants_depth:
            reading = depth.reading if depth is not None else None
            return self.picture.show_depth(None if reading is None else reading.depth)
        readings = [each.reading for each in heard.values() if each is not None]
        pictures = [each.image for each in readings if isinstance(each, CameraReading)]
        return self.picture.show_pixels(pictures[0] if pictures else None)


def what_of(incident):
    """Return what befell the robot of an ``incident``, in words without its name."""
    return incident.text.partition(" ")[2]


TINTS = {"heard": "good", "waiting": "aside", "not published": "aside", "stale": "warning"}
TINTS.update(good="good", warning="warning")


def _age(seconds):
    return "" if math.isnan(seconds) else number(seconds, 2, " s")


def _cells(mount, heard):
    """Return the texts of a row."""
    state, name = _state(mount, heard), mount.name
    if heard is None or heard.reading is None:
        return name, "", "of {:g} Hz".format(mount.rate), "", state
    rate = "" if math.isnan(heard.rate) else number(heard.rate, int(heard.rate < 9.95), " ")
    rate += "of {:g} Hz".format(mount.rate)
    return name, told(heard.reading), rate, number(heard.age, 2, " s"), state


def _tip(mount, heard, cells):
    """Return all of a row, and where it comes from."""
    topic = heard.topic if heard is not None else ""
    told = "{}: {}{}".format(mount.name, mount.type, " on " + topic if topic else "")
    return "\n".join(filter(None, (told, cells[READING], cells[STATE])))


def _state(mount, heard):
    if heard is None or not heard.topic:
        return "not published"
    if heard.trouble:
        return "refused: {}".format(heard.trouble)
    if heard.reading is None:
        return "waiting"
    return "stale" if heard.is_stale(mount) else "heard"
