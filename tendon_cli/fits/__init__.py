"""Fits: a friction coefficient from two load cells, a suit's numbers from its own log."""
