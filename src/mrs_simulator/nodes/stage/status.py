"""The stage's status: published, logged where something has changed, and for ``/diagnostics``."""

import time

import numpy as np
import rospy

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.nodes.stage.world_topics import publisher
from mrs_simulator.ros.message_forms.messages import StageStatus, stage_status
from mrs_simulator.ros.node.diagnostics import Diagnostics, Rates, sensors_health, stage_health

STATUS_PERIOD = 0.2  # [s] of wall time
MOST_NAMED = 8  # [-] robots named in one message


def named(rows):
    """Return robots of ``rows`` for a message: all of a few, else the first and how many."""
    shown = ", ".join("robot{}".format(row + 1) for row in rows[:MOST_NAMED])
    more = len(rows) - MOST_NAMED
    return shown + (" and {} more".format(more) if more > 0 else "")


class StatusTopic(StagePart):
    """The topic ``~status`` of a stage."""

    def __init__(self, stage, mirror, sensors, ignored):
        """``mirror``, ``sensors``, ``ignored``: the parts of ``stage`` that have a share in it."""
        self._stage, self._last = stage, 0.0  # [s] of wall time
        self._mirror, self._sensors, self._ignored = mirror, sensors, ignored
        self._publisher = publisher("~status", StageStatus, queue_size=1)
        self._real_silent, self._jumped = [], frozenset()
        self._silent, self._refused = set(), np.zeros(0, dtype=int)
        self._facts, self._sensor_rates = None, Rates()  # of the last status
        self._diagnostics = Diagnostics(self._health)

    def follow_team(self, scenario):
        """Begin anew, with robots of which none is silent, nor any command refused."""
        self._silent, self._refused = set(), np.zeros(self._stage.world.n, dtype=int)

    def _say_what_changed(self):
        """Log who fell silent, whose watchdog has stopped them, and commands that were refused."""
        self._say_who_is_lost()
        commands = self._stage.world.commands
        silent = set(np.flatnonzero(commands.timed_out).tolist())
        new = sorted(silent - self._silent)
        if new:
            waited = float(commands.timeouts[new].max())
            rospy.logwarn("stage: %s stopped: no command for %g s", named(new), waited)
        self._silent = silent
        refused = np.flatnonzero(commands.refused > self._refused).tolist()
        if refused:
            text = "stage: refused commands for {}: not finite, or impossibly large"
            rospy.logwarn_throttle(5.0, text.format(named(refused)))
            self._refused = commands.refused.copy()

    def _say_who_is_lost(self):
        """Log the real robots that fell silent or jumped."""
        mirror = self._mirror
        lost, jumps = mirror.silent(), mirror.jumps()
        new = [row for row in lost if row not in self._real_silent]
        if new:
            timeout = mirror.frame.odom_timeout
            rospy.logwarn("stage: no odometry of real %s for %g s", named(new), timeout)
        for row in set(jumps).difference(self._jumped):
            go_on = "call pioneer_control/start or stage/reset to follow it again"
            rospy.logerr("stage: %s: %s", jumps[row], go_on)
        self._real_silent, self._jumped = sorted({*lost, *jumps}), frozenset(jumps)

    def show(self):
        """Publish the stage's status where its period is over, and log what has changed."""
        if time.monotonic() - self._last < STATUS_PERIOD:
            return
        self._last = time.monotonic()
        self._say_what_changed()
        self._facts = facts = self._now()
        stage = self._stage
        message = stage_status(stage.topics.stamp(), stage.round_trips.median_and_p99(), **facts)
        self._publisher.publish(message)

    def _now(self):
        """Return the fields of the status."""
        stage, world = self._stage, self._stage.world
        waiting = stage.lockstep.waiting_for if stage.lockstep and stage.is_started else []
        states = world.flights.states()
        return dict(
            fidelity=stage.scenario.fidelity,
            stage=stage.id,
            run=stage.run,
            trouble=stage.trouble,
            robots=world.n,
            speed=stage.pacer.speed,
            real_time_factor=stage.pacer.real_time_factor,
            paused=stage.paused,
            lockstep=stage.lockstep is not None,
            waiting_for=[row + 1 for row in waiting],
            timed_out=[row + 1 for row in sorted(self._silent)],
            refused=world.commands.refused.tolist(),
            unobeyed=self._ignored.counts.tolist(),
            real_silent=[row + 1 for row in self._real_silent],
            missed_periods=stage.round_trips.missed,
            command_periods=stage.round_trips.periods,
            collisions=stage.topics.collisions,
            incidents=stage.topics.incidents,
            flight=[states.get(row, "") for row in range(world.n)] if states else [],
            closest_approach=world.contacts.measure(),
            slow_sensors=self._sensors.slow(stage.pacer.speed, stage.pacer.real_time_factor),
        )

    def _health(self):
        """Return how the stage and the sensors are, for ``/diagnostics``."""
        if self._facts is None:
            return []
        rates = self._sensor_rates.of(dict(self._sensors.counts))
        slow = self._facts["slow_sensors"]
        return [stage_health(self._facts), sensors_health(rates, slow)]
