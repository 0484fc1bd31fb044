"""Studies that cannot be used, of every kind, with what their one error says."""

from . import designs, files, numbers_and_grids, syntax, tables
from .row import Malformed

ROWS = tuple(
    row
    for module in (numbers_and_grids, tables, syntax, designs, files)
    for rows in vars(module).values()
    if isinstance(rows, tuple)
    for row in rows
    if isinstance(row, Malformed)
)
