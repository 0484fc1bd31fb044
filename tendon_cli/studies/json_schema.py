"""JSON Schema of the study file, for editors and programs, and faults of its keys in our words."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault
from tendon_cli.studies.contents import fields_in
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.gone import IS_GONE, instead_of
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.toml_reading import KeyPlaces
from tendon_cli.units import described, shorten

MOST_FAULTS = 1000
"""Largest number of faults that an error lists."""


@cache
def _schema() -> dict[str, Any]:
    """Return the schema of a study as pydantic builds it."""
    return Study.model_json_schema()


def schema_text() -> str:
    """Return the schema as JSON text."""
    draft = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps({**_schema(), "$schema": draft, "title": "tendon study"}, indent=2)


@cache
def key_words() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return every key by its dotted path, with its meaning and the words that it may be.

    The words are empty for a key that is not one of a few words.
    """
    return dict(_keys_in(_schema(), ""))


def _keys_in(
    table: dict[str, Any], prefix: str
) -> Iterator[tuple[str, tuple[str, tuple[str, ...]]]]:
    """Yield the keys of a table of the schema, each as `key_words` has it."""
    for name, node in table["properties"].items():
        path = f"{prefix}{name}"
        choices = [*_choices(node)]
        inner = next((choice for choice in choices if "properties" in choice), None)
        if inner is None or path in keys():
            yield path, (_meaning(choices), _words_of(node, choices))
        elif not any("items" in choice for choice in choices):
            # No single key sets one of a list of tables.
            yield from _keys_in(inner, f"{path}.")


def _meaning(choices: list[dict[str, Any]]) -> str:
    """Return the first description among the choices of a key; empty if there is none."""
    return next((choice["description"] for choice in choices if "description" in choice), "")


def _words_of(node: dict[str, Any], choices: list[dict[str, Any]]) -> tuple[str, ...]:
    """Return the words that a key may be, each once."""
    values: list[Any] = []
    for choice in choices:
        values += choice.get("enum", [choice.get("const")])
    if node.get("type") == "boolean":
        values += ["true", "false"]
    return tuple(dict.fromkeys(value for value in values if isinstance(value, str)))


def _choices(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a node, and all nodes that it refers to, offers as alternatives or lists."""
    yield node
    if "$ref" in node:
        definition = node["$ref"].rpartition("/")[2]
        yield from _choices(_schema()["$defs"][definition])
    for choice in node.get("anyOf", ()):
        yield from _choices(choice)
    if "items" in node:
        yield from _choices(node["items"])


def _names_in(path: list[str]) -> list[str]:
    """Return the keys that may stand in the table at a path; none if it is no table."""
    key = ".".join(part for part in path if not part.isdigit())
    kind = fields_in(Study).get(key) if key else Study
    return list(kind.model_fields) if isinstance(kind, type) else []


# --- Faults --------------------------------------------------------------------------------------


def faults_of(
    error: ValidationError, places: KeyPlaces, *, has_tables: bool = False
) -> list[Fault]:
    """Return the faults of the keys of a study, each with its line if the file has one.

    Args:
        error: The error of the study's validation.
        places: Places of the keys.
        has_tables: True if the study has a `[[table]]`, whose columns may be taken for limits.
    """
    details = error.errors(include_url=False)
    faults = [_fault(detail, places, has_tables=has_tables) for detail in details[:MOST_FAULTS]]
    if len(details) > MOST_FAULTS:
        faults.append(Fault("", f"and {len(details) - MOST_FAULTS} more faults"))
    return faults


def _fault(detail: Any, places: KeyPlaces, *, has_tables: bool) -> Fault:
    """Return one fault from what pydantic reports."""
    path = [str(part) for part in detail["loc"]]
    problem, hint = _problem_and_hint(detail, path, has_tables=has_tables)
    whole_key = ".".join(path)
    if path == ["name"] and places.line_of(whole_key) is None:
        hint = hint or "a study without a name is named after its file"
    if detail["type"] == "literal_error" and path[-1].isdigit():
        path.pop()  # one word of a list, or the only one, which needs no list
    return places.placed(Fault(shorten(".".join(path), 120), problem, hint), whole_key)


def _problem_and_hint(detail: Any, path: list[str], *, has_tables: bool) -> tuple[str, str | None]:
    """Return the problem and a hint, in our words, from what pydantic reports."""
    kind = detail["type"]
    given = described(detail.get("input"))
    context = detail.get("ctx") or {}
    if kind == "tendon":
        return context["problem"], context["hint"]
    if kind == "extra_forbidden":
        instead = instead_of(path)
        if instead is not None:
            return IS_GONE, instead
        return "unknown key", _hint_at_key(path, given, has_tables=has_tables)
    if kind == "literal_error":
        words = [word.strip(" '") for word in context["expected"].replace(" or ", ",").split(",")]
        expected = context["expected"].replace("'", '"')
        return f"{given} is not possible, expected {expected}", hint_at_nearest(
            given.strip('"'), words
        )
    if kind == "model_type":
        problem = "has no value" if detail["input"] is None else f"{given} is not a table"
        return f"{problem}, expected a table of keys", f"its keys: {', '.join(_names_in(path))}"
    if kind == "tuple_type" and _names_in(path):
        problem = f"{given} is not a list, expected a list of tables"
        return problem, f"in TOML, each of them starts with [[{path[-1]}]]"
    problems = {
        "string_pattern_mismatch": f"{given} is not a name, expected letters, digits, . _ -",
        "string_too_short": "an empty text, expected at least 1 character",
        "string_type": f"{given} is not text, expected text in quotes",
        "tuple_type": f"{given} is not a list of words, expected a word in quotes or a list of "
        "them",
        "too_short": "an empty list, expected at least one value",
    }
    message = detail["msg"]
    return problems.get(kind, message[:1].lower() + message[1:]), None


def _hint_at_key(path: list[str], given: str, *, has_tables: bool) -> str:
    """Return a hint at an unknown key.

    It names the nearest key of its table, or another table with a key of this name, or all keys of
    its table. A number that the rows of a table carry along, such as a price, is no limit: the
    hint has the filter of the answer that is one.

    Args:
        path: The key, part by part.
        given: Its value, as it is told.
        has_tables: True if the study has a `[[table]]`.
    """
    name = path[-1]
    known = _names_in(path[:-1])
    if path == ["spool", "extensor_radius"]:
        return "the extensor's radius is spool.ratio times spool.flexor_radius: state these two"
    near = hint_at_nearest(name, known, cutoff=0.6)
    if near is not None:
        return near
    elsewhere = {key.rpartition(".")[2]: key for key in reversed(key_words()) if "." in key}
    alike = difflib.get_close_matches(name, list(elsewhere), n=1, cutoff=0.75)
    if alike:
        return f'did you mean "{elsewhere[alike[0]]}"?'
    if path[:-1] == ["limits"] and has_tables:
        filtered = f'tendon show RESULTS --where "{name} < {given.strip(chr(34))}"'
        return f"if {name} is a column of a [[table]], filter the answer: `{filtered}`"
    return f"known here: {', '.join(known)}"
