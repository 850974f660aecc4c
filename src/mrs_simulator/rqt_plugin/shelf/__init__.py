"""Runs that are kept, listed, opened and compared."""
