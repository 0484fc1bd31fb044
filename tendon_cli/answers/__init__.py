"""Answers to design questions: which pretension, which choice, what binds, and what would fix it."""
