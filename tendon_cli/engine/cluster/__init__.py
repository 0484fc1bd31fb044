"""Carrying a task out on a running Dask cluster."""
