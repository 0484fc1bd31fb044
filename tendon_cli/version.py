"""Version of tendon, and version of its numbers."""

__version__ = "0.4.0"

RESULTS_VERSION = 13
"""Version of the numbers, raised whenever the same study would give other tables.

Results of different versions are never mixed.
"""
_WRITTEN_BY = {4: "0.1.0", 5: "0.2.0", 6: "0.3.0"}
"""Releases of tendon by the last results version that they wrote."""


def reader_of(results_version: object) -> str:
    """Return the tendon that reads results of another version: "tendon 0.3.0"."""
    for version, release in _WRITTEN_BY.items():
        if isinstance(results_version, int) and results_version <= version:
            return f"tendon {release}"
    is_older = isinstance(results_version, int) and results_version < RESULTS_VERSION
    return "an earlier tendon" if is_older else "a later tendon"
