"""Paints what the map shows."""

import contextlib
import time

import numpy as np

from mrs_simulator.pictures.signs import MANY_ROBOTS
from mrs_simulator.rqt_plugin.map import axes, drawing, edge_drawing, geometry, marks
from mrs_simulator.rqt_plugin.map.forecast import draw_forecast
from mrs_simulator.rqt_plugin.map.ghosts import draw_names
from mrs_simulator.rqt_plugin.map.ground import Ground
from mrs_simulator.rqt_plugin.map.legend import draw_legend
from mrs_simulator.rqt_plugin.map.obstacle_drawing import draw_edited
from mrs_simulator.rqt_plugin.map.robot_card import card_lines, draw_card
from mrs_simulator.rqt_plugin.map.robot_selection import RobotSelection
from mrs_simulator.rqt_plugin.map.ruler import Ruler, draw_selection_band
from mrs_simulator.rqt_plugin.map.scene import EDGE_MODES, MapScene
from mrs_simulator.rqt_plugin.map.sensor_drawing import draw_reading, signs_of
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.map.style import MapStyle
from mrs_simulator.rqt_plugin.qt.QtGui import QPainter
from mrs_simulator.rqt_plugin.widgets.guard import guarded

MOST_EDGES = 40000  # [-] looked at when painting
PALE = 0.3  # [-] opacity of what others sense than the robot chosen
ALOFT = 0.01  # [m] from which a robot's height is shown


@guarded
class PaintedMap(MapScene):
    """A scene that is painted; what it shows for a moment lies on top."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self._ground, self._cursor, self._moved = Ground(), None, False
        self.hovered, self.hover_text = None, ""  # the edge under the mouse, and what is said of it
        self._robots, self._plates, self._heights = Sprites(), Sprites(), Sprites()
        self._legend = {}  # its picture
        self.chosen, self.ruler = RobotSelection(self), Ruler(self.team)
        # [s] of processor time: of the last picture, and of all since someone set it to 0
        self.cost = self.spent = 0.0

    def paintEvent(self, event):
        style, painter = MapStyle.of(self, max(self.team.numbers, default=1)), QPainter(self)
        begun = time.thread_time()
        try:
            self._paint_ground(painter, style)
            painter.setFont(self.font())
            painter.setRenderHint(QPainter.Antialiasing)
            painter.setClipRect(self.frame.area)
            with self._above_hint(painter):
                axes.draw_scale_bar(painter, style, self.frame)
            self._paint_last_run(painter, style)
            for ghost in self.ghosts:
                ghost.draw(painter, style, self.frame, self.shown["trails"])
            self._paint_edited(painter, style)
            if self._has_forecast():
                paths = self.forecast, self.team.numbers
                draw_forecast(painter, style, self.frame, *paths)
            self._paint_sensors(painter, style)
            remark = self._paint_edges(painter, style)
            if self.shown["targets"] and self.targets is not None:
                team = self.targets, self.team.numbers
                marks.draw_targets(painter, style, self.frame, *team)
            if self.ahead is not None and self.ahead.pose.shape[1] == len(self.team.numbers):
                self.ahead.draw(painter, style, self.frame, self.team_scene(), self.team.shapes)
            self._paint_robots(painter, style)
            if self.shown["legend"]:
                with self._above_hint(painter):
                    draw_legend(painter, style, self.frame, self.legend(), self._legend)
            if self.ghosts:
                names = [(self.own_name, 0), *((ghost.name, ghost.place) for ghost in self.ghosts)]
                draw_names(painter, style, self.frame, names, self.team.pose[:, :2])
            self._paint_card(painter, style)
            self._paint_passing(painter, style)
            if remark:
                axes.draw_remark(painter, style, self.frame, remark)
        finally:
            painter.end()
        self.cost = time.thread_time() - begun
        self.spent += self.cost

    @contextlib.contextmanager
    def _above_hint(self, painter):
        """Let what is painted at the lower axis stand above what covers it."""
        painter.save()
        painter.translate(0.0, -self.covered())
        yield
        painter.restore()

    def _paint_ground(self, painter, style):
        """Paint the ground with the trails."""
        trails = self.trails if self.shown["trails"] else None
        # robots may have been put elsewhere
        now = None if self._begin_anew else self.team.pose[:, :2]
        obstacles, numbers = self._standing, self.team.numbers
        if self.editor.draft is not None:  # which lies on top
            obstacles = self._undrafted(obstacles)
        self._ground.solid = bool(self.ghosts)
        arguments = obstacles, trails, now, numbers, self._hidden_trails
        self._ground.draw(painter, self, style, self.frame, *arguments)

    def _paint_last_run(self, painter, style):
        """Paint the run that has ended, if any."""
        if self.last_run is not None:
            hidden = self._hidden_trails if self.shown["trails"] else None
            self.last_run.draw(painter, style, self.frame, hidden)

    def _undrafted(self, obstacles):
        """Return ``obstacles`` without the one that is being edited."""
        draft = self.editor.draft
        return tuple(each for each in obstacles if draft is None or each.name != draft.name)

    def _paint_edited(self, painter, style):
        """Paint obstacles that move, and the selected one with its handles."""
        drawing.draw_obstacles(painter, style, self.frame, self._undrafted(self._moving))
        obstacle = self.editor.current if self.mode == "obstacles" else None
        if obstacle is not None:
            refused = self.editor.is_dragging and self.team.touches(obstacle)
            draw_edited(painter, style, self.frame, obstacle, refused)

    def _paint_sensors(self, painter, style):
        """Paint what robots sense, below the robots."""
        if not self.shown["sensors"] or not self.readings or self.is_past:
            return
        rows = {number: row for row, number in enumerate(self.team.numbers)}
        shapes, chosen = self.team.shapes, self.selected
        is_chosen = any(number == chosen for number, _ in self.readings)
        # The robot chosen last, above all others, which are then paler.
        for (number, _), received in sorted(
            self.readings.items(), key=lambda each: each[0][0] == chosen
        ):
            row = rows.get(number)
            if row is None or not self.team.known[row]:
                continue
            body = shapes.reach[row], 0.5 * (shapes.front[row] - shapes.rear[row])
            team = self.pose_of(row, received.reading), body, style.shade(number)
            whole = number == chosen  # of others it would cover the map
            painter.setOpacity(1.0 if whole or not is_chosen else PALE)
            draw_reading(painter, style, self.frame, *team, received.reading, whole)
        painter.setOpacity(1.0)

    def _paint_edges(self, painter, style):
        """Paint the edges; return a remark where some are left out."""
        if not self.shown["edges"]:
            return ""
        segments, stride = self.edges.segments(
            self.team.numbers, self.team.pose, self.frame, style.unit, self.team.shapes, MOST_EDGES
        )
        stride *= edge_drawing.draw_edges(painter, style, segments, self.edges.directed)
        return "" if stride == 1 else "One edge in {} is drawn".format(stride)

    def _paint_robots(self, painter, style):
        frame, scale = self.frame, self.frame.scale
        screen = frame.to_screen(self.team.pose)
        margin = (
            max(self.team.shapes.farthest * scale, geometry.ARROW * style.unit) + 2.0 * style.line
        )
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(self.team.known & frame.sees(screen, margin))
        pose, numbers = self.team.pose[rows], [self.team.numbers[row] for row in rows]
        shapes = self.team.shapes.of(rows)

        def of(chosen):
            places = [row for row, number in enumerate(numbers) if number in chosen]
            return pose[places], shapes.of(places)

        z = self.team.state.heights[rows]
        aloft = np.flatnonzero(z >= ALOFT)
        team, z = (pose[aloft], shapes.of(aloft)), z[aloft]
        marks.draw_shadows(painter, style, frame, *team, z)
        marks.draw_selection(painter, style, frame, *of(self._highlighted()))
        shown = np.zeros(len(self.team.numbers), dtype=bool)
        shown[rows] = True
        team_shapes, scene = self.team.shapes, self.team_scene()
        drawing.draw_robots(painter, style, frame, scene, team_shapes, shown, self._robots)
        marks.draw_real(painter, style, frame, *of(self.team.real))
        if (self.is_at_rest or self.mode == "poses") and self.team.overlapping:
            marks.draw_alarms(painter, style, frame, *of(self.team.overlapping))
        if self.shown["numbers"] and len(rows) <= MANY_ROBOTS:
            team_pose = pose, numbers, shapes
            taken = drawing.draw_numbers(painter, style, frame, *team_pose, self._plates)
            heights = list(map(drawing.height_text, z))
            drawing.draw_heights(painter, style, frame, *team, heights, self._heights, taken)

    def _paint_card(self, painter, style):
        """Paint what is known of the robot selected, while it is looked at."""
        if self.selected and self.mode == "look":
            graph, targets = (self.edges.list, self.edges.directed), self.targets
            lines = card_lines(self.team, *graph, targets, self.selected)
            if lines:
                draw_card(painter, style, self.frame, lines, style.shade(self.selected))

    def _highlighted(self):
        return self.chosen.numbers if self.mode == "poses" else {self.selected}

    def _paint_passing(self, painter, style):
        """Paint what is there for a moment: collisions, the edge that is being drawn."""
        if self.mode == "measure":
            self.ruler.draw(painter, style, self.frame)
        if self.drag is not None and self.drag.kind == "band":
            draw_selection_band(painter, style, self.drag.press, self._cursor)
        for age, place in self.flashes.ages():
            marks.draw_flash(painter, style, self.frame, place, age)
        if self.hovered is not None and self.drag is None:
            self._paint_hovered(painter, style)
        if self.drag is not None and self.drag.kind == "edge" and self._moved:
            row = self.robot_at(self._cursor)
            begin = self.frame.to_screen(self.team.pose[self.drag.row])
            reached = row >= 0 and row != self.drag.row
            end = self.frame.to_screen(self.team.pose[row]) if reached else self._cursor
            text = self.edge_text(self.drag.row, row if reached else -1)
            edge_drawing.draw_band(painter, style, begin, end, reached, text)

    def _paint_hovered(self, painter, style):
        """Paint the edge under the mouse, which a click removes."""
        team = self.team.numbers, self.team.pose, self.frame, style.unit, self.team.shapes
        segment = self.edges.segment_of(self.hovered, *team) if self.mode in EDGE_MODES else None
        if segment is not None:
            shown = self._cursor, self.hover_text
            directed = self.edges.directed
            edge_drawing.draw_hovered(painter, style, self.frame.area, segment, directed, *shown)

    def edge_text(self, row, other):
        """Return the text beside the edge drawn from robot ``row`` to ``other``, -1 for none."""
        receiver = "robot {}".format(self.team.numbers[other]) if other >= 0 else "..."
        between = (
            "and {} are neighbours" if not self.edges.directed else "{} receives from robot {}"
        )
        if self.edges.directed:
            return between.format(receiver, self.team.numbers[row])
        return "robot {} {}".format(self.team.numbers[row], between.format(receiver))

    def legend(self):
        """Return the names of the signs that are to be seen."""
        shown = set()
        if self.shown["trails"] and self.trails.begun:
            # Lines of compared runs are named beside.
            shown |= {"start"} if self.ghosts else {"start", "trail"}
        if self.last_run is not None:
            shown.add("last run")
        if self._has_forecast():
            shown.add("forecast")
        if self.ahead is not None:
            shown.add("ahead")
        if self.shown["targets"] and self.targets is not None:
            shown.add("target")
        if self.shown["edges"] and self.edges.list:
            shown.add("directed edge" if self.edges.directed else "edge")
        if self.team.real:
            shown.add("real")
        if not self.team.fresh.all():
            shown.add("stale")
        if np.any(self.team.state.heights >= ALOFT):
            shown.add("aloft")
        return shown | (signs_of(self.readings) if self.shown["sensors"] else set())

    def robot_at(self, at):
        """Return the row of the robot at ``at`` (2,) [px], -1 for none."""
        return geometry.robot_at(
            self.team.pose, self.frame, MapStyle.of(self).unit, at, self.team.shapes
        )

    def edge_at(self, at):
        """Return the edge (i, j, weight) at ``at`` (2,) [px], None for none."""
        if not self.shown["edges"]:
            return None
        unit = MapStyle.of(self).unit
        return self.edges.at(
            self.team.numbers, self.team.pose, self.frame, unit, at, self.team.shapes
        )
