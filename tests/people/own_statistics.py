"""Statistics of one's own, as a study may name them, in text."""

import numpy as np

from tendon_cli.model.body import DIMENSIONS

SIZE = len(DIMENSIONS)
MEAN = [1000.0, 80.0, *[330.0] * (SIZE - 2)]


def written(correlation=None, **male):
    """Return a survey as text, of persons 1 m large, with some keys of its men replaced."""
    uncorrelated = np.eye(SIZE).tolist()
    men = {"persons": 10, "mean": MEAN, "standard_deviation": [1.0] * SIZE} | male
    lines = [
        f"dimensions = {list(DIMENSIONS)}",
        "[male]",
        *(f"{key} = {value}" for key, value in men.items()),
        f"correlation = {correlation or uncorrelated}",
        "[female]",
        "persons = 5",
        f"mean = {MEAN}",
        f"standard_deviation = {[2.0] * SIZE}",
        f"correlation = {uncorrelated}",
    ]
    return "\n".join(lines)
