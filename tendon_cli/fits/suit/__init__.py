"""A suit's numbers from logs of its own motor and joint."""
