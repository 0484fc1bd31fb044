"""Layers of a study: its own file and, by `extends`, the file below it, and so on.

Tables merge; a list, a number or any other value of an upper layer replaces that of a lower one.
The name of a study is its own: a lower layer does not give it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from tendon_cli.errors import StudyError, UsageError
from tendon_cli.files import path_of
from tendon_cli.studies.contents import fields_in
from tendon_cli.studies.study import EXTENDS, Study
from tendon_cli.studies.study_file import STDIN, read_document
from tendon_cli.studies.toml_reading import Document, KeyPlaces, refused, shown
from tendon_cli.units import shorten

MAX_LAYERS = 16
"""Largest number of files of which a study is made."""
_OWN_KEYS = ("name", EXTENDS)
"""Keys that an upper layer does not take over from a lower one."""


def read_layers(document: Document, own: Path | None, folder: Path) -> list[Document]:
    """Return the layers of a study, the lowest first and the study's own last.

    Args:
        document: Content of the study's own file.
        own: Path of this file; None if the study is no file.
        folder: Folder of the study.

    Raises:
        StudyError: A lower layer is missing or cannot be read, or a file extends itself.
    """
    layers = [document]
    names = ["this study" if own is None or own == STDIN else own.name]
    identities = [] if own is None or own == STDIN else [os.path.realpath(own)]
    while True:
        top = layers[0]
        named = top.content.get(EXTENDS)
        if not isinstance(named, str) or not named:
            return layers
        base = Path(named) if top.file is None else top.file.parent / named
        try:
            layer = _read_base(base, named, top, folder)
            identity = os.path.realpath(folder / base)  # by which two names of one file are equal
            names.append(base.name)
            if identity in identities:
                chain = " extends ".join(map(shorten, names))
                raise _fault_of(top, f"a study cannot extend itself: {chain}")
            if len(layers) == MAX_LAYERS:
                raise _fault_of(top, f"more than {MAX_LAYERS} files extend one another")
        except StudyError as error:
            stated_in = None if top.file is None else shown(top.file)
            faults = [
                fault if fault.file else replace(fault, file=stated_in) for fault in error.faults
            ]
            raise StudyError(faults) from None
        identities.append(identity)
        layers.insert(0, layer)


def _read_base(file: Path, named: str, above: Document, folder: Path) -> Document:
    """Return the layer below another.

    Args:
        file: Path of its file, from the folder of the study.
        named: Name of the file, as the layer above states it.
        above: Layer that names it.
        folder: Folder of the study.

    Raises:
        StudyError: It cannot be read, or is no study.
    """
    path = folder / file
    if path == STDIN:
        raise _fault_of(above, "standard input cannot be extended, expected the name of a file")
    try:
        document = read_document(path_of(path))
    except UsageError as error:
        raise _fault_of(above, f'"{shorten(named)}": {error.message}', error.hint) from None
    except StudyError as error:
        fault = error.faults[0]
        is_about_content = fault.line is not None or fault.key
        if is_about_content:
            raise StudyError([replace(fault, file=shown(file))]) from None
        raise _fault_of(above, f'"{shorten(named)}": {fault.problem}', fault.hint) from None
    places = KeyPlaces({key: (place[0], file) for key, place in document.places.places.items()})
    return replace(document, places=places, file=file)


def _fault_of(layer: Document, problem: str, hint: str | None = None) -> StudyError:
    """Return the error for a layer that cannot extend what it names."""
    return refused(problem, hint, layer.places.line_of(EXTENDS), EXTENDS)


def merge_layers(layers: Sequence[Document]) -> Document:
    """Return the content of all layers as one, with the place of every key."""
    content: dict[str, Any] = {}
    places = KeyPlaces()
    for layer in layers:
        for key in _OWN_KEYS:
            content.pop(key, None)
            places.remove(key)
        _merge(content, layer.content, "", places)
        places.places |= layer.places.places
    return Document(content, places)


def layer_sources(layers: Sequence[Document], own: Path | None) -> dict[str, dict[str, Any]]:
    """Return name and hash of the files of a study, by the key that names each.

    There are none if the study extends no other. The study's own file stands under "study", if it
    is one; the base of its base under "extends.extends".

    Args:
        layers: Layers of the study, the lowest first.
        own: Path of the study's own file; None if it is no file.
    """
    *lower, top = layers
    sources: dict[str, dict[str, Any]] = {}
    if lower and own is not None and top.sha256:
        name = "standard input" if own == STDIN else own.name
        sources["study"] = {"file": name, "sha256": top.sha256}
    key = EXTENDS
    for layer in reversed(lower):
        sources[key] = {"file": (layer.file or Path()).name, "sha256": layer.sha256}
        key = f"{key}.{EXTENDS}"
    return sources


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
        if (
            isinstance(under, dict)
            and isinstance(value, dict)
            and isinstance(fields_in(Study).get(key), type)
        ):
            _merge(under, value, f"{key}.", places)
        else:
            below[name] = deepcopy(value)
            places.remove(key)
