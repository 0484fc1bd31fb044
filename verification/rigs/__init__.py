"""Suits of elastic links that stick and slip, built from a description, to judge the model."""
