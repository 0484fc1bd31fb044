"""Answers to design questions: the best pretension and choice, what binds, what would fix it."""
