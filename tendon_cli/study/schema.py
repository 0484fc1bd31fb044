"""The JSON Schema of the study file, for editors and for whoever writes studies by program."""

from __future__ import annotations

import json

from tendon_cli.study.study import Study


def schema_text() -> str:
    """The schema as JSON text."""
    schema = Study.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "tendon study"
    return json.dumps(schema, indent=2)
