"""What the types of sensors have in common."""


class Sensor:
    """A type of sensor, which files know as ``TYPE``; it is made for robots with equal mounts."""

    TYPE = ""
    QUANTITIES = {}  # SI unit of each quantity whose noise can be given; "" names the only one
    COLUMNS = {}  # how many numbers are recorded by each name: none of pictures
    RATE = 10.0  # [Hz] where a mount says nothing else
    NOISE = {}  # by quantity, where a mount says nothing else
    MODELS = {}  # settings by name, which a mount takes with ``model``
    LOOKS_BACK = False  # whether ``read`` takes the ``State`` one step before as well
    ALWAYS_READ = False  # whether it is read at all its samples, active or not
    SEES_ROBOTS = False  # whether its values have a column for each robot of the team
    LISTS = ""  # column of the ``numbers`` of a reading that is a row for each
    DIGITS = 15  # [-] of a recorded value: 9 for those of float32
    VARIES = False  # whether recorded samples differ in length: they are estimated from some

    @staticmethod
    def settings(section):
        """Return the type's own settings, hashable, from a mount's ``section``: none."""
        return ()

    @staticmethod
    def check(kind, where):
        """Raise ``ScenarioError`` where robots of ``kind`` cannot have the sensor."""

    @classmethod
    def columns(cls, settings, kind):
        """Return how many numbers are recorded by each name, of a robot of ``kind``: ``COLUMNS``."""
        return cls.COLUMNS

    @staticmethod
    def most(settings, n):
        """Return how many rows a reading of one of ``n`` robots has at most."""
        return 1

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        self._settings, self._rows = mount.settings, rows

    def begin(self):
        """Reset what is remembered, as a run begins."""

    def read(self, state, environment, rng):
        """Return the reading of all robots in ``rows``: a NamedTuple whose first field is ``stamp`` [s].

        ``state``: a ``State``; ``environment``: a ``Scenery``; ``rng``: the ``noise.Draws`` of the sample.
        """
        raise NotImplementedError
