"""The geometry of a study: arm, spools, and the routes of its sheaths."""
