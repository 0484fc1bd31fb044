"""tendon: parameter studies of tendon-driven exosuits that move the elbow with one motor and two tendons."""

from tendon_cli.version import __version__

__all__ = ["__version__"]
