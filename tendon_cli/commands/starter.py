"""Commented studies that `tendon init` writes, and examples of the documentation that it copies."""

from __future__ import annotations

import re
import shlex
from importlib.resources import files
from pathlib import Path

from tendon_cli.errors import UsageError
from tendon_cli.files import write_new
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.study_file import YAML_SUFFIXES
from tendon_cli.units import shorten

TEMPLATES = {
    "sweep": "which pretension and springs keep both tendons taut? (every key, with a comment)",
    "design": "which springs, spool and tension suit one elbow, with anchors that you measured?",
    "people": "for whom does one suit work? (bodies of a survey, or a list of persons)",
    "robust": "which suit works for real arms: soft tissue, an imprecise fit, a tilted upper arm?",
    "motor": "which motor does the suit need? (torque, speed, power, work, backlash)",
    "friction": "how much do the sheath's friction and bend matter, and how well they are known?",
}
"""Names of the starter studies, each with the question that it asks."""


def starter(path: Path, template: str = "sweep") -> str:
    """Return the text of a starter study.

    Args:
        path: File that the study is for: its stem is the study's name, and its ending says
            whether the text is YAML.
        template: Name of the starter study, one of `TEMPLATES`.

    Raises:
        UsageError: There is no such template.
    """
    is_yaml = path.suffix.lower() in YAML_SUFFIXES
    if template not in TEMPLATES:
        hint = hint_at_nearest(template, TEMPLATES) or f"templates: {', '.join(TEMPLATES)}"
        raise UsageError(f'there is no template "{shorten(template)}"', where="--for", hint=hint)
    if template != "sweep":
        source = f"templates/{template}.toml"
    elif is_yaml:
        source = "starter.yaml"
    else:
        source = "starter.toml"
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", path.stem).strip(".-")[:64] or "study"
    text = files("tendon_cli.studies").joinpath(source).read_text("utf-8").replace("@NAME@", name)
    needs_yaml = is_yaml and source.endswith(".toml")
    return _as_yaml(text) if needs_yaml else text


def _as_yaml(toml: str) -> str:
    """Return a template in YAML.

    Tables become indented keys; lists, inline tables and texts stay as they are.
    """
    lines: list[str] = []
    indent = ""
    for line in toml.replace("#:schema ", "# yaml-language-server: $schema=").splitlines():
        table = re.match(r"\[(\w+)\]", line)
        if table:
            indent = "  "
            lines.append(f"{table[1]}:{line[table.end() :]}")
        else:
            lines.append((indent + re.sub(r"\b(\w+) = ", r"\1: ", line)).rstrip())
    return "\n".join(lines) + "\n"


def examples() -> dict[str, Path]:
    """Return studies and CSVs of the documentation, by names such as `design/universal.toml`."""
    folder = examples_folder()
    paths = (file for kind in ("toml", "csv") for file in folder.rglob(f"*.{kind}"))
    return {file.relative_to(folder).as_posix(): file for file in sorted(paths)}


def examples_folder() -> Path:
    """Return the folder of the studies and CSVs of the documentation."""
    package = Path(str(files("tendon_cli")))
    folder = package / "examples"
    return folder if folder.is_dir() else package.parent / "configs"  # the latter of a checkout


def write_example(name: str, path: Path | None) -> tuple[Path, str]:
    """Copy an example to a new file.

    Args:
        name: Name of the example; that of its file alone, or its stem, will do.
        path: The new file; None for one of the example's name in the working directory.

    Returns:
        The new file, and the whole name of the example.

    Raises:
        UsageError: There is no such example, or the file exists.
        OutputError: The file cannot be written.
    """
    known = examples()
    short: dict[str, str] = {}
    for example in sorted(
        known, key=lambda one: one.count("/"), reverse=True
    ):  # those in no folder win
        short[Path(example).stem] = example
        short[Path(example).name] = example
    full = name if name in known else short.get(name)
    if full is None:
        hint = hint_at_nearest(name, (*known, *short)) or "`tendon init --list` lists them"
        raise UsageError(f'there is no example "{shorten(name)}"', where="--from", hint=hint)
    target = path or Path(Path(full).name)
    _write(target, known[full].read_bytes())
    return target, full


def next_step(template: str, file: Path) -> str:
    """Return the command to type after a starter study was written."""
    verb = "sweep" if template == "sweep" else "design"
    return f"next: tendon {verb} {shlex.quote(str(file))}"


def next_step_of_example(example: str, file: Path) -> str:
    """Return the command to type after an example was copied, or how a study names the copy.

    The command copies files that it needs and that are not there yet.

    Args:
        example: Whole name of the example, such as `design/universal.toml`.
        file: The copy.
    """
    folder, _, name = example.rpartition("/")
    if folder == "parts" and name != "parts.toml":
        return f'in a study: [[table]] with file = "{file}"'
    needed: list[str] = []
    shown = shlex.quote(str(file))
    if folder == "friction":
        bend = "" if name == "several_angles.csv" else ' --bend-angle "144 deg"'
        command = f"tendon fit-friction {shown}{bend}"
    elif name == "suit_log.csv":
        needed = ["suit/suit.toml"]
        command = f"tendon fit-suit {_beside(file, 'suit.toml')} {shown} --out fit.toml"
    elif example == "suit/suit.toml":
        needed = ["suit/suit_log.csv"]
        command = f"tendon fit-suit {shown} {_beside(file, 'suit_log.csv')} --out fit.toml"
    else:
        needed = ["parts/springs.csv", "parts/motors.csv"] if name == "parts.toml" else []
        verb = "design" if folder in ("design", "parts") else "sweep"
        command = f"tendon {verb} {shown}"
    steps = []
    for one in needed:
        copy = file.with_name(Path(one).name)
        if not copy.exists():
            into = "" if file.parent == Path() else f" {shlex.quote(str(copy))}"
            steps.append(f"tendon init --from {one}{into}")
    return f"next: {' && '.join([*steps, command])}"


def _beside(file: Path, name: str) -> str:
    """Return the path of a file beside another one, as a shell takes it."""
    return shlex.quote(str(file.with_name(name)))


def write_starter(path: Path, template: str = "sweep") -> None:
    """Write a starter study to a new file.

    Raises:
        UsageError: There is no such template, or the file exists or has another ending.
        OutputError: The file cannot be written.
    """
    if path.suffix.lower() not in (".toml", *YAML_SUFFIXES):
        name = shorten(path.name)
        raise UsageError(f"{name} ends in neither .toml nor .yaml", hint=f"tendon init {name}.toml")
    _write(path, starter(path, template).encode())


def _write(path: Path, content: bytes) -> None:
    """Write a new file; raise UsageError if it exists."""
    if not write_new(path, content):
        problem = "exists already, and is not overwritten"
        raise UsageError(problem, where=shorten(str(path), 1000), hint="name another file")
