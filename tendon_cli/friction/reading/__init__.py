"""Files of two load cells, made into readings."""
