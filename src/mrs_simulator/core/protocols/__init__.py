"""Coordination laws as pure functions of arrays: points (n, 2) in, velocities (n, 2) out."""
