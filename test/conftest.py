"""Fixtures that all tests share."""

from gui_fixtures import gui, no_hidden_errors  # noqa: F401
from ros_fixtures import ros  # noqa: F401
