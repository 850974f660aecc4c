"""Writes a run's data, figures and verdict; without Qt."""

import os
import re
import shutil
import threading
import time

from mrs_simulator.core.load import Carried
from mrs_simulator.core.moving import scene_facts, scene_time
from mrs_simulator.core.recording import write_facts
from mrs_simulator.core.spatial import upright
from mrs_simulator.rqt_plugin.run.trouble import Trouble
from mrs_simulator.study.report import VERDICT_FILE, begin_run
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.vehicles.team_in_space import team_of

CANCELLED = "cancelled; what was written is in {}"
REPORT_LIMIT = 300.0  # [s] of wall time for figures and verdict
KEPT = "unsaved"  # the directory of runs that were not saved when another one began
MOST_KEPT = 20  # [-] of them


class RunFiles:
    """Saves runs of the edited scenario, in the background."""

    def __init__(self, connection, processes, edited, missed):
        """``edited``: the ``EditedScenario``; ``missed``: the ``MissedPeriods`` of the run."""
        self._connection, self._processes = connection, processes
        self._edited, self._missed = edited, missed
        self.saving, self._cancelled = "", threading.Event()  # what a save is at

    @staticmethod
    def results_directory():
        """Return where results are suggested to go."""
        return os.path.join(os.path.expanduser("~"), "mrs_runs")

    def suggested_name(self):
        """Return a name of the run: its title and the time."""
        title = re.sub(r"[^a-z0-9]+", "_", (self._edited.scenario.title or "run").lower()).strip(
            "_"
        )
        return "{}_{}".format(title[:40], time.strftime("%Y%m%d_%H%M%S"))

    def save(self, history, directory):
        """Write ``run.csv``, scenario, figures and verdict to ``directory``, in the background."""
        write = self._writing(history, directory)
        self._cancelled.clear()

        def work():
            self.saving = "writing run.csv"
            path = write()
            self.saving = "making figures and the verdict"
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            arguments = [path, "--out", directory, "--formats", "png,pdf,svg"]
            code, said = self._processes.run("report", "report", *arguments, limit=REPORT_LIMIT)
            if self._cancelled.is_set():
                return False, CANCELLED.format(directory)
            verdict = os.path.join(directory, VERDICT_FILE)
            return (True, verdict) if code in (0, 1) and os.path.exists(verdict) else (False, said)

        self.saving = "preparing"
        self._connection.do("save", work)

    def cancel(self):
        """Save no more than the data; the answer of ``save`` says so."""
        self._cancelled.set()
        self._processes.cancel("report")

    def keep(self, history):
        """Write the data of a run that nobody has saved beside the other results; return a message."""
        folder = os.path.join(self.results_directory(), KEPT)
        directory = os.path.join(folder, self.suggested_name())
        try:
            os.makedirs(directory, exist_ok=True)
            path = self._writing(history, directory)()
            runs = sorted(os.scandir(folder), key=lambda entry: entry.stat().st_mtime)
            for entry in runs[:-MOST_KEPT]:
                shutil.rmtree(entry.path, ignore_errors=True)
        except OSError as error:
            return Trouble("the run before was not saved, and is lost: {}".format(error))
        return "the run before was not saved; its data is kept in {}".format(path)

    def _writing(self, history, directory):
        """Return a function that writes a run's data, and returns its path; from any thread."""
        # The run begins with the first command, as it does for the recorder.
        begin = history.first_row()
        when, pose = history.time[begin:].copy(), history.pose[begin:].copy()
        command, joints = history.command[begin:].copy(), history.joints[begin:].copy()
        twist, spatial = history.twist[begin:].copy(), history.spatial
        heights = None if spatial is None else spatial.of(slice(begin, None)).copy()
        load = history.load and Carried(*(each[begin:].copy() for each in history.load))
        axes = history.axes
        numbers, scenario = history.numbers, self._edited.scenario
        collisions = [
            c._replace(time=c.time - when[0]) for c in history.collisions if c.time >= when[0]
        ]
        meta = self._told(when[0], when[-1], history.real.issuperset(numbers))
        if history.begun is None:
            meta["uncommanded"] = True
        elif self._missed.text():
            meta["degraded"] = self._missed.text()
        if not history.real.issuperset(numbers):
            meta.update(scene_facts(scenario.obstacles, scene_time(when[0])))
        scenario = scenario._replace(duration=max(float(when[-1] - when[0]), 1e-3), poses=pose[0])
        if heights is not None:
            scenario = scenario._replace(altitude=heights.z[0])
        team = team_of(scenario._replace(kinds=_kinds_of(scenario, numbers)))

        def write():
            columns = team.record_columns
            kept = columns.spatial and (heights is not None or team.has_arms)
            columns = columns._replace(spatial=kept, load=load is not None)
            with begin_run(scenario, directory, numbers, columns=columns) as file:
                samples = zip(when - when[0], pose, command, joints, twist)
                for row, (stamp, poses, given, inner, speeds) in enumerate(samples):
                    points = team.point(poses, inner, scenario.hand_length)
                    given = given if axes == team.axes else on_axes(given, axes, team.axes)
                    more = speeds, inner, None if heights is None else heights.of(row)
                    if team.has_arms:
                        tools = team.tools(poses, inner, scenario.hand_length)
                        flat = upright(poses[:, 2]) if more[2] is None else more[2]
                        more = speeds, inner, flat, flat.z + tools[:, 2]
                    if load is not None:
                        more += (load.at(row),)
                    file.sample(round(float(stamp), 9), poses, given, points, *more)
            write_facts(file.path, collisions, meta)
            return file.path

        return write

    def _told(self, begin, end, real):
        """Return what is known of a run from ``begin`` to ``end`` [s], of robots that are all ``real``."""
        controller, origin = (
            self._connection.controller,
            self._connection.first_stamp() if real else 0.0,
        )
        meta = {"warnings": controller.warnings(origin + begin, origin + end)}
        ended = controller.ended(origin + begin)
        meta.update({"ended": ended} if ended else {})
        # Nobody tells of real robots' collisions.
        return dict(meta, collisions_unknown=True) if real else meta


def _kinds_of(scenario, numbers):
    """Return the kinds of the robots ``numbers`` of ``scenario``."""
    kinds = scenario.kinds
    return (
        kinds
        if len(kinds) == len(numbers)
        else tuple(kinds[min(n, len(kinds)) - 1] for n in numbers)
    )
