"""One HTML page of a run, with everything in it: no network, no evaluated text, no other file."""
