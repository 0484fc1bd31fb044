"""Hypothesis searches the same examples every time, so that a failure can be repeated."""

from hypothesis import settings

settings.register_profile("truths", deadline=None, derandomize=True, max_examples=40)
settings.load_profile("truths")
