"""Figures, drawn from tables and never from the model."""
