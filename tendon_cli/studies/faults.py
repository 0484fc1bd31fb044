"""What pydantic found, in the words of a study file: key, what was found, what was expected, the nearest name."""

from __future__ import annotations

import difflib
from functools import cache
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study import Study
from tendon_cli.studies.toml_scan import KeyPlaces
from tendon_cli.units import described, shorten

LISTS = ("cases", "figure")
MOST_FAULTS = 1000


def faults_of(error: ValidationError, places: KeyPlaces) -> list[Fault]:
    """Every fault of a study, in the order of the document, each with its line where the file has one."""
    details = error.errors(include_url=False)
    found = [_fault(detail, places) for detail in details[:MOST_FAULTS]]
    if len(details) > MOST_FAULTS:
        found.append(Fault("", f"and {len(details) - MOST_FAULTS} faults more"))
    return found


def in_order(faults: list[Fault]) -> list[Fault]:
    """Faults in the order of the document's lines."""
    return sorted(faults, key=lambda fault: fault.line if fault.line is not None else 10**9)


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
    given, context = described(detail.get("input")), detail.get("ctx") or {}
    if detail["type"] == "tendon":
        return context["problem"], context["hint"]
    if detail["type"] == "extra_forbidden":
        return _unknown(path)
    if detail["type"] == "missing":
        return f"is missing, each entry of {path[0]} needs it", None
    if detail["type"] == "literal_error":
        expected = context["expected"].replace("'", '"')
        return f"{given} is not possible, expected {expected}", _near(given, expected)
    if detail["type"] == "model_type":
        found = "has no value" if detail["input"] is None else f"{given} is not a table"
        return f"{found}, expected a table of keys", f"its keys: {', '.join(_valid_names(path))}"
    if detail["type"] == "tuple_type" and _valid_names(path):
        return f"{given} is not a list, expected a list of tables", f"in TOML, each of them starts with [[{path[-1]}]]"
    problems = {
        "string_pattern_mismatch": f"{given} is not a name, expected letters, digits, . _ - (64 at most)",
        "string_type": f"{given} is not text, expected text in quotes",
        "string_unicode": "holds a sign that is not Unicode, expected text",
        "tuple_type": f"{given} is not a list of words, expected a word in quotes or a list of them",
        "too_short": "an empty list, expected at least one value",
        "string_too_short": "is empty, expected text",
        "string_too_long": f"is too long, expected {context.get('max_length')} characters at most",
    }
    return problems.get(detail["type"], detail["msg"][:1].lower() + detail["msg"][1:]), None


def _unknown(path: list[str]) -> tuple[str, str]:
    """An unknown key: the nearest one beside it, or the table where a key of this name belongs."""
    name, beside = path[-1], _valid_names(path[:-1])
    elsewhere = {key.rpartition(".")[2]: key for key in reversed(_paths())}
    near = nearest(name, beside, cutoff=0.6)
    far = difflib.get_close_matches(name, list(elsewhere), n=1, cutoff=0.75)
    hint = near or (f'did you mean "{elsewhere[far[0]]}"?' if far else f"known here: {', '.join(beside)}")
    return "unknown key", hint


@cache
def _paths() -> list[str]:
    """The dotted keys of every table but those of a list."""
    found = [(name, [name]) for name in _valid_names([])]
    for path, parts in found:
        found += [(f"{path}.{name}", [*parts, name]) for name in _valid_names(parts) if path not in LISTS]
    return [path for path, _ in found if "." in path]


def _valid_names(table: list[str]) -> list[str]:
    """The keys that may stand in a table of the study."""
    schema = _schema()
    definitions, here = schema["$defs"], schema
    for part in table:
        if part.isdigit():
            continue
        inner = here.get("properties", {}).get(part, {})
        choices = [inner, inner.get("items", {}), *inner.get("anyOf", []), *inner.get("allOf", [])]
        reference = next((choice["$ref"] for choice in choices if "$ref" in choice), None)
        if reference is None:
            return []
        here = definitions[reference.rpartition("/")[2]]
    return list(here.get("properties", {}))


@cache
def _schema() -> dict[str, Any]:
    return Study.model_json_schema()


def _near(given: str, expected: str) -> str | None:
    choices = [word.strip(' "') for word in expected.replace(" or ", ",").split(",")]
    return nearest(given.strip('"'), choices)
