"""Writes the samples of a run to ``run.csv``; without Qt and ROS."""

import numpy as np

from mrs_simulator.record.recording import write_facts
from mrs_simulator.state.columns import TWIST, Z
from mrs_simulator.study.results.report import begin_run
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.vehicles.team_in_space import team_of


def estimated(run):
    """Return the samples of a ``History`` with the poses that the control estimated, and how many are lost.

    Lost are those without an estimate of their times; after the last estimate a run is over.  Of a
    control that estimated nothing all samples are returned.
    """
    if run.estimate is None:
        return run, 0
    known = np.isfinite(run.estimate).all(axis=(1, 2))
    if not known.any():
        return run.without_estimates(), 0
    end = len(known) - int(np.argmax(known[::-1]))
    lost = end - int(np.count_nonzero(known))
    return run.kept(known if lost else slice(0, end)), lost


def write_run(run, scenario, directory, meta, report):
    """Write the ``History`` ``run`` of ``scenario`` to ``directory``; return the path of ``run.csv``."""
    when, states = run.time, run.state
    truth = run.estimate if meta.get("truth_unknown") else run.pose
    scenario = _for_robots(scenario, run.numbers)
    lasted = float(when[-1] - when[0])
    lasted = round(lasted, 9) if when[0] else lasted  # as the last sample has it
    scenario = scenario._replace(duration=max(lasted, 1e-3), poses=truth[0])
    if states.has(Z):
        scenario = scenario._replace(altitude=states.z[0])
    team = team_of(scenario)
    l, hundredth = scenario.hand_length, max(1, len(when) // 100)
    states = states.replace(time=when - when[0], pose=truth)
    if run.axes != team.axes:
        commands = [on_axes(each, run.axes, team.axes) for each in states.command]
        states = states.replace(axes=team.axes, command=np.array(commands))
    layout = team.layout(team.recorded(states.at(0), l).has)
    if meta.get("real"):  # whose velocities no difference of poses tells
        layout = layout.also(TWIST)
    with begin_run(scenario, directory, run.numbers, layout=layout) as file:
        for row in range(len(when)):
            if row % hundredth == 0:
                report(row / len(when))
            state = team.recorded(states.at(row), l)
            # Without the rounding of a difference a run has the times of one without a window.
            file.sample(round(float(state.time), 9) if when[0] else float(state.time), state)
    collisions = [c._replace(time=c.time - when[0]) for c in run.collisions if c.time >= when[0]]
    write_facts(file.path, collisions, meta)
    return file.path


def _for_robots(scenario, numbers):
    """Return ``scenario`` for the robots ``numbers``, under a title with their number."""
    n, kinds = len(numbers), scenario.kinds
    if n == scenario.n:
        return scenario
    try:
        scenario = scenario.with_robots(n)
    except ValueError:  # edges of robots that were not there
        scenario = scenario._replace(topology=None).with_robots(n)
    return scenario._replace(kinds=tuple(kinds[min(i, len(kinds)) - 1] for i in numbers))
