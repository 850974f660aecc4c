#!/usr/bin/env python3
"""Make the pictures of the GUI that the README shows: python3 docs/make_screenshots.py DIR [--all]

With --all also a run of 7 and of 100 robots in each of some looks: light and dark at 1366x768, and
on a 4K screen with its fonts twice as large.  Starts ROS masters of its own on this host; needs no
display, but for the 3D view by OpenGL: QT_QPA_PLATFORM=xcb xvfb-run -a python3 ... DIR.
"""

import argparse
import os
import socket
import subprocess
import sys
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ["ROS_HOSTNAME"] = "localhost"
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMIT = 300.0  # [s] for anything to come about
# size [px] of the screen, pixels of the screen in one of the widgets', whether it is dark
LOOKS = {
    "light": ((1366, 768), 1, False),
    "dark": ((1366, 768), 1, True),
    "4k": ((3840, 2160), 2, False),
}
MANY = 100  # [-] robots of the larger team
DARK = {
    "Window": "#2b2d30",
    "WindowText": "#e6e6e6",
    "Base": "#1e1f22",
    "AlternateBase": "#26282b",
    "Text": "#e6e6e6",
    "Button": "#3a3d41",
    "ButtonText": "#e6e6e6",
    "ToolTipBase": "#3a3d41",
    "ToolTipText": "#e6e6e6",
    "PlaceholderText": "#8f9296",
    "Highlight": "#3d6fb4",
    "HighlightedText": "#ffffff",
}


def free_port():
    """Return a port of this host that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def main():
    """Take the pictures, those of each look in a process of its own."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", help="an existing directory")
    parser.add_argument("--all", action="store_true", help="every look with 7 and 100 robots")
    parser.add_argument("--look", choices=LOOKS, help=argparse.SUPPRESS)
    parser.add_argument("--robots", type=int, default=7, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if not os.path.isdir(options.folder):
        parser.error("{}: no such directory".format(options.folder))
    if options.look:
        with_master(lambda: take(options))
        return
    wanted = [(look, robots) for look in LOOKS for robots in (7, MANY)]
    for look, robots in wanted if options.all else wanted[:1]:
        command = [sys.executable, os.path.abspath(__file__), options.folder]
        environment = dict(os.environ, QT_SCALE_FACTOR=str(LOOKS[look][1]))
        subprocess.run(
            command + ["--look", look, "--robots", str(robots)], env=environment, check=True
        )


def with_master(work):
    """Do ``work`` with a master on a free port."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = "http://localhost:{}".format(port)
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)])
    try:
        work()
    finally:
        master.terminate()
        master.wait()


def scenario_of(robots):
    """Return the paper's scenario, or, of another number of robots, that of a flock."""
    from mrs_simulator import load_scenario
    from mrs_simulator.scenario.scenario import scenario_from_dict
    from mrs_simulator.scenario.team.layouts import make_layout

    if robots == 7:
        return load_scenario(os.path.join(ROOT, "scenarios", "paper.yaml"))
    poses = make_layout("random", robots, seed=1, min_distance=1.7, size=2.4 * robots**0.5)
    parameters = {"distance": 2.0, "reach": 2.8, "leader_vx": 0.4, "leader_vy": 0.1, "l": 0.2}
    control = {"protocol": "flocking", "parameters": parameters}
    return scenario_from_dict({"poses": poses.tolist(), "control": control}, "flock")


def world_of_sensors():
    """Return a scenario of robots with sonar and cameras among obstacles."""
    from mrs_simulator.scenario.scenario import scenario_from_dict

    eye = {"type": "camera", "place": [0.25, 0.0, 0.4], "width": 320, "height": 240}
    obstacles = [
        {"type": "box", "name": "crate", "center": [2.5, 0.6], "size": [0.8, 0.6], "yaw": 0.4},
        {"type": "cylinder", "name": "column", "center": [-2.2, 1.5], "radius": 0.3},
        {"type": "wall", "from": [-4.0, -3.0], "to": [4.0, -3.0], "thickness": 0.1},
    ]
    return scenario_from_dict({
        "poses": {"layout": "circle", "radius": 1.5}, "robots": 7, "obstacles": obstacles,
        "sensors": [{"mounts": {"eye": eye, "power": {"type": "battery"}}}],
        "topology": {"preset": "ring"},
        "control": {"protocol": "consensus", "parameters": {}, "safety": {"obstacles": True}},
    }, "sensors")  # fmt: skip


def take_world(gui, press, until, picture):
    """Take the pictures of obstacles that are edited, of sensors and of programs."""
    gui.editing.take(world_of_sensors())
    gui.map_panel.modes["obstacles"].click()
    gui.map.editor.select("crate")
    picture("gui_obstacles")
    gui.shown["sensors"].setChecked(True)
    press("simulate")
    until(lambda: gui.connection.is_fresh("stage"))
    gui.results_tabs.setCurrentWidget(gui.sensors)
    gui.selection.choose(1)
    gui.shown["trails"].setChecked(False)  # nobody has moved: the legend is short then
    until(lambda: gui.sensors.picture.image is not None)
    picture("gui_camera")
    gui.sensors.looks.setCurrentIndex(1)
    until(lambda: gui.sensors.picture.most is not None)
    picture("gui_sensors")
    gui.results_tabs.setCurrentWidget(gui.programs)
    picture("gui_programs")
    gui.shown["sensors"].setChecked(False)
    gui.shown["trails"].setChecked(True)
    gui.selection.choose(0)  # no halo in the pictures of a run
    press("end")
    until(lambda: not gui.connection.is_fresh("stage"))


def take_view(gui, press, until, picture):
    """Take the picture of the 3D view: what lasers and sonars measure among walls."""
    from mrs_simulator import load_scenario

    gui.editing.take(load_scenario(os.path.join(ROOT, "scenarios", "exploration.yaml")))
    gui.shown["sensors"].setChecked(True)
    press("run")
    until(lambda: gui.history.begun is not None)
    until(lambda: gui.history.time[-1] > gui.history.begun + 12.0)
    gui.bring_forward("Protocol")
    gui.bring_forward("Curves")
    press("pause")  # OpenGL without a card smooths edges of what stands still
    picture("gui_view")
    gui.shown["sensors"].setChecked(False)
    press("end")
    until(lambda: not gui.connection.is_fresh("stage"))


def make_runs(home):
    """Make runs with three gains in the folder of runs below ``home``."""
    from mrs_simulator.study.run.experiment import run_experiment

    scenario = scenario_of(7)
    for place, gain in enumerate((0.01, 0.02, 0.06)):
        parameters = dict(scenario.control.parameters, k=gain)
        control = scenario.control._replace(parameters=parameters)
        path = os.path.join(home, "runs", "run{}".format(place))
        run_experiment(scenario._replace(control=control), path, formats=())


def take_runs(gui, until, picture):
    """Take the picture of runs that are compared."""
    shelf, runs = gui.study.shelf, gui.shelf.list
    shelf.home = os.path.join(gui.study.processes.directory, "home")
    shelf.change(watched=[])
    make_runs(shelf.home)
    gui.shelf_control.look()
    gui.bring_forward("Runs")
    until(lambda: len(runs.runs.entries) == 3)
    runs.choose(runs.runs.entries[0].path)
    gui.opened.open(runs.current_path())
    for row in (1, 2):
        runs.toggle(row)
    until(lambda: gui.opened.run is not None and len(gui.map.ghosts) == 2)
    gui.replay.cursor.go(12.0)
    gui.selection.choose(2)
    picture("gui_runs")
    gui.selection.choose(0)
    runs.clear_compared()
    gui.opened.close()


def take_sweep(gui, until, picture):
    """Take the picture of a sweep map, with the run of one of its cells."""
    from mrs_simulator import load_scenario

    scenario = load_scenario(os.path.join(ROOT, "scenarios", "delayed_consensus.yaml"))
    gui.editing.take(scenario._replace(fidelity="point_mass", duration=30.0))
    gui.bring_forward("Sweep")
    sizes = gui.right.sizes()
    gui.right.setSizes([sum(sizes) * share // 5 for share in (2, 3)])
    for form, name, low, high in zip(
        gui.sweep.axes, ("gain", "tau"), ("0.2", "0.1"), ("1.4", "1.2")
    ):
        form.choose(name)
        form.low.setText(low)
        form.high.setText(high)
        form.count.setValue(9)
    gui.sweep.start.click()
    until(lambda: gui.sweep.start.isEnabled() and len(gui.sweep_control.cells.known()) == 81)
    gui.sweep.quantity.setCurrentText("growth rate")
    gui.sweep.map.ask((2, 5))
    until(lambda: gui.opened.run is not None)
    picture("gui_sweep")
    gui.right.setSizes(sizes)
    gui.opened.close()


def square_that_may_touch():
    """Return a scenario whose requirement some starts break."""
    from mrs_simulator.scenario.scenario import scenario_from_dict

    return scenario_from_dict({
        "title": "Robots form a square", "fidelity": "kinematic", "duration": 12,
        "poses": [[4, -1, 0], [2, 4, 1], [-3, 2, 2], [-1, -4, 3]],
        "topology": {"preset": "complete"},
        "control": {"protocol": "displacement_formation", "parameters": {"gain": 0.5}},
        "requirements": {"apart": "always(each pair(clearance >= 0.1 m))"},
        "search": {"poses": {"within": [-4, -4, 4, 4], "apart": 1.5}, "robots": [2, 4]},
    }, "square")  # fmt: skip


def take_search(gui, until, picture):
    """Take the picture of a counterexample that was found."""
    gui.editing.take(square_that_may_touch())
    gui.bring_forward("Search")
    sizes = gui.right.sizes()
    gui.right.setSizes([sum(sizes) // 2] * 2)
    until(gui.search.vary.toPlainText)
    gui.search.buttons["break"].click()
    until(gui.search.show_run.isVisible)
    gui.search.show_run.click()
    until(lambda: gui.opened.run is not None and gui.replay.cursor.is_past)
    picture("gui_search")
    gui.right.setSizes(sizes)
    gui.opened.close()


def take(options):
    """Take the pictures of a whole study in one look."""
    import rosgraph
    import rospy
    from PyQt5.QtGui import QColor, QPalette
    from PyQt5.QtWidgets import QApplication

    from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
    from mrs_simulator.rqt_plugin.run.processes import Processes
    from mrs_simulator.rqt_plugin.study_widget import StudyWidget

    size, ratio, dark = LOOKS[options.look]
    application = QApplication([])
    if dark:
        palette = QPalette()
        for role, shade in DARK.items():
            palette.setColor(getattr(QPalette, role), QColor(shade))
        for role in (QPalette.WindowText, QPalette.Text, QPalette.ButtonText):
            palette.setColor(QPalette.Disabled, role, QColor("#7d8085"))
        application.setPalette(palette)

    def until(condition):
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise SystemExit("nothing to take a picture of within {:g} s".format(LIMIT))
            application.processEvents()
            time.sleep(0.005)

    def rest(seconds):
        end = time.monotonic() + seconds
        until(lambda: time.monotonic() > end)

    first = options.look == "light" and options.robots == 7
    suffix = "" if first else "_{}_{}".format(options.look, options.robots)

    def press(name):
        until(gui.bar.button(name).isEnabled)
        gui.bar.button(name).click()

    def picture(name):
        rest(0.8)
        gui.grab().save(os.path.join(options.folder, name + suffix + ".png"))

    until(rosgraph.is_master_online)
    rospy.init_node("screenshots", disable_signals=True)
    gui = StudyWidget(RosConnection(), Processes(), scenario_of(options.robots))
    gui.resize(*(side // ratio for side in size))
    gui.show()
    try:
        rest(1.5)
        curves = gui.results_tabs.currentWidget()
        picture("gui_team")
        if options.robots == 7:
            take_runs(gui, until, picture)
            take_sweep(gui, until, picture)
            take_search(gui, until, picture)
            take_world(gui, press, until, picture)
            take_view(gui, press, until, picture)
            gui.editing.take(scenario_of(options.robots))
            gui.results_tabs.setCurrentWidget(curves)
            rest(1.5)
        gui.bar.set_speed(5 if options.robots == 7 else 1)
        cleared = gui.history.cleared  # with the run before
        press("run")
        gui.settings_tabs.setCurrentIndex(1)
        until(lambda: gui.history.cleared > cleared and gui.history.begun is not None)
        until(lambda: len(gui.history.time) and gui.history.lasts(15.0))
        gui.curves.setFocus()
        picture("gui_run")
        gui.settings_tabs.setCurrentIndex(2)
        if options.robots == 7:
            until(lambda: "saved to" in gui.messages.toPlainText())
            gui.results_tabs.setCurrentWidget(gui.verdict)
        picture("gui_verdict")
    finally:
        gui.close_study()


if __name__ == "__main__":
    main()
