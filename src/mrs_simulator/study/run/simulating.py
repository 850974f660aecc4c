"""Experiments from Python: ``run = simulate("paper.yaml", protocol=MyLaw)``."""

import os
import tempfile

from mrs_simulator.protocols.loading import choose_protocol, load_protocol
from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.scenario.scenario import Scenario, load_scenario, scenario_from_dict
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.results.report import RUN_FILE, control_of, read_run, write_report
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.verdict import verdict_text


def simulate(scenario, protocol=None, out=None, parameters=None, progress=False, **changes):
    """Run ``scenario`` headless and return the :class:`StudyRun`.

    ``scenario``: a ``Scenario``, a mapping with the keys of a scenario's file, the path of one, or the
    name of a shipped one; ``protocol``: a ``PioneerControl`` subclass or a name, by default what the
    scenario says; ``out``: a directory that keeps ``run.csv``, by default a temporary one;
    ``parameters`` of the protocol by name, over the scenario's; ``changes``: of its keys, such as
    ``robots=7``, ``duration=60.0``, ``seed=1``, ``fidelity="dynamic"``.  Raises ``ValueError`` that
    names what is wrong.
    """
    scenario = _scenario(scenario).overridden(**changes)
    if isinstance(protocol, str):
        protocol = load_protocol(protocol, beside=scenario.path)
    scenario, protocol = choose_protocol(scenario, protocol)
    if not isinstance(parameters, (dict, type(None))):
        raise ScenarioError("parameters: {}, wanted a mapping".format(shown(parameters)))
    if parameters:
        given = {**scenario.control.parameters, **parameters}
        scenario = scenario._replace(control=scenario.control._replace(parameters=given))
    kept = None if out is not None else tempfile.TemporaryDirectory(prefix="mrs_simulator")
    directory = str(out) if kept is None else kept.name
    recorded, control = perform(scenario, directory, protocol, progress)
    return StudyRun(recorded, control, directory, kept)


def open_run(path):
    """Return the :class:`StudyRun` recorded in the directory ``path``, or in a run.csv.

    It is judged by the protocol that the scenario beside it names.  Raises ``ValueError``.
    """
    run = read_run(str(path))
    directory = str(path) if os.path.isdir(str(path)) else os.path.dirname(str(path))
    return StudyRun(run, control_of(run), directory)


def _scenario(given):
    if isinstance(given, Scenario):
        return given
    if isinstance(given, dict):
        return scenario_from_dict(given, "simulate")
    return load_scenario(scenario_path(str(given)))


class StudyRun:
    """A run with its verdict: arrays, a table, figures and an animation.

    ``run``: the ``recording.Run`` with the arrays ``time`` (m,) [s], ``pose`` (m, n, 3), ``hand``
    (m, n, 2), ``command`` (m, n, a); ``verdict``: the mapping of verdict.json; ``prediction``: theory's
    hand points, or None, as :func:`study.judging.judged` has them; ``directory``: where ``run.csv`` is.
    """

    def __init__(self, run, control, directory, kept=None):
        """``kept``: a temporary directory that lasts as long as this."""
        self.run, self.directory, self._control, self._kept = run, directory, control, kept
        self.verdict, self.prediction = judged(run, control)

    def __str__(self):
        return verdict_text(self.verdict)

    def __repr__(self):
        return "<StudyRun {}: {}>".format(self.verdict["title"], self.verdict["outcome"])

    @property
    def passed(self):
        """Return whether the verdict is that the run agrees with theory."""
        return self.verdict["passed"]

    def trajectories(self, ax=None, width="", style=""):
        """Draw the paths in the plane on ``ax``, or on a new figure; return the figure.

        ``width``: ``"page"``, ``"column"``, inches or ``"88mm"``; ``style``: a mapping of rcParams, the
        name of one of matplotlib's styles or the path of an ``.mplstyle`` file.
        """
        from mrs_simulator.study.draw import figures

        return self._drawn(figures.draw_trajectories, figures.trajectories_height, ax, width, style)

    def states(self, component="x", ax=None, width="", style=""):
        """Draw ``component``, ``"x"`` or ``"y"``, against time; see :meth:`trajectories`."""
        from mrs_simulator.study.draw import figures

        def draw(figure, run, prediction, axes):
            return figures.draw_states(figure, run, component, prediction, axes)

        return self._drawn(draw, figures.HEIGHT, ax, width, style)

    def inputs(self, ax=None, width="", style=""):
        """Draw the commands against time, on one ``ax`` for each input; see :meth:`trajectories`."""
        from mrs_simulator.study.draw import figures

        def draw(figure, run, prediction, axes):
            return figures.draw_inputs(figure, run, axes)

        return self._drawn(draw, figures.inputs_height(self.run), ax, width, style)

    def _drawn(self, draw, height, ax, width, style):
        from mrs_simulator.study.draw import figures
        from mrs_simulator.study.draw.style import look

        wanted = look(width, style)
        with figures.in_style(wanted.style):
            if ax is not None:
                axes = draw(None, self.run, self.prediction, ax)
                return (axes[0] if isinstance(axes, tuple) else axes).figure
            if callable(height):
                high = height(self.run, self.prediction, wanted.width)
            else:
                high = wanted.scaled(height)
            figure = figures.new_figure(wanted.width, high)
            draw(figure, self.run, self.prediction, None)
            figures.settle(figure)
        return figure

    def animate(self, seconds=8.0, rate=12.0, width=4.8, space=False):
        """Return the ``animation.Animation``: ``save("run.gif")``, and shown in a notebook.

        ``space``: in three dimensions instead of from above.
        """
        from mrs_simulator.study.draw.animation import Animation
        from mrs_simulator.study.draw.space_film import Film, SpaceStage

        def stage(run, inches):
            return SpaceStage(Film(run, self._control), inches)

        return Animation(self.run, seconds, rate, width, stage if space else None)

    def to_pandas(self):
        """Return run.csv as a ``pandas.DataFrame``, one row for each sample and robot."""
        import pandas

        path = os.path.join(self.directory, RUN_FILE)
        return pandas.read_csv(path, float_precision="round_trip")

    def save(self, out, formats=("png", "pdf"), width="", style=""):
        """Write figures and ``verdict.json`` to the directory ``out``; return ``out``."""
        from mrs_simulator.study.draw.style import look

        write_report(self.run, str(out), formats, self._control, look(width, style))
        return out
