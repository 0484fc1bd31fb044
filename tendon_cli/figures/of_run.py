"""The figures of a finished run: slack maps where its axes allow, and those that the study declares."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tendon_cli.errors import InputError, TendonError
from tendon_cli.study.study import Study


def draw_run(study: Study, folder: Path, record: dict[str, Any]) -> tuple[list[str], list[str], str | None]:
    """Draw into a run folder whose tables stand; returns the files, what could not be drawn, and why there is no map.

    A figure never costs a run: what goes wrong is told, not raised. Only a damaged table is no run; raises InputError.
    """
    files: list[Path] = []
    faults: list[str] = []
    reason = None
    if "designs" in study.output.tables and record["designs"] > 1:
        try:
            maps, reason = _maps(folder)
            files += maps
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001
            faults.append(f"the slack map cannot be drawn: {_words(error)}")
    for figure in study.figure:
        try:
            from tendon_cli.figures.declared import draw_declared

            files += draw_declared(study.model_copy(update={"figure": (figure,)}), folder)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001
            faults.append(f'figure "{figure.name}" cannot be drawn: {_words(error)}')
    return [file.name for file in files], faults, None if study.figure else reason


def _maps(folder: Path) -> tuple[list[Path], str | None]:
    from tendon_cli.figures.slack_map import draw_slack_maps
    from tendon_cli.tables.read import open_table

    maps = draw_slack_maps(open_table(folder / "designs.parquet"), folder)
    return list(maps.files), maps.reason


def _words(error: Exception) -> str:
    """What happened, as one line."""
    if isinstance(error, TendonError):
        place = f"{error.where}: " if error.where else ""
        return f"{place}{error.message}" + (f" ({error.hint})" if error.hint else "")
    return f"{type(error).__name__}: {error}"
