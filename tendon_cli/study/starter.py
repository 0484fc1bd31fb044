"""The commented study that `tendon init` writes."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from tendon_cli.errors import UsageError
from tendon_cli.files import write_new
from tendon_cli.study.reading import YAML_SUFFIXES
from tendon_cli.units import shorten


def starter(path: Path) -> str:
    """The starter study for a file of this name: YAML by its ending, else TOML."""
    ending = "yaml" if path.suffix.lower() in YAML_SUFFIXES else "toml"
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", path.stem).strip(".-")[:64] or "study"
    return files("tendon_cli.study").joinpath(f"starter.{ending}").read_text("utf-8").replace("@NAME@", name)


def write_starter(path: Path) -> None:
    """Write the starter study; raises UsageError where a file stands there, OutputError where none can be written."""
    if path.suffix.lower() not in (".toml", *YAML_SUFFIXES):
        name = shorten(path.name)
        raise UsageError(f"{name} ends in neither .toml nor .yaml", hint=f"tendon init {name}.toml")
    if not write_new(path, starter(path).encode()):
        raise UsageError(
            "exists already, and is not overwritten", where=shorten(str(path), 1000), hint="name another file"
        )
