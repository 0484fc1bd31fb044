"""The version of tendon, and the version of its numbers."""

__version__ = "0.3.0"

RESULTS_VERSION = 6
"""Raised whenever the same study would give other tables, so that old and new results are never mixed."""
