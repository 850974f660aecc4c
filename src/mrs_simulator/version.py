"""The version of mrs_simulator, the same as in package.xml."""

__version__ = "1.0.0"
