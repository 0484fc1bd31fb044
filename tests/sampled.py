"""Cases of which `make test` tries a few, and `make torture` all."""

import pytest


def quick_and_torture(quick, torture):
    """Return the values of a test, of which the second are left to `make torture`."""
    rows = [value if isinstance(value, tuple) else (value,) for value in torture]
    return [*quick, *(pytest.param(*values, marks=pytest.mark.torture) for values in rows)]
