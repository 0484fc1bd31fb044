"""Ratios measured in one run: tendon against the machine's own limit, and against other scripts."""
