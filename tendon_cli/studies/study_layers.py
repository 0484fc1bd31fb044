"""Layers of a study: its own file and, by `extends`, the file below it, and so on.

Tables merge; a list, a number or any other value of an upper layer replaces that of a lower one.
The name of a study is its own: a lower layer does not give it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tendon_cli.errors import Fault, StudyError, UsageError
from tendon_cli.files import path_of
from tendon_cli.studies.contents import table_type
from tendon_cli.studies.parts import Part
from tendon_cli.studies.study import EXTENDS, Study
from tendon_cli.studies.study_file import STDIN, read_document
from tendon_cli.studies.toml_reading import Document, KeyPlaces, shown
from tendon_cli.units import shorten

MAX_LAYERS = 16
"""Largest number of files of which a study is made."""
_OWN_KEYS = ("name", EXTENDS)
"""Keys that an upper layer does not take over from a lower one."""


@dataclass(frozen=True)
class Layer:
    """One file of a study."""

    document: Document
    """Its content; the places of a lower layer name its file."""
    file: Path | None
    """Path of a lower layer from the folder of the study; None for the study's own content."""


def read_layers(document: Document, own: Path | None, folder: Path) -> list[Layer]:
    """Return the layers of a study, the lowest first and the study's own last.

    Args:
        document: Content of the study's own file.
        own: Path of this file; None if the study is no file.
        folder: Folder of the study.

    Raises:
        StudyError: A lower layer is missing or cannot be read, or a file extends itself.
    """
    layers = [Layer(document, None)]
    names = ["this study" if own is None or own == STDIN else own.name]
    identities = [] if own is None or own == STDIN else [_identity(own)]
    while True:
        top = layers[0]
        named = top.document.content.get(EXTENDS)
        if not isinstance(named, str) or not named:
            return layers
        try:
            base = _read_base(named, top, folder)
            identity = _identity(folder / _path_of(named, top))
            names.append(_path_of(named, top).name)
            if identity in identities:
                chain = " extends ".join(map(shorten, names))
                raise _fault_of(top, f"a study cannot extend itself: {chain}")
            if len(layers) == MAX_LAYERS:
                raise _fault_of(top, f"more than {MAX_LAYERS} files extend one another")
        except StudyError as error:
            file = None if top.file is None else shown(top.file)
            placed = [fault if fault.file else replace(fault, file=file) for fault in error.faults]
            raise StudyError(placed) from None
        identities.append(identity)
        layers.insert(0, base)


def merge_layers(layers: Sequence[Layer]) -> Document:
    """Return the content of all layers as one, with the place of every key."""
    content: dict[str, Any] = {}
    places = KeyPlaces()
    for layer in layers:
        for key in _OWN_KEYS:
            content.pop(key, None)
            places.remove(key)
        _merge(content, layer.document.content, "", places)
        places.add(layer.document.places)
    return Document(content, places)


def layer_sources(layers: Sequence[Layer], own: Path | None) -> dict[str, dict[str, Any]]:
    """Return name and hash of the files of a study, by the key that names each.

    There are none if the study extends no other. The study's own file stands under "study", if it
    is one; the base of its base under "extends.extends".

    Args:
        layers: Layers of the study, the lowest first.
        own: Path of the study's own file; None if it is no file.
    """
    if len(layers) == 1:
        return {}
    sources: dict[str, dict[str, Any]] = {}
    *lower, top = layers
    if own is not None and top.document.sha256:
        name = "standard input" if own == STDIN else own.name
        sources["study"] = {"file": name, "sha256": top.document.sha256}
    key = EXTENDS
    for layer in reversed(lower):
        file = layer.file or Path()
        sources[key] = {"file": file.name, "sha256": layer.document.sha256}
        key = f"{key}.{EXTENDS}"
    return sources


# --- Files ----------------------------------------------------------------------------------------


def _path_of(named: str, layer: Layer) -> Path:
    """Return the path of the file that a layer extends, from the folder of the study."""
    beside = Path() if layer.file is None else layer.file.parent
    return beside / named


def _read_base(named: str, layer: Layer, folder: Path) -> Layer:
    """Return the layer below another.

    Args:
        named: Path of its file, from the folder of the layer that names it.
        layer: Layer that names it.
        folder: Folder of the study.

    Raises:
        StudyError: It cannot be read, or is no study.
    """
    file = _path_of(named, layer)
    path = folder / file
    if path == STDIN:
        raise _fault_of(layer, "standard input cannot be extended, expected the name of a file")
    try:
        document = read_document(path_of(path))
    except UsageError as error:
        raise _fault_of(layer, f'"{shorten(named)}": {error.message}', error.hint) from None
    except StudyError as error:
        fault = error.faults[0]
        is_about_content = fault.line is not None or fault.key
        if is_about_content:
            raise StudyError([replace(fault, file=shown(file))]) from None
        raise _fault_of(layer, f'"{shorten(named)}": {fault.problem}', fault.hint) from None
    document.places.files = dict.fromkeys(document.places.lines, file)
    return Layer(document, file)


def _fault_of(layer: Layer, problem: str, hint: str | None = None) -> StudyError:
    """Return the error for a layer that cannot extend what it names."""
    line = layer.document.places.line_of(EXTENDS)
    return StudyError([Fault(EXTENDS, problem, hint, line)])


def _identity(path: Path) -> str:
    """Return a path without links, by which two names of one file are equal."""
    return os.path.realpath(path)


# --- Content --------------------------------------------------------------------------------------


def _merge(below: dict[str, Any], above: dict[str, Any], prefix: str, places: KeyPlaces) -> None:
    """Put a table into one below it, in place.

    Args:
        below: Table of the lower layers; changed.
        above: Table of the upper layer.
        prefix: Dotted key of both with a final dot; empty for a whole study.
        places: Places of the keys of the lower layers; those of replaced values are removed.
    """
    for name, value in above.items():
        key = f"{prefix}{name}"
        under = below.get(name)
        if isinstance(under, dict) and isinstance(value, dict) and _is_table(key):
            _merge(under, value, f"{key}.", places)
        else:
            below[name] = deepcopy(value)
            places.remove(key)


def _is_table(key: str) -> bool:
    """Return True if a dotted key holds a table of keys, rather than one value in braces."""
    part: type[Part] | None = Study
    for name in key.split("."):
        field = None if part is None else part.model_fields.get(name)
        if field is None:
            return False
        part = table_type(field)
    return part is not None
