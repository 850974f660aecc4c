"""The map's menu where nothing is edited: of a robot, and of the floor."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication, QMenu
from mrs_simulator.rqt_plugin.widgets.guard import guarded


def open_map_menu(view, row, place):
    """Open, and return, the menu of a ``MapView``'s robot in ``row``, with -1 that of the floor.

    ``place``: a ``QPoint`` of the screen.
    """
    menu = QMenu(view)
    menu.setAttribute(Qt.WA_DeleteOnClose)
    at = view.mapFromGlobal(place)
    point = view.to_plane(at.x(), at.y())
    for text, action in _of_robot(view, row) if row >= 0 else _of_floor(view, point):
        menu.addAction(text).triggered.connect(guarded(lambda *_, do=action: do()))
    view.menu = menu
    menu.popup(place)
    return menu


def _of_robot(view, row):
    number = view.team.numbers[row]
    pose = "{:.6g}\t{:.6g}\t{:.6g}".format(*view.team.pose_in_degrees(row))
    return (
        ("Show readings of robot {}".format(number), lambda: view.robot_clicked.emit(number)),
        ("Follow in the 3D view", lambda: view.follow_asked.emit(number)),
        ("Copy pose", lambda: QApplication.clipboard().setText(pose)),
        ("Fit the team", view.fit),
    )


def _of_floor(view, point):
    place = "{:.6g}\t{:.6g}".format(*point)
    return (
        ("Fit the team", view.fit),
        ("Fit everything", lambda: view.fit(whole=True)),
        ("Copy position", lambda: QApplication.clipboard().setText(place)),
    )
