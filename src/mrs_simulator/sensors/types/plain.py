"""What types of sensors have in common."""


class Plain:
    """A sensor without settings of its own, which remembers whose it is."""

    @staticmethod
    def settings(section):
        """Return no numbers."""
        return ()

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        self._rows = rows
