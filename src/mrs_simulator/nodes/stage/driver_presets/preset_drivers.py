"""What the presets of robots off the ground share: who they are, topics and services, a mailbox."""

import math
import threading

import numpy as np
import rospy

from mrs_simulator.core.spatial import rotated
from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.message_forms.optional_messages import found, missing_text
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.firmware.crazyflie import State


def rows_of(team, drive, absent=()):
    """Return the rows of the robots of ``team`` of a ``drive``, without those ``absent``."""
    return [row for row, kind in enumerate(team.kinds) if kind.drive == drive and row not in absent]


def refuse_without(scenario, preset, drive, wanted, fidelities):
    """Raise ``ValueError`` where no robot of ``scenario`` has the ``drive``, or the fidelity does not
    fit."""
    if scenario.fidelity not in fidelities:
        text = "preset {}: fidelity {}, wanted {}"
        raise ValueError(text.format(preset, scenario.fidelity, " or ".join(fidelities)))
    if not rows_of(Team.from_scenario(scenario), drive):
        raise ValueError(
            "preset {}: no robot is a {}; wanted one, such as {}".format(preset, drive, wanted)
        )


class Mailbox:
    """Messages kept by subscribers' threads until the main loop takes them, in the order they came."""

    def __init__(self):
        self._lock, self._messages = threading.Lock(), []

    def put(self, message, to):
        """Keep ``message`` for ``to``, a function of it."""
        with self._lock:
            self._messages.append((to, message))

    def serve(self):
        """Give each message to whom it is for."""
        with self._lock:
            taken, self._messages = self._messages, []
        for to, message in taken:
            to(message)


class PresetDrivers(StagePart):
    """The drivers of the simulated robots of one drive; those of other drives obey as without a preset.

    A preset says its ``NAME``, ``DRIVE`` and ``OFFERS``, what it needs of packages that may be missing, and
    ``open_robot``.
    """

    NAME = DRIVE = ""
    OFFERS = ()

    def __init__(self, world, requests, absent=()):
        """``requests`` runs what services ask for; ``absent``: rows of robots without a driver here."""
        self.world, self.requests, self._absent = world, requests, set(absent)
        self.mailbox, self._open = Mailbox(), {}
        self.goals = {}  # what a robot goes on with until something else comes, by row
        self.types, missing = found(self.OFFERS)
        self.left_out = missing_text(self.NAME, missing)
        if self.left_out:
            rospy.logwarn("stage: %s", self.left_out)

    def follow_team(self, scenario):
        """Open or withdraw topics and services, so that every robot behind this interface has its own."""
        rows = set(rows_of(self.world.team, self.DRIVE, self._absent))
        for row in list(self._open):
            for each in self._open.pop(row):
                close = getattr(each, "unregister", None) or each.shutdown
                close()
        self.goals = {}
        self.begin(sorted(rows))
        for row in sorted(rows):
            self._open[row] = self.open_robot(row)

    def begin(self, rows):
        """Begin anew with the robots ``rows``."""

    def open_robot(self, row):
        """Return the publishers, subscribers and services of robot ``row``."""
        raise NotImplementedError

    def command(self, rows, commands):
        """Give the world's robots ``rows`` (m,) the commands (m, a) that came by ``/robotN/cmd_vel``.

        These go on with nothing else any longer.
        """
        for row in rows:
            self.goals.pop(row, None)
        self.world.set_commands(rows, commands)

    def advance(self):
        """Do what is due before the world's next step."""
        self.mailbox.serve()
        for row, goal in list(self.goals.items()):
            if row < self.world.n:
                self.go_on(row, goal)

    def go_on(self, row, goal):
        """Let robot ``row`` go on with its ``goal``."""

    # Helps ---------------------------------------------------------------------------------------

    def subscribe(self, name, kind, to):
        """Return a subscriber of topic ``name`` whose messages reach ``to`` in the main loop."""
        return rospy.Subscriber(
            name, kind, self.mailbox.put, callback_args=to, queue_size=10, tcp_nodelay=True
        )

    def service(self, name, kind, act):
        """Return a service that calls ``act(request)`` in the main loop, and fails with what that says."""
        empty = kind._response_class

        def answer(request):
            done, said = self.requests.ask(lambda: act(request))
            if not done:
                raise rospy.ServiceException(said)
            return empty()

        return rospy.Service(name, kind, answer)

    def give(self, row, command):
        """Let robot ``row`` obey ``command`` (a,) along its drive's axes."""
        world = self.world
        whole = np.zeros((1, len(world.team.axes)))
        axes = world.team.kinds[row].axes
        whole[0, [world.team.axes.index(axis) for axis in axes]] = command
        world.set_commands([row], whole)

    def fits(self, row, *numbers):
        """Return whether ``numbers`` are finite; else count a refusal of robot ``row``."""
        fit = all(map(math.isfinite, numbers))
        if not fit:
            self.world.commands.refused[row] += 1
        return fit

    def states(self, rows):
        """Return the ``State`` of each of robots ``rows``, which fly."""
        world = self.world
        spatial, pose = world.spatial.of(rows), world.pose[rows]
        body = np.column_stack([world.twist[rows][:, :2], spatial.twist[:, 0]])
        velocity = rotated(spatial.orientation, body)
        place = np.column_stack([pose[:, :2], spatial.z])
        return [State(*each) for each in zip(place, velocity, pose[:, 2].tolist())]
