"""A run in three dimensions: a picture of it for a paper, or what its animation shows."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mrs_simulator.pictures.camera import Camera
from mrs_simulator.pictures.moving_parts import Odometer
from mrs_simulator.pictures.palette import LIGHT
from mrs_simulator.pictures.scene import Scene, drawn, framed
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at
from mrs_simulator.scenario.team.robots import DEFAULT_KIND
from mrs_simulator.study.draw.canvas import save
from mrs_simulator.study.draw.figure_parts import robot_colours
from mrs_simulator.study.draw.paint import DPI, paint
from mrs_simulator.study.draw.style import LookError
from mrs_simulator.study.results.stamp import stamp_of
from mrs_simulator.vehicles import Team

PAGE, FINE = 6.5, 150  # [in] width and [px/in] of a picture
HEIGHT = 0.62  # [-] of the width
FROM = Camera(yaw=20.0, pitch=-35.0)


class Film:
    """The scenes of a ``Run``, one for each sample, and a camera that has all of them in view.

    ``control``: of it the graph and, where the law has some, the targets are shown.  Raises ``LookError``
    for a run without samples.
    """

    def __init__(self, run, control=None):
        if not len(run.time):
            raise LookError("a run without samples has no pictures")
        self.run, self._control = run, control
        self._kinds = _kinds(run)
        self._shades = robot_colours(run.robots)[:, :3]
        topology = control.topology if control is not None else None
        self._edges = [(i - 1, j - 1, w) for i, j, w in topology.edges] if topology else []
        self._directed = topology.directed if topology else True
        self._places = np.dstack([run.pose[..., :2], run.heights])
        odometer = Odometer()
        self._rolled = [odometer.at(tuple(run.robots), pose) for pose in run.pose]

    def scene(self, row):
        """Return the ``Scene`` of sample ``row``, with trails from the first one on."""
        run = self.run
        row = range(len(run.time))[row]
        return Scene(
            kinds=self._kinds,
            state=run.at(row),
            shades=self._shades,
            trails=tuple(np.moveaxis(self._places[: row + 1], 1, 0)),
            targets=self._targets(row),
            edges=self._edges,
            directed=self._directed,
            obstacles=self._obstacles(float(run.time[row])),
            load=None if run.scenario is None else run.scenario.load,
            rolled=self._rolled[row],
        )

    def _obstacles(self, time):
        if self.run.scenario is None:
            return ()
        begun = self.run.meta.get("scene_time", 0.0)
        return obstacles_at(obstacles_of(self.run.scenario), begun + time)

    def _targets(self, row):
        """Return the targets (n, 3) [m] at sample ``row``, planar ones at the robots' heights, or None."""
        hand, found = self.run.hand[row], None
        if self._control is not None:
            hand = self.run.in_space(self._control.dimension).hand[row]
            # of a team that marches
            self._control.time = float(self.run.time[row] - self.run.time[0])
            found = self._control.targets(hand)
        if found is None or np.shape(found) != hand.shape:
            return None
        if hand.shape[1] == 3:
            return found
        of_tools = self._kinds[0].arm is not None and self.run.point_z is not None
        height = self.run.point_z[row] if of_tools else self._places[row, :, 2]
        return np.column_stack([found, height])

    def camera(self, width, height, camera=FROM):
        """Return ``camera``, looking as it does, with the whole run in view."""
        return framed(self.scene(-1), camera, width, height)

    def drawing(self, row, width, height, camera=None):
        """Return the ``Drawing`` of sample ``row``, by default by :meth:`camera`."""
        camera = self.camera(width, height) if camera is None else camera
        return drawn(self.scene(row), camera, width, height, LIGHT)


class SpaceStage:
    """Shows a ``Film`` on a figure, ``width`` [in] wide, as ``animation.Stage`` does from above."""

    def __init__(self, film, width):
        self.film = film
        self.figure = Figure(figsize=(width, HEIGHT * width), dpi=DPI)
        FigureCanvasAgg(self.figure)
        self._size = [int(round(DPI * side)) for side in self.figure.get_size_inches()]
        self._camera = film.camera(*self._size)

    def show(self, row):
        """Show sample ``row`` of the run."""
        self.figure.clear()
        axes = self.figure.add_axes([0.0, 0.0, 1.0, 1.0])
        paint(axes, self.film.drawing(row, *self._size, self._camera))
        time_text = "{:.1f} s".format(self.film.run.time[row])
        axes.text(8, 14, time_text, size=9, va="center", color=LIGHT.text, zorder=99)

    def picture(self, row):
        """Return sample ``row`` as (height, width, 4) uint8."""
        self.show(row)
        self.figure.canvas.draw()
        return np.array(self.figure.canvas.buffer_rgba())


def _kinds(run):
    """Return the robots' ``Kind``s, a tuple: of the scenario, else of the recording."""
    if run.scenario is not None and run.scenario.n == len(run.robots):
        return Team.from_scenario(run.scenario).kinds
    return Team(run.kinds or [DEFAULT_KIND] * len(run.robots)).kinds


def write_picture(film, path, row=-1, width=PAGE):
    """Write sample ``row`` of ``film``, ``width`` [in] wide, to ``path``; return it.

    The ending chooses png, pdf or svg; the latter two are of vectors.
    """
    figure = Figure(figsize=(width, HEIGHT * width), dpi=FINE)
    FigureCanvasAgg(figure)
    size = [int(round(FINE * side)) for side in figure.get_size_inches()]
    paint(figure.add_axes([0.0, 0.0, 1.0, 1.0]), film.drawing(row, *size))
    return save(figure, path, stamp_of(film.run.scenario))
