"""A study from its file, with what the command line sets, or all its faults in one error."""

from __future__ import annotations

import contextlib
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault, InputError, StudyError, TendonError, UsageError
from tendon_cli.study.attachments import Attachments
from tendon_cli.study.checks import contradictions, impossibilities
from tendon_cli.study.faults import faults_of, in_order
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
    given, found = _without_nothing(content, places)
    study, invalid = _validated(given, places)
    found += invalid
    files = Attachments(folder)
    if study is not None:
        found += contradictions(study)
        try:
            study = files.resolve(study)
        except InputError:
            if not found:
                raise
        found += files.faults or ([] if found else impossibilities(study))
    if study is None or found:
        raise StudyError(in_order([replace(f, line=f.line or places.line_of(f.key)) for f in found]))
    ranked = dict.fromkeys((*order, *_number_keys(content)))
    return study.ordered(tuple(key for key in ranked if key in study.numbers), files.sources)


def _without_nothing(content: dict[str, Any], places: KeyPlaces) -> tuple[dict[str, Any], list[Fault]]:
    """The content without keys that have no value, as YAML allows, and a fault for each of them."""
    kept: dict[str, Any] = {}
    found: list[Fault] = []
    for name, value in content.items():
        if value is None:
            found.append(Fault(name, "has no value", "leave the key out, or give it one", places.line_of(name)))
        elif isinstance(value, dict):
            kept[name], inner = _without_nothing(value, KeyPlaces())
            found += [replace(fault, key=f"{name}.{fault.key}") for fault in inner]
        else:
            kept[name] = value
    return kept, found


def _validated(content: dict[str, Any], places: KeyPlaces) -> tuple[Study | None, list[Fault]]:
    """The study, and the faults of its single keys; with faults, the study without the keys at fault if that is one."""
    try:
        return Study.model_validate(content), []
    except ValidationError as error:
        found = faults_of(error, places)
        rest = deepcopy(content)
        for detail in error.errors(include_url=False):
            _drop(rest, detail["loc"])
        with contextlib.suppress(ValidationError):
            return Study.model_validate(rest), found
        return None, found


def _drop(content: dict[str, Any], path: tuple[int | str, ...]) -> None:
    """Remove the key at a path, or the last table on the way to it."""
    table: Any = content
    for part in path[:-1]:
        inner = table.get(part) if isinstance(table, dict) else None
        if not isinstance(inner, dict):
            if isinstance(table, dict):
                table.pop(part, None)
            return
        table = inner
    table.pop(path[-1], None)


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
    key, text = shorten(key), text.strip()
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
