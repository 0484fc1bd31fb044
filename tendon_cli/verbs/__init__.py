"""Verbs of tendon: what each is and writes, its record, and the arguments of its function."""
