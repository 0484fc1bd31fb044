"""Cases of which `make test` tries a few and `make torture` all, and cases of one test."""

import pytest


def quick_and_torture(quick, torture):
    """Return the values of a test, of which the second are left to `make torture`."""
    rows = [value if isinstance(value, tuple) else (value,) for value in torture]
    return [*quick, *(pytest.param(*values, marks=pytest.mark.torture) for values in rows)]


def check_all(check, rows):
    """Call a check with each row. Fail with all rows of which an assertion does not hold."""
    faults = []
    for row in rows:
        try:
            check(*row)
        except AssertionError as fault:
            faults.append(f"{row}: {fault}")
    assert not faults, "\n\n".join(faults)
