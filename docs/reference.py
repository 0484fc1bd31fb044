"""Tables of reference, from the code itself; `python docs/refresh.py` writes them into the pages.

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
from tendon_cli import errors, say
from tendon_cli.commands import cli
from tendon_cli.model.limits import ADDED, LIMITS
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_STATES,
    OF_TRAJECTORIES,
    QUANTITIES,
)
from tendon_cli.studies.space.axis import limit_of, split_side
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.usual import USUAL, UsualDeviation
from tendon_cli.units import UNITS

MARKED = re.compile(r"(<!-- from the code: ([\w -]+) -->\n).*?(<!-- until here -->)", re.DOTALL)
NEGATIVE = (
    "Finished, but states have no equilibrium, no choice has a window, or `check` found a limit "
    "broken or a change."
)
MOST_WORDS = 9
"""Largest number of words that the table of keys lists for one of them."""
_HEADS_OF_KEYS = ("key", "meaning")
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
        quantity = key.quantity
        meaning = f"{quantity.symbol}: {quantity.long_name}"
        rows.append((f"`{path}`", meaning, _default(path)))
    return table(("key", "meaning", "default"), rows)


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
    """Return the row of a key: itself, and its meaning with the words that it may be."""
    words: list[Any] = []
    for each in alternatives:
        words += each.get("enum", [each["const"]] if "const" in each else [])
    unique = list(dict.fromkeys(word for word in words if isinstance(word, str)))
    meaning = next((each["description"] for each in alternatives if "description" in each), "")
    meaning = meaning.removeprefix("share: ")
    meaning = re.sub(r" (A bare number is in|An angle has) .*", "", meaning)
    meaning = _escaped(meaning.removesuffix("."))
    is_told = all(word in meaning for word in unique)
    if not is_told and len(unique) <= MOST_WORDS:
        meaning += ": " + ", ".join(f'`"{word}"`' for word in unique)
    default = node.get("default")
    if path != "name" and default not in (None, "", [], unique):
        meaning += f"; default {_shown(default)}"
    return [f"`{path}`", meaning]


def _shown(default: Any) -> str:
    """Return a default as a study has it."""
    if isinstance(default, list):
        return ", ".join(f'`"{word}"`' for word in default)
    if isinstance(default, str):
        return f'`"{default}"`'
    return f"{default}".lower() if isinstance(default, bool) else f"{default:,}"


def limit_table() -> str:
    """Return the table of all limits, with what each needs."""
    rows = []
    for name, limit in LIMITS.items():
        needs = ", ".join(f"`{need.key}`" for need in limit.needs)
        rows.append((f"`limits.{name}`", QUANTITIES[name].unit, needs))
    return table(("limit", "unit", "needs"), rows)


def usual_table() -> str:
    """Return the table of usual deviations, with what each is taken from."""
    by_deviation: dict[UsualDeviation, list[str]] = {}
    for key, deviation in USUAL.items():
        by_deviation.setdefault(deviation, []).append(key)
    rows = []
    for deviation, its_keys in by_deviation.items():
        text = deviation.text(its_keys[0]) + (", each side" if deviation.has_sides else "")
        rows.append((", ".join(f"`{key}`" for key in its_keys), text, deviation.source))
    return table(("number", "usual deviation", "from"), rows)


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
        meaning = f"{quantity.symbol}: {quantity.long_name}"
        rows.append((f"`{quantity.name}`", quantity.unit, meaning))
    return table(("column", "unit", "meaning"), rows)


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
    """Return the table of the options that a command shares with no other."""
    shared = _commands_by_option()
    rows = [row for row in _options(name) if len(shared[row]) == 1]
    return table(("option", "meaning"), rows)


def shared_option_table() -> str:
    """Return the table of the options of several commands, with these commands."""
    rows = []
    for (flags, meaning), names in _commands_by_option().items():
        if len(names) > 1:
            rows.append((flags, meaning, ", ".join(names)))
    return table(("option", "meaning", "commands"), rows)


def _commands_by_option() -> dict[tuple[str, str], list[str]]:
    """Return the commands that have an option with the same meaning."""
    commands: dict[tuple[str, str], list[str]] = {}
    for name in COMMANDS:
        for row in _options(name):
            commands.setdefault(row, []).append(name)
    return commands


def _options(name: str) -> list[tuple[str, str]]:
    """Return all options of a command, as they are typed, with their meanings."""
    rows = []
    for option in filter(_is_option, COMMANDS[name].params):
        value = "" if option.is_flag or not option.metavar else f" {option.metavar}"
        flags = [f"`{flag}{value}`" for flag in (*option.opts, *option.secondary_opts)]
        meaning = _escaped(option.help)
        has_default = isinstance(option.default, str | int | float | Path)
        if has_default and not isinstance(option.default, bool):
            meaning += f"; default {option.default}"
        rows.append((", ".join(flags).replace("|", "\\|"), meaning))
    return rows


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
        said = _sentence(kind.__doc__).partition("; ")[0]
        meaning = f"`{kind.kind}` (`{kind.__name__}`): {said}"
        rows[kind.exit] = f"{rows[kind.exit]}; {meaning}" if kind.exit in rows else meaning
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        rows[128 + number] = f"`{errors.InterruptError.kind}` (`InterruptError`): by {number.name}"
    return table(("exit", "meaning"), ((f"{code}", rows[code]) for code in sorted(rows)))


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
    """Return a signature with its first arguments, and `...` for those that need their names."""
    bare = []
    for parameter in signature.parameters.values():
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
            return f"{inspect.Signature(bare)}"[:-1] + ", ...)"
        bare.append(parameter.replace(annotation=inspect.Parameter.empty))
    return f"{inspect.Signature(bare)}"


TABLES: dict[str, Callable[..., str]] = {
    "commands": command_table,
    "options": option_table,
    "shared": shared_option_table,
    "exits": exit_table,
    "face": face_table,
    "keys": key_table,
    "others": other_key_table,
    "figures": lambda: keys_of_each("figure"),
    "rows": lambda: keys_of_each("table"),
    "limits": limit_table,
    "usual": usual_table,
    "units": unit_table,
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
