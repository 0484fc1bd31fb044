"""Studies that cannot be used, of every kind, with what their one error says."""

from . import designs, files, numbers_and_grids, syntax, tables
from .row import Malformed

MODULES = (numbers_and_grids, tables, syntax, designs, files)


def _malformed_of(module):
    """Yield every malformed study of a module's tuples, in their order."""
    for value in vars(module).values():
        if isinstance(value, tuple):
            yield from (item for item in value if isinstance(item, Malformed))


ROWS = tuple(row for module in MODULES for row in _malformed_of(module))
