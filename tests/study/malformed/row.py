"""What is known of a malformed study: its text, and what its error must say."""

from dataclasses import dataclass, field

from tendon_cli.errors import StudyError, TendonError


@dataclass(frozen=True)
class Malformed:
    """A study that is refused. `says` are fragments of the message, the key first; `line` that of the first fault."""

    label: str
    text: str | bytes
    says: tuple[str, ...]
    line: int | None = None
    kind: type[TendonError] = StudyError
    suffix: str = ".toml"
    stem: str = "study"
    settings: tuple[str, ...] = ()
    files: dict[str, str | bytes] = field(default_factory=dict)
    seconds: float = 5.0
    not_yet: str = ""
    """Why the error is not as it should be; empty where it is."""


def toml(label, text, *says, line=None, **more):
    return Malformed(label, text, says, line, **more)


def yaml(label, text, *says, line=None, **more):
    return Malformed(f"yaml {label}", text, says, line, suffix=".yaml", **more)


PYTHON_VALUE = "the message shows a value as Python writes it"
HUGE_INTEGER = "an integer of more than 4300 digits ends in an exception that is not a TendonError"
NO_PLACE = "the message names neither the key nor the line"
OVERFLOW = "a quantity too large for a float64 ends in an OverflowError"
DOTTED = "a table that is only opened by dotted keys has no line of its own"
SLOW = "the time grows with the square of the size"
