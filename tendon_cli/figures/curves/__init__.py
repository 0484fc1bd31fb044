"""Quantities of states and designs as lines."""
