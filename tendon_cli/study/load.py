"""A study from its file, with what the command line sets, or all its faults in one error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault, StudyError, TendonError, UsageError
from tendon_cli.study.attachments import Attachments
from tendon_cli.study.checks import contradictions
from tendon_cli.study.faults import faults_of
from tendon_cli.study.reading import Document, read_document, read_value
from tendon_cli.study.study import Study, keys
from tendon_cli.study.toml_scan import MAX_KEY_PARTS, KeyPlaces
from tendon_cli.units import shorten


def load_study(path: Path, settings: tuple[str, ...] = ()) -> Study:
    """Read and check a study file (TOML, or YAML by its ending), then apply `KEY=VALUE` settings.

    Raises StudyError with every fault found, InputError for a file it names that cannot be trusted.
    """
    try:
        document = read_document(path)
        before = _axes_in_order(document)
        changed = [_apply(document.content, setting) for setting in settings]
        document.content.setdefault("name", path.stem)
        return study_from(document.content, document.places, folder=path.parent, order=(*before, *changed))
    except TendonError as error:
        if error.where is None:
            error.where = str(path)
        raise


def study_from(
    content: dict[str, Any], places: KeyPlaces | None = None, *, folder: Path = Path(), order: tuple[str, ...] = ()
) -> Study:
    """A checked study from a plain dictionary; files that it names are looked up in `folder`.

    `order` lists keys in the order in which their axes shall vary; keys that it leaves out follow as the content has
    them.
    """
    places = places or KeyPlaces()
    try:
        study = Study.model_validate(content)
    except ValidationError as error:
        raise StudyError(faults_of(error, places)) from None
    found = contradictions(study)
    if found:
        raise StudyError([Fault(f.key, f.problem, f.hint, places.line_of(f.key)) for f in found])
    files = Attachments(folder)
    study = files.resolve(study)
    ranked = dict.fromkeys((*order, *_number_keys(content)))
    return study.ordered(tuple(key for key in ranked if key in study.numbers), files.sources)


def _axes_in_order(document: Document) -> list[str]:
    """Keys of the document that hold a list or a grid, in the order of its lines."""
    found = [
        path
        for path, value in _number_keys(document.content).items()
        if isinstance(value, (list, dict)) and path != "motion.elbow_angle"
    ]
    return sorted(found, key=lambda path: document.places.line_of(path) or 0)


def _number_keys(content: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """What stands at each number key of a plain dictionary."""
    found: dict[str, Any] = {}
    for name, value in content.items():
        path = f"{prefix}{name}"
        if path in keys():
            found[path] = value
        elif isinstance(value, dict):
            found |= _number_keys(value, f"{path}.")
    return found


def _apply(content: dict[str, Any], setting: str) -> str:
    """Put one `KEY=VALUE` into the content and return the key; raises UsageError or StudyError."""
    key, equals, text = setting.partition("=")
    parts = key.strip().split(".")
    if not equals or not all(parts) or len(parts) > MAX_KEY_PARTS:
        raise UsageError(f"--set {shorten(setting)} is not KEY=VALUE", hint="such as --set 'arm.b1=160 mm'")
    text = text.strip()
    try:
        value = read_value(text) if text[:1] in ("[", "{", '"', "'") else text
    except StudyError as error:
        raise UsageError(
            f"--set {key}: {error.faults[0].problem}", hint="the value is TOML, quoted for the shell"
        ) from None
    table = content
    for part in parts[:-1]:
        inner = table.setdefault(part, {})
        if not isinstance(inner, dict):
            raise UsageError(f"--set {key}: {part} is not a table of keys")
        table = inner
    table[parts[-1]] = value
    return ".".join(parts)
