"""Who wears the suit: bodies drawn from a survey's statistics or read from a file, and the arms they have."""
