"""The JSON Schema of the study file, for editors and programs, and what pydantic reports of a study, in our words."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.toml_reading import KeyPlaces
from tendon_cli.units import described, shorten

MOST_FAULTS = 1000


@cache
def _schema() -> dict[str, Any]:
    return Study.model_json_schema()


def schema_text() -> str:
    """The schema as JSON text."""
    draft = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps({**_schema(), "$schema": draft, "title": "tendon study"}, indent=2)


@cache
def key_words() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Every key by its dotted path, with its meaning and, where it is one of a few words, these."""
    return dict(_keys_in(_schema(), ""))


def _keys_in(
    table: dict[str, Any], before: str
) -> Iterator[tuple[str, tuple[str, tuple[str, ...]]]]:
    for name, node in table["properties"].items():
        choices = [*_meant(node)]
        inner = next((choice for choice in choices if "properties" in choice), None)
        if inner is not None and f"{before}{name}" not in keys():
            if not any(
                "items" in choice for choice in choices
            ):  # no single key sets one of a list of tables
                yield from _keys_in(inner, f"{before}{name}.")
            continue
        meaning = next((choice["description"] for choice in choices if "description" in choice), "")
        words = [word for choice in choices for word in choice.get("enum", [choice.get("const")])]
        words += ["true", "false"] if node.get("type") == "boolean" else []
        yield (
            f"{before}{name}",
            (meaning, tuple(dict.fromkeys(word for word in words if isinstance(word, str)))),
        )


def _meant(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A node, and all that it may stand for."""
    yield node
    if "$ref" in node:
        yield from _meant(_schema()["$defs"][node["$ref"].rpartition("/")[2]])
    for choice in (*node.get("anyOf", ()), *([node["items"]] if "items" in node else ())):
        yield from _meant(choice)


def _names_in(table: list[str]) -> list[str]:
    """The keys that may stand in a table of the study."""
    here = _schema()
    for part in table:
        if not part.isdigit():
            choices = _meant(here["properties"].get(part, {}))
            here = next(
                (choice for choice in choices if "properties" in choice), {"properties": {}}
            )
    return list(here["properties"])


# --- Faults ----------------------------------------------------------------------------------------------------------


def faults_of(error: ValidationError, places: KeyPlaces) -> list[Fault]:
    """What is wrong with the keys of a study, each with its line where the file has one."""
    details = error.errors(include_url=False)
    faults = [_fault(detail, places) for detail in details[:MOST_FAULTS]]
    return faults + (
        [Fault("", f"and {len(details) - MOST_FAULTS} faults more")]
        if len(details) > MOST_FAULTS
        else []
    )


def _fault(detail: Any, places: KeyPlaces) -> Fault:
    path = [str(part) for part in detail["loc"]]
    problem, hint = _words(detail, path)
    line = places.line_of(".".join(path))
    if path == ["name"] and line is None:
        hint = hint or "where a study has no name, it is called as its file"
    if detail["type"] == "literal_error" and path[-1].isdigit():
        path.pop()  # one word of a list, or the only one, which needs no list
    return Fault(shorten(".".join(path), 120), problem, hint, line)


def _words(detail: Any, path: list[str]) -> tuple[str, str | None]:
    """The problem and a hint, for what pydantic reports."""
    kind, given, context = detail["type"], described(detail.get("input")), detail.get("ctx") or {}
    if kind == "tendon":
        return context["problem"], context["hint"]
    if kind == "extra_forbidden":
        key = ".".join(path[2:])
        if path[0] == "cases" and any(f"{known}.".startswith(f"{key}.") for known in key_words()):
            return (
                "is the same for all cases",
                f"say {key} for the whole study, or write a study for each case",
            )
        return "unknown key", _meant_key(path)
    if kind == "literal_error":
        words = [word.strip(" '") for word in context["expected"].replace(" or ", ",").split(",")]
        expected = context["expected"].replace("'", '"')
        return f"{given} is not possible, expected {expected}", nearest(given.strip('"'), words)
    if kind == "model_type":
        problem = "has no value" if detail["input"] is None else f"{given} is not a table"
        return f"{problem}, expected a table of keys", f"its keys: {', '.join(_names_in(path))}"
    if kind == "tuple_type" and _names_in(path):
        return (
            f"{given} is not a list, expected a list of tables",
            f"in TOML, each of them starts with [[{path[-1]}]]",
        )
    problems = {
        "missing": f"is missing, each entry of {path[0] if path else 'the study'} needs it",
        "string_pattern_mismatch": f"{given} is not a name, expected letters, digits, . _ -",
        "string_type": f"{given} is not text, expected text in quotes",
        "tuple_type": f"{given} is not a list of words, expected a word in quotes or a list of them",
        "too_short": "an empty list, expected at least one value",
    }
    return problems.get(kind, detail["msg"][:1].lower() + detail["msg"][1:]), None


def _meant_key(path: list[str]) -> str:
    """A hint at an unknown key: the nearest one of its table, or the table where a key of this name belongs."""
    name, known = path[-1], _names_in(path[:-1])
    elsewhere = {key.rpartition(".")[2]: key for key in reversed(key_words()) if "." in key}
    far = difflib.get_close_matches(name, list(elsewhere), n=1, cutoff=0.75)
    other = f'did you mean "{elsewhere[far[0]]}"?' if far else f"known here: {', '.join(known)}"
    return nearest(name, known, cutoff=0.6) or other
