"""Answers for the next tool: a model for MuJoCo, a table for a controller, a list of numbers."""
