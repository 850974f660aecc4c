"""What the GUI needs of a simulation and its controller, wherever they run; without Qt and ROS."""

import abc


class Connection(abc.ABC):
    """The GUI's back end.  No method blocks: timers of the GUI call them all.

    What is received is kept until the GUI takes it; what is requested is done in the background, and its
    answer is a result that ``take_results`` returns.  The attribute ``controller`` is an
    ``Interruptions`` with the times at which controllers were interrupted.  ``absent`` says by name why
    something is not to be had here: an action, a program, diagnostics, or the master.

    Questions about real robots and their time are answered by default as where there are none.
    """

    absent = {}

    # What is there -------------------------------------------------------------------------------

    @property
    @abc.abstractmethod
    def master_online(self):
        """Return whether simulations and controllers can be started and reached."""

    @property
    @abc.abstractmethod
    def registered(self):
        """Return the names, as in ``newest``, of what is published now, a frozenset."""

    @abc.abstractmethod
    def newest(self, name):
        """Return the newest that was received as ``name``, None before the first.

        stage: a ``Stage``; control: a ``Controller``; scenario: the stage's scenario, in YAML; emergency:
        whether the emergency stop is pressed; law_at: file, line and function of the law that keeps the
        controller waiting, where that is known.
        """

    @abc.abstractmethod
    def forget(self, name):
        """Drop what was received as ``name``: those of ``newest``, or state."""

    @abc.abstractmethod
    def silence(self, name):
        """Return the wall time [s] since ``name`` was received, None if it never was."""

    @abc.abstractmethod
    def is_fresh(self, name):
        """Return whether ``name`` was received a short wall time ago."""

    @abc.abstractmethod
    def snapshot(self):
        """Return the newest ``StateTable``, None before the first."""

    @abc.abstractmethod
    def sensor_readings(self):
        """Return ``{(number, name): ReceivedReading}`` of the sensors selected by ``watch_sensors``."""

    def diagnostics(self):
        """Return the ``Part``s of programs that report on themselves, while ``watch_diagnostics`` is on."""
        return []

    def odometry_topics(self):
        """Return ``{number: topic}`` of robots that publish odometry themselves."""
        return {}

    def first_stamp(self):
        """Return the stamp [s] of the first odometry of such robots."""
        return 0.0

    # What was received since the last call -------------------------------------------------------

    @abc.abstractmethod
    def take_samples(self):
        """Return the ``StateTable``s for the curves.

        Where a run begins there is the directory to which a program records it, None where none does.
        """

    @abc.abstractmethod
    def take(self, name):
        """Return the list of what was received as ``name``.

        collisions: ``recording.Collision``s; incidents: ``incidents.Incident``s; applied: what controllers
        applied, ``(stamp [s], {key: value})``; estimates: poses, ``(stamp [s], numbers, pose (n, 3))``.
        """

    @abc.abstractmethod
    def take_results(self):
        """Return the answers to requests, a list of ``(name, success, answer)``."""

    # Requests ------------------------------------------------------------------------------------

    @abc.abstractmethod
    def ask(self, name, *arguments):
        """Request ``name``: pause (on), step (steps), reset, set_speed (factor), start or stop."""

    @abc.abstractmethod
    def set_team(self, poses, kinds, altitude=None):
        """Request a new team; ``poses`` (n, 3), ``altitude`` (n,) [m] or None: on the ground."""

    def hold(self, number, place):
        """Request that robot ``number`` is held at ``place`` (x, y) [m], or pushed there; None: let it go.

        Raises ``NotImplementedError`` where ``absent`` has ``hold``.
        """
        raise NotImplementedError(self.absent["hold"])

    @abc.abstractmethod
    def set_topology(self, edges, directed):
        """Request another topology of the controller; ``edges``: ``(i, j, weight)``."""

    @abc.abstractmethod
    def set_parameters(self, values):
        """Request other parameters of the protocol, ``values`` by name."""

    @abc.abstractmethod
    def set_emergency(self, on):
        """Press or release the emergency stop of all controllers."""

    @abc.abstractmethod
    def pause_after(self, steps):
        """Request that a simulation pauses by itself so many ``steps`` after a run begins; 0: no longer.

        The answer is the result ``pause_after``.
        """

    @abc.abstractmethod
    def begin_run(self):
        """Count samples from now on as another run."""

    @abc.abstractmethod
    def begin_simulated_time(self):
        """Prepare time for a simulation; the result ``simulated_time`` has how it was before."""

    @abc.abstractmethod
    def restore_simulated_time(self, before):
        """Have time as it was ``before`` a simulation."""

    @abc.abstractmethod
    def do(self, name, function):
        """Run ``function``, which returns ``(success, answer)``; that is the result ``name``."""

    @abc.abstractmethod
    def watch_sensors(self, wanted):
        """Select the sensors ``wanted`` and no others, ``{(number, name): (Mount, Kind)}``."""

    @abc.abstractmethod
    def watch_diagnostics(self, wanted):
        """Receive diagnostics from now on, or no longer."""

    def finish_record(self, directory):
        """Have the run in ``directory`` recorded up to now; return ``{name: size [bytes]}`` of its files.

        Of files that are not written yet there are texts in place of sizes.  None where the program that
        records it does not answer.  Not in the GUI's thread.
        """
        return None

    @abc.abstractmethod
    def set_starts(self, poses, in_space=False):
        """Set the poses (n, 3) at zero odometry of robots that publish it themselves; None: the origin.

        ``in_space``: whether they leave the ground.
        """

    @abc.abstractmethod
    def close(self):
        """Finish pending requests, and disconnect, within a short wall time."""

    # The check of real robots --------------------------------------------------------------------

    def has_simulated_time(self):
        """Return whether programs take their time from a simulation; not in the GUI's thread."""
        return True

    def controller_arguments(self, topics):
        """Return the arguments that the check shares with the controller; not in the GUI's thread.

        ``topics``: as ``odometry_topics`` returns them.
        """
        return []
