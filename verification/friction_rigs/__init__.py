"""Simulated rigs of two load cells, to judge fits of friction: `make friction`."""
