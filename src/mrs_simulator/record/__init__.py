"""Runs recorded in files and in memory."""

MOST_KEPT = 1 << 29  # [bytes] of numbers in memory; more are in a file that is mapped
