"""Version of tendon, and version of its numbers."""

__version__ = "0.3.0"

RESULTS_VERSION = 6
"""Version of the numbers, raised whenever the same study would give other tables.

Results of different versions are never mixed.
"""
