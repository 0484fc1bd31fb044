"""Tables of numbers that users bring, read in one place for every feature."""
