"""Base of the types of sensors without settings."""


class Plain:
    """A sensor without settings of its own."""

    @staticmethod
    def settings(section):
        """Return no settings."""
        return ()

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        self._rows = rows
