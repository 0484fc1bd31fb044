"""The JSON Schema of the study file, for editors and for whoever writes studies by program."""

from __future__ import annotations

import json

from tendon_cli.study.study import Study


def schema_text() -> str:
    """The schema as JSON text; `name` may be left out of a file, which then gives its own."""
    schema = Study.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "tendon study"
    schema["required"] = [key for key in schema.get("required", []) if key != "name"]
    return json.dumps(schema, indent=2)
