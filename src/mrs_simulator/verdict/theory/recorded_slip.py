"""The run that theory gives of robots with masses, whose slip is taken from the record.

Wheels slip, motors lag, bodies lean, hulls drift: robots go elsewhere than their commands say.  By how
much is known wherever poses and commands were recorded together, and need not be guessed.
"""

import numpy as np

from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.protocols.published.laws import MOST_PAIRS
from mrs_simulator.protocols.published.robots import are_stated
from mrs_simulator.verdict.law.published_checks import as_known
from mrs_simulator.verdict.theory.exact_runs import published_law
from mrs_simulator.verdict.theory.one_step_predictions import commands_between


def run_with_recorded_slip(control, run):
    """Return the ``Run`` of robots under the published law that slip as those of ``run`` do.

    From sample to sample, ``h`` [s] later, the recorded points p went ``p+ - p``, and their commands asked
    for ``h u``; the difference s is what these robots made of it.  Theory's points go

        q+ = q + h f(q) + s,

    f the published law, as these robots' limits let it pass at the recorded poses; of poses that were
    estimated it sees q as far off as the recorded estimates were.  Of several commands between two samples
    the velocities are taken from a straight line, in u and in f alike.

    None where that is not known: of laws that see more than places and time, over faulty edges, of
    samples beside commands or not in lockstep, of odometry that was not recorded, and where it is too long
    to compute.
    """
    law, time = published_law(control), run.time - run.time[0]
    counts = commands_between(time, control.period)
    if law is None or counts is None or not _is_known(control, run, law):
        return None
    memory, known = law.begin(run.hand[0]), as_known(control, run)
    robots = robots_of(control)

    def asked(row, points=None):
        """Return the velocities (n, d) [m/s] of the recorded command, or of the law at ``points``."""
        command = run.command[row]
        if points is not None:
            seen = points + known.hand[row] - run.hand[row]
            robots.be_as(known, row)
            command = robots.commands(law.velocity(seen, time[row], memory)[0])
        robots.be_as(run, row)
        return robots.velocities(command)

    points, went = run.hand[0], np.diff(run.hand, axis=0)
    track = [points]
    for row, count in enumerate(counts):
        late = 0.5 * (1.0 - 1.0 / count)  # the share of the velocity at the next sample
        off = asked(row, points) - asked(row)
        if late:  # where the points will be, but for what differs within this sample
            then = points + went[row]
            off = (1.0 - late) * off + late * (asked(row + 1, then) - asked(row + 1))
        points = points + went[row] + count * control.period * off
        track.append(points)
    hand = np.array(track)
    return run._replace(hand=hand, meta={}, load=None) if np.isfinite(hand).all() else None


def _is_known(control, run, law):
    return (
        law.SEES == "now"
        and bool(run.meta.get("lockstep"))
        and run.scenario is not None
        and (run.scenario.odometry == "world" or run.estimate is not None)
        and not control.links.faults
        and are_stated(control.team)
        and not np.any(control.safety)
        and 2.0 * law.WORK * len(run.time) * len(run.robots) ** 2 <= MOST_PAIRS
    )
