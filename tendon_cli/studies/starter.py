"""The commented studies that `tendon init` writes, and the examples of the documentation that it copies."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from tendon_cli.errors import UsageError
from tendon_cli.files import write_new
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study_file import YAML_SUFFIXES
from tendon_cli.units import shorten

TEMPLATES = {
    "sweep": "which pretension and springs keep both tendons taut? (every key, with a comment)",
    "design": "which spring, spool and pretension work for every load?",
    "people": "for whom does a suit work?",
    "robust": "which suit works for real arms: soft tissue, an imprecise fit, a tilted upper arm?",
    "motor": "which motor does it need? (torque, speed, power, work, backlash)",
    "friction": "what do friction and bend of the sheath do, and their uncertainty?",
}
"""The starter studies, each with the question that it asks."""


def starter(path: Path, template: str = "sweep") -> str:
    """A starter study for a file of this name, YAML by its ending; raises UsageError for no template of that name."""
    is_yaml = path.suffix.lower() in YAML_SUFFIXES
    if template not in TEMPLATES:
        hint = nearest(template, TEMPLATES) or f"templates: {', '.join(TEMPLATES)}"
        raise UsageError(f'there is no template "{shorten(template)}"', where="--for", hint=hint)
    source = (
        f"starter.{'yaml' if is_yaml else 'toml'}"
        if template == "sweep"
        else f"templates/{template}.toml"
    )
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", path.stem).strip(".-")[:64] or "study"
    text = files("tendon_cli.studies").joinpath(source).read_text("utf-8").replace("@NAME@", name)
    return _as_yaml(text) if is_yaml and template != "sweep" else text


def _as_yaml(toml: str) -> str:
    """A template in YAML: tables become indented keys, and lists, inline tables and texts stay as they stand."""
    lines, indent = [], ""
    for line in toml.replace("#:schema ", "# yaml-language-server: $schema=").splitlines():
        table = re.match(r"\[(\w+)\]", line)
        if table:
            indent = "  "
            lines.append(f"{table[1]}:{line[table.end() :]}")
        else:
            lines.append((indent + re.sub(r"\b(\w+) = ", r"\1: ", line)).rstrip())
    return "\n".join(lines) + "\n"


def examples() -> dict[str, Path]:
    """Every study and CSV that the documentation uses, by its name, such as `design/universal.toml`."""
    package = Path(str(files("tendon_cli")))
    installed = package / "examples"
    folder = installed if installed.is_dir() else package.parent / "configs"  # of a checkout
    paths = (file for kind in ("toml", "csv") for file in folder.rglob(f"*.{kind}"))
    return {file.relative_to(folder).as_posix(): file for file in sorted(paths)}


def write_example(name: str, path: Path | None) -> tuple[Path, str]:
    """Copy an example to a new file, by default of the same name, and return both; raises UsageError, OutputError."""
    known = examples()
    short = {part: each for each in reversed(known) for part in (Path(each).stem, Path(each).name)}
    full = name if name in known else short.get(name)
    if full is None:
        hint = nearest(name, (*known, *short)) or "`tendon init --list` lists them"
        raise UsageError(f'there is no example "{shorten(name)}"', where="--from", hint=hint)
    target = path or Path(Path(full).name)
    _write(target, known[full].read_bytes())
    return target, full


def write_starter(path: Path, template: str = "sweep") -> None:
    """Write a starter study; raises UsageError where a file stands there, OutputError where none can be written."""
    if path.suffix.lower() not in (".toml", *YAML_SUFFIXES):
        name = shorten(path.name)
        raise UsageError(f"{name} ends in neither .toml nor .yaml", hint=f"tendon init {name}.toml")
    _write(path, starter(path, template).encode())


def _write(path: Path, content: bytes) -> None:
    if not write_new(path, content):
        problem, where = "exists already, and is not overwritten", shorten(str(path), 1000)
        raise UsageError(problem, where=where, hint="name another file")
