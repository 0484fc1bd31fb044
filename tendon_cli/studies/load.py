"""Read a study from its file and the command line, or raise all its faults in one error."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from copy import deepcopy
from datetime import date, time
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from tendon_cli.errors import Fault, InputError, StudyError, TendonError, UsageError
from tendon_cli.files import path_of
from tendon_cli.studies.attachments import Attachments
from tendon_cli.studies.checks import (
    anchor_faults,
    contradictions,
    curve_faults,
    implausible_faults,
    motion_faults,
    set_twice,
)
from tendon_cli.studies.json_schema import faults_of
from tendon_cli.studies.space.axis import PRETENSION, SPRING_AT, split_side
from tendon_cli.studies.spaces import impossibilities, with_readable_default
from tendon_cli.studies.study import EXTENDS, Study, keys
from tendon_cli.studies.study_file import STDIN, read_document, study_files
from tendon_cli.studies.study_layers import layer_sources, merge_layers, read_layers
from tendon_cli.studies.toml_reading import (
    MAX_DEPTH,
    MAX_KEY_PARTS,
    Document,
    KeyPlaces,
    read_value,
    refused,
)
from tendon_cli.units import described, shorten
from tendon_cli.version import RESULTS_VERSION

AnyStudy: TypeAlias = str | PathLike[str] | Mapping[str, Any] | Study
"""Study, its keys in a dictionary, or the path of its file."""

_ROWS = re.compile(r"table\.[0-9]+\.rows")
"""Path of the rows of a table, whose empty cells leave the value of the study."""
_MOST_FILES = 100
"""Most files of a folder that are read to find a study."""
_NO_LINE = 10**9
"""Place of a fault without a line, behind all others."""


def any_study(content: AnyStudy, settings: Iterable[str] = ()) -> Study:
    """Return a checked study from a dictionary with the keys of a study file, or from its path.

    A file is TOML, or YAML by its ending; `-` is standard input. Paths in it are relative to it,
    those in a dictionary to the working directory. Numbers of a dictionary may be NumPy's, lists
    may be ranges, arrays or Series, and a `Fit` may be a friction coefficient.
    `study.vary(**{"load.mass": "3 kg"})` is the same study with another value.

    Args:
        content: The dictionary, the path, or a study, which is returned as it is.
        settings: Settings KEY=VALUE above those of a dictionary or a file, as `--set` takes them.

    Raises:
        StudyError: The study has faults; all of them are listed.
        UsageError: A setting has no place in a study.
        InputError: A file that it names cannot be trusted.

    >>> import tendon_cli as tendon
    >>> asked = tendon.study({"tendon": {"pretension": "120 N"}, "load": {"mass": range(0, 6, 5)}})
    >>> asked.tendon.pretension.array, asked.load.mass.array
    (array([120.]), array([0., 5.]))
    >>> asked.vary(**{"load.mass": "3 kg"}).axes
    ()
    >>> tendon.study("study.toml", ["load.mass=[0.0, 5.0]"]).axes
    ('load.mass',)
    """
    settings = (settings,) if isinstance(settings, str) else tuple(settings)
    if isinstance(content, Study):
        if settings:
            hint = 'study.vary(**{"load.mass": "3 kg"}) gives it other values'
            raise UsageError("settings are for a dictionary or a file, not for a study", hint=hint)
        return content
    if isinstance(content, str | PathLike):
        return load_study(content, settings)
    if not isinstance(content, Mapping):
        raise refused(
            f"{described(content)} is not a study, expected a path or a dictionary of keys"
        )
    document = Document(plain_content(content), KeyPlaces())
    return _merged_study(document, settings=settings)


def load_study(path: str | PathLike[str], settings: Iterable[str] = ()) -> Study:
    """Read and check a study file, TOML or YAML, then apply settings KEY=VALUE.

    A study that extends another takes over what it does not state itself. Paths are relative to
    the file that names them.

    Args:
        path: The file, YAML by its ending, else TOML; `-` is standard input.
        settings: Settings as `--set` takes them.

    Raises:
        StudyError: The study has faults; all of them are listed.
        UsageError: A setting has no place in a study.
        InputError: A file that the study names cannot be trusted.
    """
    file = path_of(path)
    try:
        return _merged_study(read_document(file), file, tuple(settings))
    except TendonError as error:
        if error.where is None:
            error.where = "standard input" if file == STDIN else shorten(str(file), 1000)
        raise


def studies_in(folder: Path) -> list[Path]:
    """Return the files of a folder that have the keys of a study and no others."""

    def is_study(file: Path) -> bool:
        try:
            content = read_document(file).content
        except StudyError:
            return False
        return {key.partition(".")[0] for key in content} <= {*Study.model_fields}

    return [file for file in study_files(folder)[:_MOST_FILES] if is_study(file)]


def named_path(file: Path, settings: Iterable[str], key: str) -> Path:
    """Return the path of a file that a study names, as the study file or a setting gives it.

    Args:
        file: The study file, which can be loaded with the settings.
        settings: Settings as `--set` takes them.
        key: Dotted key that names the other file, such as "sheath.path".
    """
    _, document, _ = _read_merged(read_document(file), file, tuple(settings))
    value: Any = document.content
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return file.parent / document.places.folder_of(key) / str(value)


def _merged_study(
    document: Document, file: Path | None = None, settings: tuple[str, ...] = ()
) -> Study:
    """Return a checked study from its own content, what it extends, and settings above both.

    Args:
        document: The study's own content.
        file: Path of its file; None if it is no file.
        settings: Settings as `--set` takes them.

    Raises:
        StudyError: The study has faults; all of them are listed.
        UsageError: A setting has no place in a study.
        InputError: A file that it names cannot be trusted, and nothing else is wrong.
    """
    layers, merged, changed = _read_merged(document, file, settings)
    axes = [key for layer in layers for key in _axes_in_order(layer)]
    if file is not None:
        merged.content.setdefault("name", "study" if file == STDIN else file.stem)
    folder = Path() if file is None else file.parent
    return study_from(
        merged.content,
        merged.places,
        folder=folder,
        order=(*axes, *changed),
        settings=tuple(changed),
        sources=layer_sources(layers, file),
    )


def _read_merged(
    document: Document, file: Path | None, settings: tuple[str, ...]
) -> tuple[list[Document], Document, list[str]]:
    """Return the layers of a study, their content with all settings, and the keys of these.

    Arguments and errors are those of `_merged_study`. A setting may name another base; all others
    come last.
    """
    bases = [setting for setting in settings if setting.partition("=")[0].strip() == EXTENDS]
    for setting in bases:
        document.places.forget(_apply(document.content, setting))
    folder = Path() if file is None else file.parent
    layers = read_layers(document, file, folder)
    merged = merge_layers(layers)
    others = [setting for setting in settings if setting not in bases]
    changed = [_apply(merged.content, setting) for setting in others]
    for key in changed:
        merged.places.forget(key)
    return layers, merged, changed


def study_from(
    content: dict[str, Any],
    places: KeyPlaces | None = None,
    *,
    folder: Path = Path(),
    order: tuple[str, ...] = (),
    settings: tuple[str, ...] = (),
    sources: Mapping[str, dict[str, Any]] | None = None,
    is_recorded: bool = False,
) -> Study:
    """Return a checked study from a plain dictionary, whose base is merged into it already.

    Args:
        content: The keys of a study file.
        places: Places of the keys in their files, for errors and paths.
        folder: Folder of the study; files are looked up in it, or in that of the base that names
            them.
        order: Keys in the order in which their axes shall vary; keys that it leaves out follow in
            the order of the content.
        settings: Keys that the command line sets, or `vary`; no table may set them, too.
        sources: Name and hash of the files of the study itself, by the key that names each.
        is_recorded: True for the study of a record. An answer sets suits by a gauge that the study
            may not name, and its own pretension, which the answer does not use, need not be one
            that this gauge can show.

    Raises:
        StudyError: The study has faults; all of them are listed, by line.
        InputError: A file that it names cannot be trusted, and nothing else is wrong.
    """
    places = places or KeyPlaces()
    faults: list[Fault] = []
    study, invalid = _validated(_without_empty_keys(content, "", faults), places)
    faults += invalid
    accepts_slips = study is not None and study.allow_implausible
    files = Attachments(folder, accepts_slips=accepts_slips, places=places)
    if study is not None:
        study = files.with_tables(study)
        faults += contradictions(study, {fault.key for fault in (*faults, *files.faults)})
        try:
            study = files.resolve(study)
        except InputError:
            judged = (*implausible_faults(study), *anchor_faults(study, set()))
            if not (faults or files.faults or judged):
                raise
        faults += files.faults
        faults += anchor_faults(study, {fault.key for fault in faults})
        faults += set_twice(study, places, settings)
        faults += implausible_faults(study, files.sources)
        if not faults:
            faults += curve_faults(study)
            study = with_readable_default(study)
            impossible = impossibilities(study)
            faults += [one for one in impossible if not (is_recorded and one.key == PRETENSION)]
    if faults and all(fault.is_of_file for fault in faults):
        raise _input_error(faults)
    if study is None or faults:
        placed = [places.placed(fault) for fault in faults]
        placed.sort(key=lambda one: (one.file or "", _NO_LINE if one.line is None else one.line))
        raise StudyError(placed)
    axes = tuple(dict.fromkeys((*order, *_number_keys(content))))
    return study.ordered(axes, {**(sources or {}), **files.sources})


def _input_error(faults: list[Fault]) -> InputError:
    """Return the error of a study whose only faults stand in its tables of rows."""
    if len(faults) == 1:
        fault = faults[0]
        return InputError(fault.problem, where=fault.key, hint=fault.hint)
    listed = "\n".join(f"  {fault}" for fault in faults)
    return InputError(f"its rows have {len(faults):,} faults:\n{listed}")


def varied_study(study: Study, settings: Mapping[str, Any]) -> Study:
    """Return a study with other values at some dotted keys; its new axes vary fastest.

    Raises:
        StudyError: The study with these values has faults; all of them are listed.
        UsageError: A setting has no place in a study.
    """
    if EXTENDS in settings:
        hint = 'tendon.study(path, ["extends=other.toml"]) reads it with another base'
        raise UsageError("a study that has been read cannot extend another", hint=hint)
    content = study.document()
    # A default that is written out would count as stated, for persons who are added or a gauge.
    stated = study.arm.model_fields_set
    content["arm"] = {name: value for name, value in content["arm"].items() if name in stated}
    if "pretension" not in study.tendon.model_fields_set:
        del content["tendon"]["pretension"]
    for key, value in settings.items():
        _put(content, key.split("."), plain_content(value, (key,)))
    varied = study_from(content, order=(*study.axes, *settings), settings=tuple(settings))
    return varied.ordered(varied.axes, study.sources)


def recorded_study(record: Mapping[str, Any], version: object = RESULTS_VERSION) -> Study:
    """Return the study of a run or a table from its `Study.record`, without its files.

    Types, sizes and bounds are checked as in any file. That its keys do not contradict one another,
    and that its numbers are plausible, was judged when this version computed it; a record of
    another version is judged again.

    Args:
        record: The record.
        version: Version of the results that it was written with.

    Raises:
        StudyError: It is not as tendon writes it.
    """
    axes = tuple(record["axes"])
    content = {"allow_implausible": True, **record["study"]}
    if version != RESULTS_VERSION:
        judged = study_from(content, order=axes, is_recorded=True)
        return judged.ordered(axes, record["sources"])
    study, faults = _validated(content, KeyPlaces())
    if study is not None and (study.table or study.cases is not None):
        files = Attachments(Path(), accepts_slips=True)
        study = files.with_tables(study)
        faults += files.faults
    if study is not None and study.motion.trajectory is not None:
        faults += motion_faults(study)
    if study is None or faults:
        raise StudyError(faults)
    return study.ordered(axes, record["sources"])


# --- Content of a program or a file --------------------------------------------------------------


def plain_content(value: Any, path: tuple[str, ...] = ()) -> Any:
    """Return a value of a program as a study file would have it.

    NumPy's numbers become numbers; ranges, arrays and Series become lists; a fitted friction
    coefficient becomes its mean and standard error.

    Args:
        value: The value, or a study's whole content.
        path: Keys that lead to it, for errors.

    Raises:
        StudyError: A study file cannot have the value.
    """
    if value is None or isinstance(value, (str, bool, int, float, date, time)):
        return value
    key = shorten(".".join(path), 120)
    if len(path) > MAX_DEPTH:
        raise refused(f"nested deeper than {MAX_DEPTH} levels", "a study needs no more than four")
    is_fit = hasattr(value, "gain_ratio")
    if is_fit:
        if value.friction is None:
            problem = "the fit has no bend angle, so no friction coefficient"
            raise refused(problem, "give fit_friction a bend_angle", key=key)
        return {"mean": value.friction, "std": value.standard_error}
    is_frame = hasattr(value, "to_dict") and hasattr(value, "columns")
    if is_frame:
        value = _columns_of_frame(value)
    if hasattr(value, "tolist"):
        return plain_content(value.tolist(), path)
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                raise refused(f"{described(name)} is used as a key, expected text", key=key)
        return {name: plain_content(inner, (*path, name)) for name, inner in value.items()}
    if isinstance(value, (list, tuple, range)):
        return [plain_content(item, (*path, str(at))) for at, item in enumerate(value)]
    expected = "expected text, a number, a list or a table"
    raise refused(f"a {type(value).__name__} is not possible here, {expected}", key=key)


def _columns_of_frame(frame: Any) -> dict[str, list[Any]]:
    """Return the columns of a DataFrame as lists, in which a missing value is None.

    An index that is more than a count has the names of the rows, unless a column has.
    """
    columns = {
        str(name): values.astype(object).where(values.notna(), None).tolist()
        for name, values in frame.items()
    }
    is_count = type(frame.index).__name__ == "RangeIndex"
    if "name" not in columns and not is_count:
        columns = {"name": list(map(str, frame.index)), **columns}
    return columns


def _without_empty_keys(content: Any, path: str, faults: list[Fault]) -> Any:
    """Return content without keys that have no value, as YAML allows; add a fault for each.

    Numbers are left as they are: their fields check them.
    """
    if _ROWS.fullmatch(path):
        return content
    if isinstance(content, list):
        return [
            _without_empty_keys(item, f"{path}.{at}", faults) for at, item in enumerate(content)
        ]
    if not isinstance(content, dict) or path in keys():
        return content
    paths = {name: f"{path}.{name}".removeprefix(".") for name in content}
    for name, value in content.items():
        if value is None:
            hint = "leave the key out, or give it a value"
            faults.append(Fault(shorten(paths[name], 120), "has no value", hint))
    return {
        name: _without_empty_keys(value, paths[name], faults)
        for name, value in content.items()
        if value is not None
    }


def _number_keys(content: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the values at the keys of numbers, and of places of springs, by dotted key."""
    given: dict[str, Any] = {}
    for name, value in content.items():
        path = f"{prefix}{name}"
        if path in keys() or split_side(path)[0] == SPRING_AT:
            given[path] = value
        elif isinstance(value, dict):
            given |= _number_keys(value, f"{path}.")
    return given


def _axes_in_order(document: Document) -> list[str]:
    """Return the keys of a document that hold a list or a grid, in the order of its lines."""
    axes = [
        key
        for key, value in _number_keys(document.content).items()
        if isinstance(value, (list, dict))
    ]
    return sorted(axes, key=lambda key: document.places.line_of(key) or 0)


# --- Validation ----------------------------------------------------------------------------------


def _validated(content: dict[str, Any], places: KeyPlaces) -> tuple[Study | None, list[Fault]]:
    """Return the study of some content, and the faults of its single keys.

    With faults the study is that of the content without the keys at fault, so that its other keys
    can be checked; it is None if even that is no study.
    """
    faults: list[Fault] = []
    rest = content
    while True:
        try:
            return Study.model_validate(rest), faults
        except ValidationError as error:
            if not faults:
                faults = faults_of(error, places, has_tables=bool(content.get("table")))
                rest = deepcopy(content)
            details = error.errors(include_url=False)
            at_fault = [_innermost(rest, detail["loc"]) for detail in details]
            found = [place for place in at_fault if place is not None]
            for table, name in found:
                table.pop(name, None)
            if not found:
                return None, faults


def _innermost(
    content: dict[str, Any], path: tuple[int | str, ...]
) -> tuple[dict[str, Any], Any] | None:
    """Return the table and the name of the key at a path, or of the last key on the way to it.

    An entry of a list is never taken by itself: without it, those after it would change their
    places.
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


# --- Settings ------------------------------------------------------------------------------------


def _apply(content: dict[str, Any], setting: str) -> str:
    """Put one `KEY=VALUE` into the content and return the key.

    Raises:
        UsageError: The setting has no such form, or its key has no place in the content.
        StudyError: The key cannot be read.
    """
    key, equals, text = setting.partition("=")
    parts = key.strip().split(".")
    if not equals or not all(parts) or len(parts) > MAX_KEY_PARTS:
        problem = f'--set "{shorten(setting)}" is not KEY=VALUE'
        raise UsageError(problem, hint="such as --set 'arm.b1=160 mm'")
    text = text.strip()
    is_toml = text.startswith(("[", "{", '"', "'"))
    try:
        value = read_value(text) if is_toml else text
    except StudyError as error:
        example = """--set 'load.mass=["3 kg", "5 kg"]'"""
        raise UsageError(
            f"--set {shorten(key)}: {error.faults[0].problem}",
            hint=f"a value that starts with [, {{ or a quote is read as TOML, such as {example}",
        ) from None
    _put(content, parts, value)
    return ".".join(parts)


def _put(content: dict[str, Any], path: list[str], value: Any) -> None:
    """Put a value at a dotted key into the content.

    Raises:
        UsageError: A part of the key is not a table.
    """
    table: Any = content
    for part in path[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            key = shorten(".".join(path), 120)
            raise UsageError(f"{key}: {part} is not a table of keys", hint="set the whole value")
    table[path[-1]] = value
