"""The JSON Schema of the study file, for editors and for whoever writes studies by program."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from tendon_cli.studies.study import Study, keys


def schema_text() -> str:
    """The schema as JSON text."""
    schema = Study.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "tendon study"
    return json.dumps(schema, indent=2)


def key_words() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Every key by its dotted path, with its meaning and, where it is one of a few words, these."""
    schema = Study.model_json_schema()
    return dict(_keys_in(schema, schema["$defs"], ""))


def _keys_in(
    table: dict[str, Any], parts: dict[str, Any], before: str
) -> Iterator[tuple[str, tuple[str, tuple[str, ...]]]]:
    for name, node in table["properties"].items():
        found = [*_meant(node, parts)]
        inner = next((choice for choice in found if "properties" in choice), None)
        if inner is not None and f"{before}{name}" not in keys():
            if not any("items" in choice for choice in found):  # no single key sets one of a list of tables
                yield from _keys_in(inner, parts, f"{before}{name}.")
            continue
        meaning = next((choice["description"] for choice in found if "description" in choice), "")
        words = [word for choice in found for word in choice.get("enum", [choice.get("const")])]
        words += ["true", "false"] if node.get("type") == "boolean" else []
        yield f"{before}{name}", (meaning, tuple(dict.fromkeys(word for word in words if isinstance(word, str))))


def _meant(node: dict[str, Any], parts: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A node, and all that it may stand for."""
    yield node
    if "$ref" in node:
        yield from _meant(parts[node["$ref"].rpartition("/")[2]], parts)
    for choice in (*node.get("anyOf", ()), *([node["items"]] if "items" in node else ())):
        yield from _meant(choice, parts)
