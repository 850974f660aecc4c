"""The files of a run in a window without ROS: those of a run without a window."""

import os
import sys

from mrs_simulator.core.writing import write_text
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.record.controller_log import Interruptions
from mrs_simulator.record.recording import facts_path, facts_text
from mrs_simulator.record.run_changes import ControllerRecord, to_plain
from mrs_simulator.study.results.report import RUN_FILE, SCENARIO_FILE, begin_run, is_result
from mrs_simulator.study.run.experiment import facts_of, samples_of

COMPLETE = "complete"
FACTS_FILE = facts_path(RUN_FILE)


class RunRecord:
    """Records the run of an ``Experiment`` to a directory, every sample at once."""

    def __init__(self, experiment, directory):
        """``directory``: exists, and is the run's alone."""
        self.directory, self._experiment = directory, experiment
        layout = experiment.layout
        self._recorder = begin_run(experiment.scenario, directory, report=_report, layout=layout)
        self._sensors = experiment.record_sensors(directory, _report)
        self._settings, self._stops, self._ended = ControllerRecord(), Interruptions(), COMPLETE
        self._samples, self._stamp = 0, 0.0
        self._stops.note(0.0, True, "")

    def sample(self):
        """Record the state of now, unless the run has ended; ``LawFailed`` of a team driven apart."""
        if self._ended == COMPLETE:
            self._add(*self._experiment.sample())

    def _add(self, stamp, pose, command):
        self._recorder.sample(stamp, self._experiment.state(pose, command))
        self._recorder.flush()  # a law may hang at the next step
        self._samples, self._stamp = self._samples + 1, stamp

    def note_settings(self, settings):
        """Note that the controller obeys ``settings`` from now on, plain values by keys."""
        self._settings.note(self._experiment.world.time, settings)

    def note_stop(self, trouble):
        """Note that the controller stopped all robots now, and why."""
        self._stops.note(self._experiment.world.time, False, trouble)

    def fail(self, error):
        """Note that the run ends now by ``error``, a ``LawFailed``."""
        world = self._experiment.world
        if world.time == 0.0:  # where the robots stand is known all the same
            self._add(world.time, world.pose, world.command)
        self._ended = str(error)

    def write(self):
        """Write what waits; return ``{name: size [bytes]}`` of the tables now, and texts of other files.

        They are those of a run that ends now.
        """
        self._recorder.flush()
        if self._sensors is not None:
            self._sensors.flush()
        return {**sizes(self.directory), **self._texts()}

    def _texts(self):
        scenario, experiment = self._experiment.scenario, self._experiment
        if self._ended == COMPLETE and self._samples != samples_of(scenario):
            scenario = scenario._replace(duration=max(self._stamp, 1e-3))
        ended = self._ended
        if ended == COMPLETE:
            ended = self._stops.emergency(0.0, self._stamp) or ended
        facts = facts_of(experiment, self._recorder, self._sensors, ended)
        facts["warnings"] = facts["warnings"] + self._stops.warnings(0.0, self._stamp)
        changes = self._settings.during(0.0, self._stamp)[1]
        facts.update({"changes": to_plain(changes)} if changes else {})
        return {
            SCENARIO_FILE: from_anywhere(scenario).to_yaml(),
            FACTS_FILE: facts_text(experiment.collisions, facts),
        }

    def close(self):
        """Finish all files, ``run.json`` too, which a run that goes on has not."""
        try:
            for name, text in self._texts().items() if self._samples else ():
                write_text(os.path.join(self.directory, name), text)
        finally:
            self._recorder.close()
            if self._sensors is not None:
                self._sensors.close()


def sizes(directory):
    """Return ``{name: size [bytes]}`` of the files of the run in ``directory``."""
    names = [name for name in os.listdir(directory) if is_of_run(name)]
    return {name: os.path.getsize(os.path.join(directory, name)) for name in names}


def is_of_run(name):
    """Return whether a file called ``name`` is the data of a run."""
    return name in (RUN_FILE, FACTS_FILE, SCENARIO_FILE) or is_result(name)


def _report(text):
    print("simulation: " + text, file=sys.stderr)
