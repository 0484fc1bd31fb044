"""A study from its file, with what the command line sets, or all its faults in one error."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import replace
from datetime import date, time
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from tendon_cli.errors import Fault, InputError, StudyError, TendonError, UsageError
from tendon_cli.files import path_of
from tendon_cli.space.axis import SPRING_AT, split_side
from tendon_cli.studies.attachments import Attachments
from tendon_cli.studies.checks import contradictions, curve_faults
from tendon_cli.studies.json_schema import faults_of
from tendon_cli.studies.spaces import impossibilities
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.study_file import STDIN, read_document
from tendon_cli.studies.toml_reading import (
    MAX_DEPTH,
    MAX_KEY_PARTS,
    Document,
    KeyPlaces,
    read_value,
)
from tendon_cli.units import described, shorten

AnyStudy: TypeAlias = str | PathLike[str] | Mapping[str, Any] | Study


def any_study(content: AnyStudy) -> Study:
    """A checked study from a dictionary with the keys of a study file, or from its path; raises as `load_study` does.

    Numbers may be NumPy's, lists may be ranges, arrays or Series, and a `Fit` may be a friction coefficient. Relative
    paths in it are relative to the working directory. `study.vary(**{"load.mass": "3 kg"})` is the same study with
    another value.

    >>> import tendon_cli as tendon
    >>> asked = tendon.study({"tendon": {"pretension": "120 N"}, "load": {"mass": range(0, 6, 5)}})
    >>> asked.tendon.pretension.array, asked.load.mass.array
    (array([120.]), array([0., 5.]))
    >>> asked.vary(**{"load.mass": "3 kg"}).axes
    ()
    """
    if isinstance(content, Study):
        return content
    if isinstance(content, str | PathLike):
        return load_study(content)
    if not isinstance(content, Mapping):
        raise StudyError(
            [
                Fault(
                    "",
                    f"{described(content)} is not a study, expected a path or a dictionary of keys",
                )
            ]
        )
    return study_from(plain(content))


def load_study(path: str | PathLike[str], settings: Iterable[str] = ()) -> Study:
    """Read and check a study file (TOML, or YAML by its ending; `-` is standard input), then apply settings KEY=VALUE.

    Raises StudyError with every fault, InputError for a file that it names and that cannot be trusted.

    >>> import tendon_cli as tendon
    >>> loaded = tendon.load_study("study.toml", ["load.mass=[0.0, 5.0]"])
    >>> loaded.axes
    ('load.mass',)
    """
    path, settings = path_of(path), (settings,) if isinstance(settings, str) else settings
    try:
        document = read_document(path)
        before = _axes_in_order(document)
        changed = [_apply(document.content, setting) for setting in settings]
        for key in changed:
            document.places.forget(key)
        document.content.setdefault("name", "study" if path == STDIN else path.stem)
        return study_from(
            document.content, document.places, folder=path.parent, order=(*before, *changed)
        )
    except TendonError as error:
        if error.where is None:
            error.where = "standard input" if path == STDIN else shorten(str(path), 1000)
        raise


def study_from(
    content: dict[str, Any],
    places: KeyPlaces | None = None,
    *,
    folder: Path = Path(),
    order: tuple[str, ...] = (),
) -> Study:
    """A checked study from a plain dictionary; files that it names are looked up in `folder`.

    `order` lists keys in the order in which their axes shall vary; keys that it leaves out follow as the content has
    them.
    """
    places = places or KeyPlaces()
    faults: list[Fault] = []
    study, invalid = _validated(_without_nothing(content, "", faults), places)
    faults += invalid
    files = Attachments(folder)
    if study is not None:
        faults += contradictions(study, {fault.key for fault in faults})
        try:
            study = files.resolve(study)
        except InputError:
            if not faults:
                raise
        faults += files.faults or (
            [] if faults else [*curve_faults(study), *impossibilities(study)]
        )
    if study is None or faults:
        placed = [replace(fault, line=fault.line or places.line_of(fault.key)) for fault in faults]
        raise StudyError(
            sorted(placed, key=lambda fault: 10**9 if fault.line is None else fault.line)
        )
    return study.ordered(tuple(dict.fromkeys((*order, *_number_keys(content)))), files.sources)


def plain(value: Any, path: tuple[str, ...] = ()) -> Any:
    """What a program gives for a study, as a file would have it; raises StudyError.

    NumPy's numbers become numbers; ranges, arrays and Series lists; a fitted friction coefficient its mean and error.
    """
    key = shorten(".".join(path), 120)
    if len(path) > MAX_DEPTH:
        raise StudyError(
            [Fault("", f"nested deeper than {MAX_DEPTH} levels", "a study needs no more than four")]
        )
    if isinstance(value, Mapping):
        odd = next((name for name in value if not isinstance(name, str)), None)
        if odd is not None:
            raise StudyError([Fault(key, f"{described(odd)} stands as a key, expected text")])
        return {name: plain(inner, (*path, name)) for name, inner in value.items()}
    if hasattr(value, "gain_ratio"):
        if value.friction is None:
            hint = "give fit_friction a bend_angle"
            raise StudyError(
                [Fault(key, "the fit has no bend angle, so no friction coefficient", hint)]
            )
        return {"mean": value.friction, "std": value.standard_error}
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, (list, tuple, range)):
        return [plain(item, (*path, str(at))) for at, item in enumerate(value)]
    if value is None or isinstance(value, (str, bool, int, float, date, time)):
        return value
    problem = (
        f"a {type(value).__name__} cannot stand here, expected text, a number, a list or a table"
    )
    raise StudyError([Fault(key, problem)])


def varied_study(study: Study, settings: Mapping[str, Any]) -> Study:
    """A study with other values at some dotted keys, new axes last; raises StudyError, UsageError."""
    content = study.document()
    for key, value in settings.items():
        _put(content, key.split("."), plain(value, (key,)))
    varied = study_from(content, order=(*study.axes, *settings))
    return varied.ordered(varied.axes, study.sources)


def recorded_study(record: Mapping[str, Any]) -> Study:
    """The study of a run or a table, from what these keep of it and without its files."""
    axes = tuple(record["axes"])
    return study_from(record["study"], order=axes).ordered(axes, record["sources"])


def _without_nothing(content: Any, path: str, faults: list[Fault]) -> Any:
    """The content without keys that have no value, as YAML allows: `faults`; numbers are left to their fields."""
    if isinstance(content, list):
        return [_without_nothing(item, f"{path}.{at}", faults) for at, item in enumerate(content)]
    if not isinstance(content, dict) or path in keys():
        return content
    inner = {f"{path}.{name}".removeprefix("."): (name, value) for name, value in content.items()}
    problem, hint = "has no value", "leave the key out, or give it a value"
    faults += [
        Fault(shorten(key, 120), problem, hint)
        for key, (_, value) in inner.items()
        if value is None
    ]
    return {
        name: _without_nothing(value, key, faults)
        for key, (name, value) in inner.items()
        if value is not None
    }


def _validated(content: dict[str, Any], places: KeyPlaces) -> tuple[Study | None, list[Fault]]:
    """The study, and the faults of its single keys; with faults, the study without the keys at fault if that is one."""
    faults: list[Fault] = []
    rest = deepcopy(content)
    while True:
        try:
            return Study.model_validate(rest), faults
        except ValidationError as error:
            faults = faults or faults_of(error, places)
            at_fault = [
                _innermost(rest, detail["loc"]) for detail in error.errors(include_url=False)
            ]
            for table, name in filter(None, at_fault):
                table.pop(name, None)
            if not any(at_fault):
                return None, faults


def _innermost(
    content: dict[str, Any], path: tuple[int | str, ...]
) -> tuple[dict[str, Any], Any] | None:
    """The table and the name of the key at a path, or of the last key on the way to it.

    An entry of a list is never taken by itself: without it, those after it would change their places.
    """
    table: Any = content
    place: tuple[dict[str, Any], Any] | None = None
    for part in path:
        if isinstance(table, dict) and part in table:
            place = table, part
        elif not (isinstance(table, list) and isinstance(part, int) and part < len(table)):
            break
        table = table[part]
    return place


def _axes_in_order(document: Document) -> list[str]:
    """Keys of the document that hold a list or a grid, in the order of its lines."""
    axes = [
        key
        for key, value in _number_keys(document.content).items()
        if isinstance(value, (list, dict))
    ]
    return sorted(axes, key=lambda key: document.places.line_of(key) or 0)


def _number_keys(content: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """What stands at each number key of a plain dictionary."""
    given: dict[str, Any] = {}
    for name, value in content.items():
        path = f"{prefix}{name}"
        if path in keys() or split_side(path)[0] == SPRING_AT:
            given[path] = value
        elif isinstance(value, dict):
            given |= _number_keys(value, f"{path}.")
    return given


def _apply(content: dict[str, Any], setting: str) -> str:
    """Put one `KEY=VALUE` into the content and return the key; raises UsageError or StudyError."""
    key, equals, text = setting.partition("=")
    parts = key.strip().split(".")
    if not equals or not all(parts) or len(parts) > MAX_KEY_PARTS:
        raise UsageError(
            f'--set "{shorten(setting)}" is not KEY=VALUE', hint="such as --set 'arm.b1=160 mm'"
        )
    key, text = shorten(key), text.strip()
    try:
        value = read_value(text) if text[:1] in ("[", "{", '"', "'") else text
    except StudyError as error:
        raise UsageError(
            f"--set {key}: {error.faults[0].problem}",
            hint='what starts with [, { or a quote is TOML, such as --set \'load.mass=["3 kg", "5 kg"]\'',
        ) from None
    _put(content, parts, value)
    return ".".join(parts)


def _put(content: dict[str, Any], path: list[str], value: Any) -> None:
    """Put a value at a dotted key into the content; raises UsageError below what is no table."""
    table: Any = content
    for part in path[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            key = shorten(".".join(path), 120)
            raise UsageError(f"{key}: {part} is not a table of keys", hint="set the whole value")
    table[path[-1]] = value
