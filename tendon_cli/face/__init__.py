"""The functions of the library that stand above all rooms."""
