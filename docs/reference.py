"""The tables of reference in the pages, from the code itself: `python docs/reference.py` writes them anew.

They stand between `<!-- from the code: NAME -->` and `<!-- until here -->`; a test holds them to what is written here.
"""

from __future__ import annotations

import inspect
import re
import signal
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import typer

import tendon_cli
from tendon_cli import cli, errors, say
from tendon_cli.answers.fixes import PARAMETERS
from tendon_cli.model.limits import ADDED, LIMITS
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_STATES,
    OF_TRAJECTORIES,
    PLAUSIBLE,
    QUANTITIES,
)
from tendon_cli.space.axis import split_side
from tendon_cli.studies.study import Study, keys
from tendon_cli.units import UNITS

MARKED = re.compile(r"(<!-- from the code: ([\w -]+) -->\n).*?(<!-- until here -->)", re.DOTALL)
NEGATIVE = (
    "Finished, but states have no equilibrium, no choice has a window, `check` found a limit broken or a change, or a "
    "finding of the paper fails."
)
COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]  # a group has them


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [_row(heads), "|" + "---|" * len(heads), *(_row(row) for row in rows)]
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def key_table() -> str:
    """Every number of a study."""
    rows = []
    for path, key in keys().items():
        if split_side(path)[1] is None:
            number, quantity = key.number, key.number.quantity
            unit = "" if quantity.unit == "1" else f" {quantity.unit}"
            possible = f"{number.low:g} to {number.high:g}{unit}"
            low, high = PLAUSIBLE.get(number.name, (None, None))
            plausible = (
                ""
                if low is None
                else f"{say.quantity(quantity, low)} to {say.quantity(quantity, high)}"
            )
            column = f"`{key.column}`"
            rows.append(
                (
                    f"`{path}`",
                    quantity.symbol,
                    quantity.long_name,
                    _default(path),
                    plausible,
                    possible,
                    column,
                )
            )
    return table(("key", "symbol", "meaning", "default", "plausible", "possible", "column"), rows)


def _default(path: str) -> str:
    """What a key is without the study saying it."""
    values = Study().numbers.get(
        path, Study().motion.elbow_angle if path == "motion.elbow_angle" else None
    )
    if values is None:
        return "-"
    shown = [say.quantity(keys()[path].number.quantity, value) for value in values.array]
    return shown[0] if len(shown) == 1 else f"{shown[0]} to {shown[-1]}, {len(shown)} values"


def limit_table() -> str:
    """Every limit, with what it bounds and what a study must state for it."""
    rows = []
    for name, limit in LIMITS.items():
        quantity = QUANTITIES[name]
        needs = ", ".join(f"`{need.key}`" for need in limit.needs)
        rows.append((f"`limits.{name}`", quantity.symbol, quantity.long_name, quantity.unit, needs))
    return table(("limit", "symbol", "bounds", "unit", "needs"), rows)


def plausible_table() -> str:
    """Between which values a number may be changed to give a design a window."""
    rows = []
    for path, (low, high) in PARAMETERS.items():
        quantity = keys()[path].number.quantity
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        rows.append((f"`{path}`", quantity.symbol, f"{low:g} to {high:g}{unit}"))
    return table(("key", "symbol", "plausible"), rows)


def unit_table() -> str:
    """Every unit that a quantity may have."""
    by_dimension: dict[str, list[str]] = {}
    for unit in UNITS.values():
        by_dimension.setdefault(unit.dimension, []).append(f"`{unit.symbol}`")
    return table(
        ("dimension", "units"),
        ((name, ", ".join(symbols)) for name, symbols in by_dimension.items()),
    )


def column_table(columns: Iterable[str]) -> str:
    """Results of a table."""
    found = [QUANTITIES[column] for column in columns]
    rows = ((f"`{each.name}`", each.unit, each.symbol, each.long_name) for each in found)
    return table(("column", "unit", "symbol", "meaning"), rows)


def command_table() -> str:
    """Every command with its arguments and what it does."""
    rows = (
        (f"`tendon {_usage(command)}`", _sentence(command.help)) for command in COMMANDS.values()
    )
    return table(("command", "what it does"), rows)


def _usage(command: Any) -> str:
    arguments = [parameter for parameter in command.params if not _is_option(parameter)]
    words = [each.metavar if each.required else f"[{each.metavar}]" for each in arguments]
    return " ".join([command.name, *words]).replace("|", "\\|")


def _is_option(parameter: Any) -> bool:
    return bool(parameter.opts[0].startswith("-"))


def option_table(name: str) -> str:
    """Every option of a command."""
    rows = []
    for option in filter(_is_option, COMMANDS[name].params):
        value = "" if option.is_flag or not option.metavar else f" {option.metavar}"
        flags = [
            f"`{flag}{value}`".replace("|", "\\|")
            for flag in (*option.opts, *option.secondary_opts)
        ]
        plain = isinstance(option.default, str | int | float | Path) and not isinstance(
            option.default, bool
        )
        rows.append(
            (
                ", ".join(flags),
                _escaped(option.help) + (f"; default {option.default}" if plain else ""),
            )
        )
    return table(("option", "meaning"), rows)


def _escaped(text: str) -> str:
    return re.sub(r"([|<*])", r"\\\1", text)


def exit_table() -> str:
    """Every exit code with the kinds of error that have it."""
    rows = {
        0: "everything computed, written and verified",
        1: f"`{errors.TendonError.kind}`: a fault of tendon itself",
    }
    rows[errors.EXIT_NEGATIVE] = f"a negative result: {_sentence(NEGATIVE)}"
    for kind in errors.TendonError.__subclasses__():
        if kind is not errors.InterruptError:
            said = f"`{kind.kind}`: {_sentence(kind.__doc__).partition('; ')[0]}"
            rows[kind.exit] = f"{rows[kind.exit]}; {said}" if kind.exit in rows else said
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        rows[128 + number] = f"`{errors.InterruptError.kind}`: by {number.name}, cleanly"
    return table(("exit", "meaning"), ((f"{code}", rows[code]) for code in sorted(rows)))


def _sentence(text: str | None) -> str:
    """The first sentence, beginning small, without its full stop."""
    first = " ".join((text or "").split("\n\n")[0].split())
    return (first if first[:3].isupper() else first[:1].lower() + first[1:]).removesuffix(".")


def face_table() -> str:
    """Every function of the library."""
    rows = []
    for name in tendon_cli.__all__:
        function = getattr(tendon_cli, name)
        if inspect.isfunction(function):
            rows.append(
                (f"`{name}{_plain(inspect.signature(function))}`", _sentence(function.__doc__))
            )
    return table(("function", "what it gives"), rows)


def _plain(signature: inspect.Signature) -> str:
    """A signature without types, and without functions by name."""
    bare = [
        each.replace(annotation=inspect.Parameter.empty) for each in signature.parameters.values()
    ]
    return re.sub(r"<function .*? at \w+>", "...", str(inspect.Signature(bare)))


TABLES: dict[str, Callable[..., str]] = {
    "commands": command_table,
    "options": option_table,
    "exits": exit_table,
    "face": face_table,
    "keys": key_table,
    "limits": limit_table,
    "units": unit_table,
    "plausible": plausible_table,
    "states": lambda: column_table(OF_STATES),
    "designs": lambda: column_table(OF_DESIGNS),
    "cycles": lambda: column_table(OF_CYCLES),
    "trajectories": lambda: column_table(OF_TRAJECTORIES),
    "optional": lambda: column_table(limit.column for limit in ADDED),
}


def renewed(page: str) -> str:
    """A page with its tables as the code has them now."""

    def anew(match: re.Match[str]) -> str:
        name, *about = match[2].split()
        return f"{match[1]}{TABLES[name](*about)}\n{match[3]}"

    return MARKED.sub(anew, page)


if __name__ == "__main__":
    for page in Path(__file__).parent.glob("*.md"):
        page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")
