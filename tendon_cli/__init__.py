"""tendon: parameter studies of exosuits that move the elbow with one motor and two tendons.

The public functions of the library, usually imported as `import tendon_cli as tendon`; the commands
call them, too. Whatever is wrong is raised as a `TendonError`, whose `exit` is the exit code of the
commands. Importing the package loads no other module.
"""

# No import from elsewhere: `python -m tendon_cli` would take it from the working directory.
from tendon_cli.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tendon_cli.checks.check import check
    from tendon_cli.checks.compare import compare_results as compare
    from tendon_cli.engine.states import states
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
    from tendon_cli.face import design, estimate, open, plot, sweep  # noqa: A004
    from tendon_cli.fits.friction.fit import fit_friction
    from tendon_cli.fits.suit.suit_fitting import fit_suit
    from tendon_cli.reports.report import write_report as report
    from tendon_cli.state_page.page import state_page as state
    from tendon_cli.studies import arms
    from tendon_cli.studies.load import any_study as study

_MODULE_OF = {
    "study": "studies.load.any_study",
    "state": "state_page.page.state_page",
    "states": "engine.states.states",
    "sweep": "face.sweep",
    "design": "face.design",
    "estimate": "face.estimate",
    "open": "face.open",
    "check": "checks.check.check",
    "compare": "checks.compare.compare_results",
    "report": "reports.report.write_report",
    "fit_friction": "fits.friction.fit.fit_friction",
    "fit_suit": "fits.suit.suit_fitting.fit_suit",
    "plot": "face.plot",
}
"""Module and attribute behind each public name, loaded when the name is first used."""
_GONE = {"load_study": "study", "open_run": "open"}
"""Names of earlier versions, each with the one to use instead."""
__all__ = [
    "FolderError",
    "InputError",
    "InterruptError",
    "MemoryShortError",
    "OutputError",
    "SizeError",
    "StudyError",
    "TendonError",
    "UsageError",
    "WorkersLostError",
    "__version__",
    "arms",
    "check",
    "compare",
    "design",
    "estimate",
    "fit_friction",
    "fit_suit",
    "open",
    "plot",
    "report",
    "state",
    "states",
    "study",
    "sweep",
]


def __getattr__(name: str) -> "Any":
    """Load a public name when it is first used."""
    if name in _GONE:
        raise AttributeError(f"tendon.{name} is gone, use tendon.{_GONE[name]}")
    if name not in _MODULE_OF and name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    if name == "arms":
        return import_module(f"{__name__}.studies.arms")
    module_name, _, attribute = _MODULE_OF.get(name, f"errors.{name}").rpartition(".")
    found = getattr(import_module(f"{__name__}.{module_name}"), attribute)
    if name in _MODULE_OF:
        found = import_module(f"{__name__}.verbs.call_options").public(found, name)
    return globals().setdefault(name, found)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
