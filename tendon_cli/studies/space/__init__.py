"""Named axes, their product, and each number of its designs. Knows nothing of study files."""
