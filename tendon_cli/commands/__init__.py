"""A module a command: options in, one call of the library's face, text or JSON out."""
