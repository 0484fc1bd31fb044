"""tendon: parameter studies of tendon-driven exosuits that move the elbow with one motor and two tendons.

The library's face, usually imported as `import tendon_cli as tendon`; the commands call it, too. Whatever is wrong is
raised as a `TendonError`, whose `exit` is the exit code of the commands. Importing it loads no other module.
"""

# No import but of tendon's own: `python -m tendon_cli` would take it from the working directory.
from tendon_cli.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tendon_cli import arms
    from tendon_cli.errors import (
        FolderError,
        InputError,
        InterruptError,
        MemoryShortError,
        OutputError,
        SizeError,
        StudyError,
        TendonError,
        UsageError,
        WorkersLostError,
    )
    from tendon_cli.face.pictures import plot
    from tendon_cli.face.runs import check, design, estimate, open, open_run, report, sweep  # noqa: A004
    from tendon_cli.face.studies import fit_friction, load_study, state, states, study

__all__ = [
    "FolderError", "InputError", "InterruptError", "MemoryShortError", "OutputError", "SizeError", "StudyError",
    "TendonError", "UsageError", "WorkersLostError", "__version__", "arms", "check", "design", "estimate",
    "fit_friction", "load_study", "open", "open_run", "plot", "report", "state", "states", "study", "sweep",
]  # fmt: skip

_PLACES = {
    **dict.fromkeys(
        ("load_study", "study", "varied", "state", "states", "fit_friction", "record_of", "text_of"), "face.studies"
    ),
    **dict.fromkeys(("sweep", "design", "estimate", "open", "open_run", "check", "report"), "face.runs"),
    **dict.fromkeys(("plot", "picture"), "face.pictures"),
    **dict.fromkeys((name for name in __all__ if name.endswith("Error")), "errors"),
}
"""By its name, the module in which something of the face stands."""


def __getattr__(name: str) -> "Any":
    """Whatever the face has, read when it is wanted."""
    if name not in _PLACES and name != "arms":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found = import_module(f"{__name__}.arms") if name == "arms" else None
    return found or globals().setdefault(name, getattr(import_module(f"{__name__}.{_PLACES[name]}"), name))


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
