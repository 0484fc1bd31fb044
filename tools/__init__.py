"""Tools of those who work on tendon: tests under torture and random faults."""
