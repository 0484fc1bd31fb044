"""Write the tables of reference into the pages, from the code itself: `python docs/reference.py`.

They stand between `<!-- from the code: NAME -->` and `<!-- until here -->`; a test compares them
with the tables that are written here.
"""

from __future__ import annotations

import inspect
import re
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import typer

import tendon_cli
from tendon_cli import cli, errors, say
from tendon_cli.answers.remedies import PARAMETERS
from tendon_cli.model.limits import ADDED, LIMITS
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_STATES,
    OF_TRAJECTORIES,
    QUANTITIES,
    Quantity,
)
from tendon_cli.space.axis import limit_of, split_side
from tendon_cli.studies.study import Study, keys
from tendon_cli.units import UNITS

MARKED = re.compile(r"(<!-- from the code: ([\w -]+) -->\n).*?(<!-- until here -->)", re.DOTALL)
NEGATIVE = (
    "Finished, but states have no equilibrium, no choice has a window, or `check` found a limit "
    "broken or a change."
)
MOST_WORDS = 9
"""Largest number of words that the table of keys lists for one of them."""
_HEADS_OF_KEYS = ("key", "meaning", "one of", "default")
COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]  # of a group


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [_row(heads), "|" + "---|" * len(heads), *(_row(row) for row in rows)]
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def key_table() -> str:
    """Return the table of all numbers of a study."""
    rows = []
    for path, key in keys().items():
        if split_side(path)[1] is not None or limit_of(path) is not None:
            continue  # limits have a table of their own
        number = key.number
        quantity = number.quantity
        rows.append(
            (
                f"`{path}`",
                quantity.symbol,
                quantity.long_name,
                _default(path),
                plausible,
                f"{number.low:g} to {number.high:g}{_unit_after_number(quantity)}",
                f"`{key.column}`",
            )
        )
    return table(("key", "symbol", "meaning", "default", "plausible", "possible", "column"), rows)


def _unit_after_number(quantity: Quantity) -> str:
    """Return the SI unit of a quantity, after a space; empty for a number without a unit."""
    return "" if quantity.unit == "1" else f" {quantity.unit}"


def _default(path: str) -> str:
    """Return the value of a key that a study does not give."""
    study = Study()
    values = study.numbers.get(path)
    if path == "motion.elbow_angle":
        values = study.motion.elbow_angle
    if values is None:
        return "-"
    shown = [say.quantity(keys()[path].quantity, value) for value in values.array]
    return shown[0] if len(shown) == 1 else f"{shown[0]} to {shown[-1]}, {len(shown)} values"


def other_key_table() -> str:
    """Return the table of all keys of a study that are no numbers of a design, and no limits."""
    return table(_HEADS_OF_KEYS, _other_keys(Study.model_json_schema(), ""))


def keys_of_each(section: str) -> str:
    """Return the table of the keys of one `[[section]]`, of which a study may have several."""
    schema = Study.model_json_schema()
    name = schema["properties"][section]["items"]["$ref"].rpartition("/")[2]
    nodes = schema["$defs"][name]["properties"]
    rows = (_row_of_key(key, node, _alternatives(node, schema)) for key, node in nodes.items())
    return table(_HEADS_OF_KEYS, rows)


def _other_keys(schema: dict[str, Any], prefix: str, section: Any = None) -> Iterator[list[str]]:
    """Yield the rows of all keys in a section of the schema and in those below it.

    Args:
        schema: The whole schema.
        prefix: Path of the section, with a dot at its end; empty for the whole study.
        section: The node of the section; the whole schema if it is not given.
    """
    for name, node in (section or schema)["properties"].items():
        path = f"{prefix}{name}"
        is_side = split_side(f"{path}.")[1] is not None
        alternatives = _alternatives(node, schema)
        sections = [each for each in alternatives if "properties" in each]
        is_list_of_sections = bool(sections) and "items" in node
        if path in keys() or is_side or limit_of(path) is not None or is_list_of_sections:
            continue  # numbers, limits and lists of sections have tables of their own
        if sections and not any(each.get("type") == "string" for each in alternatives):
            yield from _other_keys(schema, f"{path}.", sections[0])
        else:
            yield _row_of_key(path, node, alternatives)


def _alternatives(node: dict[str, Any], schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a node, and all nodes that it refers to or offers instead of itself."""
    found = [node]
    if "$ref" in node:
        found += _alternatives(schema["$defs"][node["$ref"].rpartition("/")[2]], schema)
    for each in node.get("anyOf", ()):
        found += _alternatives(each, schema)
    if isinstance(node.get("items"), dict):
        found += _alternatives(node["items"], schema)
    return found


def _row_of_key(path: str, node: dict[str, Any], alternatives: list[dict[str, Any]]) -> list[str]:
    """Return the row of a key: itself, its meaning, the words that it may be, its default."""
    words: list[Any] = []
    for each in alternatives:
        words += each.get("enum", [each["const"]] if "const" in each else [])
    unique = list(dict.fromkeys(word for word in words if isinstance(word, str)))
    choices = ", ".join(f'`"{word}"`' for word in unique) if len(unique) <= MOST_WORDS else ""
    meaning = next((each["description"] for each in alternatives if "description" in each), "")
    meaning = meaning.removeprefix("share: ")
    meaning = re.sub(r" (A bare number is in|An angle has) .*", "", meaning)
    default = node.get("default")
    if path == "name" or default in (None, "", []):
        shown = "-"
    elif isinstance(default, list):
        shown = ", ".join(f'`"{word}"`' for word in default)
    elif isinstance(default, str):
        shown = f'`"{default}"`'
    else:
        shown = f"{default}".lower() if isinstance(default, bool) else f"{default:,}"
    return [f"`{path}`", _escaped(meaning.removesuffix(".")), choices, shown]


def limit_table() -> str:
    """Return the table of all limits, with what each bounds and what it needs."""
    rows = []
    for name, limit in LIMITS.items():
        quantity = QUANTITIES[name]
        needs = ", ".join(f"`{need.key}`" for need in limit.needs)
        rows.append((f"`limits.{name}`", quantity.symbol, quantity.long_name, quantity.unit, needs))
    return table(("limit", "symbol", "bounds", "unit", "needs"), rows)


def plausible_table() -> str:
    """Return the table of ranges in which a number may be changed to give a design a window."""
    rows = []
    for path, (low, high) in PARAMETERS.items():
        quantity = keys()[path].quantity
        values = f"{say.quantity(quantity, low)} to {say.quantity(quantity, high)}"
        rows.append((f"`{path}`", quantity.symbol, values))
    return table(("key", "symbol", "plausible"), rows)


def unit_table() -> str:
    """Return the table of all units, by dimension."""
    by_dimension: dict[str, list[str]] = {}
    for unit in UNITS.values():
        by_dimension.setdefault(unit.dimension, []).append(f"`{unit.symbol}`")
    rows = ((dimension, ", ".join(symbols)) for dimension, symbols in by_dimension.items())
    return table(("dimension", "units"), rows)


def column_table(columns: Iterable[str]) -> str:
    """Return the table of some columns of results."""
    rows = []
    for column in columns:
        quantity = QUANTITIES[column]
        rows.append((f"`{quantity.name}`", quantity.unit, quantity.symbol, quantity.long_name))
    return table(("column", "unit", "symbol", "meaning"), rows)


def command_table() -> str:
    """Return the table of all commands, with their arguments and what they do."""
    rows = (
        (f"`tendon {_usage(command)}`", _sentence(command.help)) for command in COMMANDS.values()
    )
    return table(("command", "what it does"), rows)


def _usage(command: Any) -> str:
    """Return the name of a command with its arguments, as a cell of a table."""
    arguments = [parameter for parameter in command.params if not _is_option(parameter)]
    words = [each.metavar if each.required else f"[{each.metavar}]" for each in arguments]
    return " ".join([command.name, *words]).replace("|", "\\|")


def _is_option(parameter: Any) -> bool:
    return bool(parameter.opts[0].startswith("-"))


def option_table(name: str) -> str:
    """Return the table of all options of a command."""
    rows = []
    for option in filter(_is_option, COMMANDS[name].params):
        value = "" if option.is_flag or not option.metavar else f" {option.metavar}"
        flags = [f"`{flag}{value}`" for flag in (*option.opts, *option.secondary_opts)]
        meaning = _escaped(option.help)
        has_default = isinstance(option.default, str | int | float | Path)
        if has_default and not isinstance(option.default, bool):
            meaning += f"; default {option.default}"
        rows.append((", ".join(flags).replace("|", "\\|"), meaning))
    return table(("option", "meaning"), rows)


def _escaped(text: str) -> str:
    """Escape the signs of Markdown in a text of a cell."""
    return re.sub(r"([|<*])", r"\\\1", text)


def exit_table() -> str:
    """Return the table of all exit codes, with the kinds of error that have them."""
    rows = {
        0: "everything computed, written and verified",
        1: f"`{errors.TendonError.kind}`: a fault of tendon itself",
        errors.EXIT_NEGATIVE: f"a negative result: {_sentence(NEGATIVE)}",
    }
    for kind in errors.TendonError.__subclasses__():
        if kind is errors.InterruptError:
            continue
        meaning = f"`{kind.kind}`: {_sentence(kind.__doc__).partition('; ')[0]}"
        rows[kind.exit] = f"{rows[kind.exit]}; {meaning}" if kind.exit in rows else meaning
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        rows[128 + number] = f"`{errors.InterruptError.kind}`: by {number.name}, cleanly"
    return table(("exit", "meaning"), ((f"{code}", rows[code]) for code in sorted(rows)))


def error_table() -> str:
    """Return the table of all errors that the library raises on purpose."""
    rows = []
    for error in errors.TendonError.__subclasses__():
        code = "128 + signal" if error is errors.InterruptError else f"{error.exit}"
        rows.append((f"`{error.__name__}`", code, _sentence(error.__doc__)))
    return table(("error", "exit", "when"), rows)


def _sentence(text: str | None) -> str:
    """Return the first paragraph, beginning small, without its full stop."""
    first = " ".join((text or "").split("\n\n")[0].split())
    if not first[:3].isupper():
        first = first[:1].lower() + first[1:]
    return first.removesuffix(".")


def face_table() -> str:
    """Return the table of all functions of the library."""
    rows = []
    for name in tendon_cli.__all__:
        function = getattr(tendon_cli, name)
        if inspect.isfunction(function):
            signature = _plain(inspect.signature(function))
            rows.append((f"`{name}{signature}`", _sentence(function.__doc__)))
    return table(("function", "what it gives"), rows)


def _plain(signature: inspect.Signature) -> str:
    """Return a signature without types, and with `...` for a function as a default."""
    bare = [
        parameter.replace(annotation=inspect.Parameter.empty)
        for parameter in signature.parameters.values()
    ]
    return re.sub(r"<function .*? at \w+>", "...", str(inspect.Signature(bare)))


TABLES: dict[str, Callable[..., str]] = {
    "commands": command_table,
    "options": option_table,
    "exits": exit_table,
    "errors": error_table,
    "face": face_table,
    "keys": key_table,
    "others": other_key_table,
    "figures": lambda: keys_of_each("figure"),
    "rows": lambda: keys_of_each("table"),
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
    """Return a page with its tables as the code has them now."""

    def anew(match: re.Match[str]) -> str:
        name, *arguments = match[2].split()
        return f"{match[1]}{TABLES[name](*arguments)}\n{match[3]}"

    return MARKED.sub(anew, page)


if __name__ == "__main__":
    for page in Path(__file__).parent.glob("*.md"):
        page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")
