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


def toml(label, text, *says, line=None, **more):
    return Malformed(label, text, says, line, **more)


def yaml(label, text, *says, line=None, **more):
    return Malformed(f"yaml {label}", text, says, line, suffix=".yaml", **more)
