"""Random small faults in the package, to see whether the tests notice: `make mutants`."""
