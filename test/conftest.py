"""Fixtures that all tests share."""

from ros_fixtures import ros  # noqa: F401
