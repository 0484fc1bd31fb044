"""A task on a running Dask cluster."""
