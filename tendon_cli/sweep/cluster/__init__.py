"""A sweep on a running Dask cluster."""
