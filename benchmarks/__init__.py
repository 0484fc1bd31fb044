"""Ratios measured in one run: against the machine's own limit, and against what a user would write instead."""
