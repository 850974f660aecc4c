"""Searching among many runs: the one that breaks a requirement, and how sure one may be of none."""
