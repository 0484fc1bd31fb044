"""Readings of two load cells, from files or from memory."""
