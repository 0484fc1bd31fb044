"""A friction coefficient from the readings of two load cells."""
