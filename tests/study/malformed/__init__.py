"""Studies that cannot be used, of every kind, with what their one error says."""

from .designs import DESIGNS
from .files import ATTACHMENTS, FILES
from .numbers_and_grids import ANGLES, GRIDS, NUMBERS, UNCERTAIN
from .row import Malformed
from .settings import SETTINGS
from .syntax import LIMITS, TOML_SYNTAX, YAML_SYNTAX
from .tables import CASES, TABLES, WORDS

ROWS = (
    *NUMBERS,
    *GRIDS,
    *ANGLES,
    *UNCERTAIN,
    *TABLES,
    *WORDS,
    *CASES,
    *TOML_SYNTAX,
    *YAML_SYNTAX,
    *LIMITS,
    *DESIGNS,
    *FILES,
    *ATTACHMENTS,
    *SETTINGS,
)

__all__ = ["ROWS", "Malformed"]
