"""Is every design of a run within its limits, and what changed since another run."""
