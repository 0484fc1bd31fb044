"""Tables as the text of CSV files, for studies that name them."""

import numpy as np


def csv_text(header, *columns, separator=","):
    """Return columns of numbers as the text of a CSV file under a header."""
    rows = np.column_stack(columns).tolist()
    lines = [separator.join(map(repr, row)) for row in rows]
    return "\n".join([header, *lines]) + "\n"
