"""People who wear the suit: bodies drawn from a survey or read from a file, and their arms."""
