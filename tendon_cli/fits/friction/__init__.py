"""A friction coefficient from the readings of two load cells."""

from tendon_cli.fits.friction.fit import fit_friction
from tendon_cli.fits.friction.fit_result import write_fragment, write_strokes

__all__ = ["fit_friction", "write_fragment", "write_strokes"]
