"""Checks of a run: its limits, and what changed since another run."""
