"""What the map shows: a team and its trails, targets, obstacles, edges and collisions, and from where."""

import math

import numpy as np

from mrs_simulator.core.arrays import are_near
from mrs_simulator.pictures.scene import Ghosts, Scene
from mrs_simulator.rqt_plugin.map import axes
from mrs_simulator.rqt_plugin.map.beams import of_camera, of_reading
from mrs_simulator.rqt_plugin.map.edges import Edges
from mrs_simulator.rqt_plugin.map.flashes import Flashes
from mrs_simulator.rqt_plugin.map.forecast import paths_in_space
from mrs_simulator.rqt_plugin.map.frame import Frame
from mrs_simulator.rqt_plugin.map.last_run import LastRun
from mrs_simulator.rqt_plugin.map.obstacle_editor import ObstacleEditor
from mrs_simulator.rqt_plugin.map.recent_poses import RecentPoses
from mrs_simulator.rqt_plugin.map.style import MapStyle
from mrs_simulator.rqt_plugin.map.team import MapTeam, resting
from mrs_simulator.rqt_plugin.map.trails import Trails, trails_of
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QSize, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QSizePolicy, QWidget
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.surroundings.moving_obstacles import moves, obstacles_at, scene_time
from mrs_simulator.scenario.surroundings.obstacles import with_obstacles

HINTS = {
    "look": "",
    "poses": "Drag to move (Ctrl: to 0.5 m), with Shift to turn.  Shift-drag on the floor or Ctrl-click to "
    "select several; right button: arrange",
    "edges": "Drag from robot i to j: {}. Click on an edge: remove it",  # what that means
    "ahead": "",
    "push": "Drag a robot to push it; it is held until you let go. The run and its verdict know of it",
    "measure": "Drag from one point or robot to another; robots are followed",
    "obstacles": "Drag on free floor to draw, on an obstacle to move it, on its marks to resize or turn it",
}
EDGE_MODES = ("edges", "ahead")  # in which a click takes an edge away
ROOM = 0.3  # around a moving team when the view follows it, as a share of its larger side
FORESEEN = 10.0  # [-] times the team's extent, as far as a forecast is brought into view
REACH = 10.0  # [m] about a small team within which obstacles are brought into view
LAYERS = ("trails", "forecast", "targets", "edges", "numbers", "legend")


@guarded
class MapScene(QWidget):
    """Robots, targets, trails, obstacles and edges in the plane; robots are numbered from 1."""

    directed_changed = Signal()  # whether the graph's edges have a direction

    def __init__(self, parent=None):
        super().__init__(parent)
        self.frame, self.team = Frame(), MapTeam()
        self.mode, self.drag = "look", None  # one of ``HINTS``
        self.shown = dict(dict.fromkeys(LAYERS, True), sensors=False)
        self._recent = RecentPoses()  # of the run shown
        self.last_run = None  # a ``LastRun`` below what will start
        # ``Ghost``s of runs that are compared with the one shown, and what that is called then
        self.ghosts, self.own_name = (), ""
        # of the robots' sensors, by (number, name), and the ``Mount``s of these and of cameras
        self.readings, self.mounts = {}, {}
        self._hidden_trails, self.selected = set(), 0
        self.targets, self._target_z, self.obstacles = None, None, ()
        self._shown_targets = None
        self.ahead = None  # a ``LookAhead``: how the run would go on
        self.forecast = None  # (k, n, 2) [m] where theory has the robots go
        self._standing, self._movers, self._moving = (), (), ()
        self.editor = ObstacleEditor(self._on_obstacles, self._on_edit)
        self.edges = Edges()
        self.flashes = Flashes(self, self.update)
        self.untouched = True  # the view is still the one that fit() chose
        self._whole = True  # and that one holds all obstacles
        self.covered = lambda: 0.0  # returns the height [px] that is covered at the lower axis
        self.revision = 0  # of what is shown: it grows with each change
        # whether a moment is shown that has passed, and whether robots stand where a run begins, in no run
        self.is_past, self.is_at_rest = False, True
        self._begin_team((), np.empty((0, 3)))
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    def update(self, *args):
        """Paint anew, and count the change."""
        self.revision += 1
        super().update(*args)

    def team_scene(self):
        """Return the robots, with what they carry, as a ``Scene``."""
        team = self.team
        style = MapStyle.of(self, max(team.numbers, default=1))
        return Scene(
            team.kinds(), team.state, style.shades_of(team.numbers, team.fresh), load=team.load
        )

    def scene(self):
        """Return what is shown as a ``Scene``."""
        team, on = self.team, self.shown
        trails = self.trails if on["trails"] and not self._begin_anew else Trails(len(team.numbers))
        rows = {number: row for row, number in enumerate(team.numbers)}
        edges = self.edges.list if on["edges"] else ()
        return self.team_scene()._replace(
            trails=trails_of(team, trails, self._hidden_trails),
            targets=team.in_space(self.targets, self._target_z) if on["targets"] else None,
            edges=[(rows[i], rows[j], w) for i, j, w in edges if i in rows and j in rows],
            directed=self.edges.directed,
            obstacles=self._standing + self._moving,
            numbered=on["numbers"],
            chosen=rows.get(self.selected),
            ghosts=tuple(self._ghosts_in_space()),
            beams=tuple(self._beams()) if on["sensors"] and not self.is_past else (),
        )

    def _beams(self):
        """Yield what sensors have read, and what cameras see, as ``Beams``."""
        team, style = self.team, MapStyle.of(self, max(self.team.numbers, default=1))
        rows, chosen = {number: row for row, number in enumerate(team.numbers)}, self.selected
        heights = team.state.heights
        for (number, name), mount in self.mounts.items():
            row = rows.get(number)
            if row is None or not team.known[row]:
                continue
            shade = style.shade(number).getRgbF()[:3]
            received = self.readings.get((number, name))
            if mount.type == "camera":
                yield of_camera(team.pose[row], heights[row], mount, shade)
            elif received is not None:
                pose = self.pose_of(row, received.reading)
                z = heights[row] + mount.place[2]
                found = of_reading(pose, z, received.reading, shade, number == chosen)
                if found is not None:
                    yield found

    def pose_of(self, row, reading):
        """Return the pose (3,) that the robot in ``row`` had when it took ``reading``.

        Of a real robot, whose clock is another one, that is its newest.
        """
        if self.is_at_rest or self.team.numbers[row] in self.team.real:
            return self.team.pose[row]
        return self._recent.at(row, reading.stamp)

    def _ghosts_in_space(self):
        """Yield what is drawn faintly: compared runs, and where robots may go, as ``Ghosts``."""
        scene = self.team_scene()
        for ghost in self.ghosts:
            yield ghost.in_space(self.shown["trails"])
        if self._has_forecast():
            paths = paths_in_space(self.forecast, scene.state.heights)
            known = [row for row, path in enumerate(paths) if np.isfinite(path).all()]
            yield Ghosts(
                kinds=(),
                place=np.empty((0, 3)),
                turn=np.empty((0, 3, 3)),
                shades=np.empty((0, 3)),
                paths=tuple(paths[row] for row in known),
                path_shades=np.asarray(scene.shades)[known],
                ringed=True,
            )
        if self.ahead is not None and self.ahead.pose.shape[1] == len(self.team.numbers):
            yield self.ahead.in_space(scene)

    # What is shown -------------------------------------------------------------------------------

    def show_kinds(self, kinds):
        """Draw robots 1..n as their ``Kind``s are; a team of another number as the first of them."""
        self.team.take_kinds(kinds)
        self.update()

    def show_load(self, load):
        """Draw the ``load``, a ``load.Load``, where snapshots have it; None for none."""
        self.team.load = load
        self.update()

    def show_team(self, poses, altitude=None):
        """Show robots 1..n at rest at ``poses`` (n, 3) [m, m, rad]; their next run begins there.

        ``altitude`` (n,) [m]: their heights, None for robots on the ground.
        """
        poses = np.array(poses, dtype=float).reshape(-1, 3)
        numbers = tuple(range(1, len(poses) + 1))
        if numbers != self.team.numbers:
            self._begin_team(numbers, poses)
            self.fit(whole=True)
        elif not np.allclose(poses, self.team.pose, atol=1e-3, equal_nan=True):
            self._begin_anew = True
        self.team.show(resting(numbers, poses, altitude))
        self.is_at_rest, self.is_past = True, False
        self._follow()
        self.update()

    def show_snapshot(self, snapshot, passed=None):
        """Show the newest poses of a run; one of another team or an earlier time begins anew.

        ``passed``: the ``StateTable`` of what the team was at several times since the last snapshot,
        where that is long ago; trails lead through it.
        """
        numbers = tuple(int(number) for number in snapshot.robots)
        poses = np.array(snapshot.pose, dtype=float).reshape(-1, 3)
        changed = numbers != self.team.numbers
        if changed:
            self._begin_team(numbers, poses)
        elif self._begin_anew or snapshot.time < self.time:
            self.clear_trails()
        self.time, self._begin_anew, self.is_at_rest = snapshot.time, False, False
        self.last_run, self.is_past = None, False
        self._recent.add(snapshot.time, poses)
        self.team.show(snapshot.replace(robots=numbers, pose=poses))
        if len(self.team.real) < len(numbers):  # real robots alone have another time
            self._move_obstacles(scene_time(snapshot.time))
        if passed is not None and passed.robots == numbers:
            for places, heights in zip(passed.pose[:, :, :2], passed.heights):
                self.trails.add(places, heights)
        self.trails.add(poses[:, :2], self.team.state.heights)
        if changed:
            self.fit(whole=True)
        self._follow()
        self.update()

    def show_past(self, state, trails):
        """Show a run's ``StateTable`` of a moment that has passed, with the ``Trails`` up to then.

        The next snapshot is shown, with these trails, as if it followed that moment.
        """
        if state.robots != self.team.numbers:
            self._begin_team(state.robots, state.pose)
        self.time, self._begin_anew, self.is_at_rest = state.time, False, False
        self.last_run, self.is_past, self.trails = None, True, trails
        self._recent.clear()
        self.team.show(state)
        if len(self.team.real) < len(state.robots):
            self._move_obstacles(scene_time(state.time))
        self._follow()
        self.update()

    def _begin_team(self, numbers, poses):
        self.drag = None
        self.team.show(resting(numbers, poses))
        self.time, self._begin_anew, self.is_at_rest = -math.inf, False, True
        self._recent.clear()
        self.trails = Trails(len(numbers))
        self.flashes.clear()

    def show_targets(self, points):
        """Show the desired positions ``points`` (n, 2) or (n, 3) [m], None for none."""
        known = points is not None and len(points)
        points = np.array(points, dtype=float) if known else np.empty((0, 0))
        shown = points.shape, points.tobytes()  # those not known are NaN
        if shown == self._shown_targets:
            return
        self._shown_targets = shown
        self.targets = points[:, :2] if known else None
        self._target_z = points[:, 2] if points.shape[1] > 2 else None
        self.update()

    def show_forecast(self, paths):
        """Show ``paths`` (k, n, 2) [m] that theory has robots take to where they end, None for none."""
        if paths is not self.forecast:
            self.forecast = paths
            self.update()

    def show_ahead(self, ahead):
        """Show how the run would go on, a ``LookAhead`` of this team, None for nothing."""
        if ahead is not self.ahead:
            self.ahead = ahead
            self.update()

    def show_topology(self, edges, directed=True):
        """Show ``edges``, a list of (i, j, weight): robot i receives from robot j."""
        shown, before = Edges(edges, directed), self.edges
        if (shown.list, shown.directed) == (before.list, before.directed):
            return
        self.edges = shown
        self.update()
        if shown.directed != before.directed:
            self.directed_changed.emit()

    def show_obstacles(self, obstacles, own=0):
        """Show ``obstacles``, ``Box`` and ``Cylinder``, the first ``own`` of which may be edited."""
        self.obstacles = tuple(obstacles)
        self._standing = tuple(each for each in self.obstacles if not moves(each))
        self._movers = tuple(filter(moves, self.obstacles))
        self._move_obstacles(0.0)
        self.editor.show(self.obstacles, own)

    def _move_obstacles(self, time):
        """Have those obstacles that move where they are at ``time`` [s] of the simulation."""
        self._moving = obstacles_at(self._movers, time)

    def _on_obstacles(self, own):
        """Hand on the obstacles as they were edited."""

    def _on_edit(self):
        """Show what an edit under way makes of an obstacle."""
        self.update()

    def clear_trails(self):
        """Forget where the robots have been; new trails begin with the next snapshot."""
        self._forget_trails()
        self.last_run = None
        self.update()

    def _forget_trails(self):
        self.trails, self.time = Trails(len(self.team.numbers)), -math.inf

    def put_aside(self):
        """Show the run faintly from now on, below what will start, until another begins."""
        self.last_run = LastRun(self.team_scene(), self.team.shapes, self.trails)
        self._forget_trails()
        self.update()

    def show_ghosts(self, ghosts, own_name=""):
        """Show the ``Ghost``s of runs compared with the one shown, which is called ``own_name``."""
        self.ghosts, self.own_name = tuple(ghosts), own_name
        self.update()

    def select(self, number):
        """Highlight robot ``number``, 0 for none."""
        self.selected = int(number)
        self.update()

    def show_readings(self, readings, mounts=None):
        """Show what sensors read, ``{(number, name): ReceivedReading}``.

        ``mounts``: their ``Mount``s, and those of cameras, by the same keys; in space alone.
        """
        mounts = mounts or {}
        newest, shown = (
            {key: each.reading for key, each in of.items()} for of in (readings, self.readings)
        )
        same = newest.keys() == shown.keys() and mounts.keys() == self.mounts.keys()
        changed = not same or any(newest[key] is not shown[key] for key in newest)
        self.readings, self.mounts = readings, mounts
        if changed:
            self.update()

    def set_trail_shown(self, number, shown):
        """Show or hide the trail of robot ``number``."""
        (self._hidden_trails.discard if shown else self._hidden_trails.add)(int(number))
        self.update()

    def set_shown(self, layer, shown):
        """Show or hide a ``layer`` of ``shown``."""
        self.shown[layer] = bool(shown)
        self.update()

    def set_mode(self, mode):
        """Choose what the mouse does: ``look``, ``measure``, or edit what another mode is called."""
        if mode not in HINTS:
            raise ValueError("mode {!r}: wanted one of {}".format(mode, ", ".join(HINTS)))
        if mode != self.mode:
            self.mode, self.drag = mode, None
            self.editor.cancel()
            self.update()

    # The view ------------------------------------------------------------------------------------

    def fit(self, whole=False):
        """Bring the whole team, its targets and trails, and obstacles not far from them into view.

        ``whole``: all obstacles, however far away, but for land.
        """
        self.untouched, self._whole = True, whole
        self._look_at(self._bounds(everything=True), self.team.shapes.farthest)

    def _bounds(self, everything):
        """Return points (k, 2) about the team, with ``everything`` about targets and obstacles too."""
        parts = [self.team.pose[self.team.known, :2]]
        if everything and self.targets is not None and self.shown["targets"]:
            parts.append(self.targets[np.isfinite(self.targets).all(axis=1)])
        if everything and self._has_forecast():
            parts.append(self._foreseen(np.concatenate(parts)))
        if everything and self.shown["trails"]:
            parts.append(self.trails.bounds())
            parts += [trail for ghost in self.ghosts for trail in ghost.trails]
        points = np.concatenate(parts)
        if not everything or not len(points):
            return points
        low, high = points.min(axis=0), points.max(axis=0)
        reach = np.inf if self._whole else max(REACH, np.max(high - low))
        return np.stack(with_obstacles(low, high, self.obstacles, reach))

    def _foreseen(self, points):
        """Return the points (k, 2) [m] of the forecast, but for those too far to see the team beside them.

        ``points`` (m, 2) [m]: of the team and its targets.  An unstable law's theory goes to infinity.
        """
        paths = self.forecast.reshape(-1, 2)
        if not len(points):
            return paths[np.isfinite(paths).all(axis=1)]
        return paths[are_near(paths, points, FORESEEN, REACH)]

    def _has_forecast(self):
        """Return whether there are paths of this team to be seen."""
        paths = self.forecast if self.shown["forecast"] else None
        return paths is not None and paths.shape[1] == len(self.team.numbers)

    def _look_at(self, points, room):
        if len(points):
            low, high = points.min(axis=0) - room, points.max(axis=0) + room
            self.frame.look_at(low, high, self.fontMetrics().height())  # numbers need room too
        self.update()

    def _follow(self):
        """Widen an untouched view once a robot leaves it, with room so that it stays for a while."""
        if not self.untouched or self.drag is not None:
            return
        position = self._bounds(everything=False)
        if not self.frame.sees(self.frame.to_screen(position)).all():
            points = self._bounds(everything=True)
            self._look_at(points, self.team.shapes.farthest + ROOM * np.ptp(points, axis=0).max())

    def to_screen(self, x, y):
        """Return where the point (x, y) [m] is in the widget, (x, y) [px]."""
        return tuple(self.frame.to_screen((x, y)).tolist())

    def to_plane(self, x, y):
        """Return the point (x, y) [m] that is at (x, y) [px] in the widget."""
        return tuple(self.frame.to_plane((x, y)).tolist())

    def sizeHint(self):
        """Return a size for the eye; any other does."""
        line = self.fontMetrics().height()
        return QSize(40 * line, 32 * line)

    def minimumSizeHint(self):
        """Return the least size at which something is to be seen."""
        line = self.fontMetrics().height()
        return QSize(14 * line, 6 * line)

    def resizeEvent(self, event):
        self._measure()

    def changeEvent(self, event):
        if event.type() == QEvent.FontChange:
            self._measure()
        super().changeEvent(event)

    def _measure(self):
        self.frame.area = axes.plot_area(self)
        if self.untouched:
            self.fit(self._whole)
