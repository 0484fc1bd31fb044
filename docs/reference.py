"""Pages of reference from the code itself: commands and options, keys, columns, units, exit codes.

Run by Sphinx before it reads the pages; `python docs/reference.py FOLDER` writes them anywhere.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import typer

import tendon_cli as tendon
from tendon_cli import cli, errors
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
from tendon_cli.study.study import keys, split_side
from tendon_cli.units import UNITS


def write_reference(folder: Path) -> None:
    """Write all pages into a folder, those that stand there and are the same left alone."""
    folder.mkdir(exist_ok=True)
    for name, text in pages().items():
        file = folder / f"{name}.md"
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def pages() -> dict[str, str]:
    """Every page by its name."""
    return {
        "commands": commands_page(),
        "keys": keys_page(),
        "columns": columns_page(),
        "units": units_page(),
        "exits": exits_page(),
        "library": library_page(),
    }


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [_row(heads), _row(["---"] * len(heads)), *(_row(row) for row in rows)]
    return "\n".join(lines) + "\n"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def commands_page() -> str:
    """Every command with its arguments and options, as `--help` tells them."""
    group = typer.main.get_command(cli.app)
    parts = ["# Commands\n\nAs `tendon COMMAND --help` prints them.\n"]
    for name, command in sorted(group.commands.items()):
        arguments = [each for each in command.params if each.param_type_name == "argument"]
        shown = " ".join(str(each.metavar or each.name.upper()) for each in arguments)
        parts.append(
            f"## `{' '.join(filter(None, ('tendon', name, shown)))}`\n\n{inspect.cleandoc(command.help or '')}\n"
        )
        rows = [
            (f"`{', '.join(each.opts)}{_value(each)}`", str(each.help or ""))
            for each in command.params
            if each.param_type_name == "option" and "--help" not in each.opts
        ]
        parts.append(table(("option", "meaning"), rows) if rows else "")
    return "\n".join(parts)


def _value(option: object) -> str:
    if getattr(option, "is_flag", False):
        return ""
    return f" {getattr(option, 'metavar', None) or getattr(option, 'name', '').upper()}"


def keys_page() -> str:
    """Every number of a study: its key, its column, its unit, its meaning."""
    rows = []
    for path, key in keys().items():
        if split_side(path)[1] is None:
            quantity = key.number.quantity
            rows.append((f"`{path}`", f"`{key.column}`", quantity.unit, quantity.symbol, quantity.long_name))
    text = "# Keys of a study\n\nEvery number of a study, and its column. `tendon schema` has the whole file.\n\n"
    return text + table(("key", "column", "SI unit", "symbol", "meaning"), rows)


def columns_page() -> str:
    """Every result of both tables."""
    text = "# Columns of the tables\n\nResults; the columns of what a study varies are in [](keys.md).\n"
    for name, columns in (("states", OF_STATES), ("designs", OF_DESIGNS), ("designs, with a speed", OF_CYCLES)):
        rows = [(f"`{column}`", *_meaning(column)) for column in columns]
        text += f"\n## {name}\n\n" + table(("column", "unit", "symbol", "meaning"), rows)
    return text


def _meaning(column: str) -> tuple[str, str, str]:
    quantity = QUANTITIES[column]
    return quantity.unit, quantity.symbol, quantity.long_name


def units_page() -> str:
    """Every unit that a quantity may have."""
    by_dimension: dict[str, list[str]] = {}
    for unit in UNITS.values():
        by_dimension.setdefault(unit.dimension, []).append(f"`{unit.symbol}`")
    rows = [(dimension, ", ".join(symbols)) for dimension, symbols in by_dimension.items()]
    return "# Units\n\nA quantity is one number and one of these, in quotes.\n\n" + table(("dimension", "units"), rows)


def exits_page() -> str:
    """What each exit code means, from the errors themselves."""
    kinds = [
        kind
        for kind in vars(errors).values()
        if isinstance(kind, type) and issubclass(kind, errors.TendonError) and kind is not errors.TendonError
    ]
    rows = [("0", "", "everything computed, written and verified"), ("1", "bug", "a bug in tendon")]
    rows += sorted((str(kind.exit), kind.kind, inspect.getdoc(kind) or "") for kind in kinds)
    return "# Exit codes\n\n" + table(("exit", "kind", "meaning"), rows)


def library_page() -> str:
    """The functions of the library, with their signatures and documentation."""
    names = [name for name in tendon.__all__ if not name.startswith("_")]
    parts = [f"```{{eval-rst}}\n.. autofunction:: tendon_cli.{name}\n```\n" for name in names]
    return "# The library\n\n`import tendon_cli as tendon`; [](../python.md) tells how it is used.\n\n" + "\n".join(
        parts
    )


if __name__ == "__main__":
    write_reference(Path(sys.argv[1]))
