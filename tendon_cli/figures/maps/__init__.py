"""Maps over two axes of a study."""
