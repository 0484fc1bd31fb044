"""The words that complete an option: those of tendon, and those of the tables and studies that the line names."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tendon_cli.errors import TendonError

if TYPE_CHECKING:
    from tendon_cli.cube.rows import TableRows

Words = Iterable[tuple[str, str]]
"""Words that may stand there, each with what it means."""

_RELATION = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(?:<=|>=|!=|==|=|<|>|\bin\b)\s*(?:.*,\s*)?")
_MOST_VALUES = 50
_MOST_STRETCHES = 16
_MOST_NAMES = 1000


@dataclass(frozen=True)
class Given:
    """What a line says before the word that is completed."""

    source: str = ""
    """The command's first argument: a run, a table or a study."""
    options: Mapping[str, str] = field(default_factory=dict)
    begun: str = ""

    def asking(self, begun: str) -> "Given":
        """The same with the word that is begun."""
        return replace(self, begun=begun)


def _settings(_line: Given) -> Words:
    """Every key of a study with `=`, and with each of its values where these are few words."""
    from tendon_cli.studies.schema import key_words

    for key, (meaning, values) in key_words().items():
        yield f"{key}=", meaning
        yield from ((f"{key}={value}", meaning) for value in values)


def _keys(_line: Given) -> Words:
    from tendon_cli.studies.study import keys

    return [(path, key.number.quantity.long_name) for path, key in keys().items()]


def _columns(line: Given) -> Words:
    """Columns of the table that the line names, else every column that a table of tendon may have."""
    rows = _rows(line)
    if rows is None:
        return _any_columns()
    schema = rows.table.schema
    return [
        (name, (schema.field(name).metadata or {}).get(b"long_name", b"").decode())
        for name in schema.names
        if name.isprintable()
    ]


def _any_columns() -> Words:
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys

    found = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    return (found | {key.column: key.number.quantity.long_name for key in keys().values()}).items()


def _filters(line: Given) -> Words:
    """Columns, and after a relation the values that the column has."""
    match = _RELATION.match(line.begun)
    rows = _rows(line)
    if match is None or rows is None:
        return _columns(line)
    return [(match[0] + value, "") for value in _values_of(rows, match[1])]


def _values_of(rows: "TableRows", name: str) -> list[str]:
    """What a column holds, as a filter takes it, where these are few values."""
    from tendon_cli.units import UNITS, factor_of

    try:
        column = rows.of.find(name, "--where")
    except TendonError:
        return []
    found: dict[Any, None] = {}
    for stretch in islice(rows.table.stretches([column]), _MOST_STRETCHES):
        found |= dict.fromkeys(stretch[column].unique().drop_null().to_pylist())
        if len(found) > _MOST_VALUES:
            return []
    quantity = rows.of.held[column]
    if quantity is None:
        words = [str(value).lower() if isinstance(value, bool) else str(value) for value in found]
        return [word for word in words if word.isprintable()]
    if quantity.shown_in not in UNITS:
        return [f"{value:.6g}" for value in found]
    factor = factor_of(quantity.shown_in)
    return [f"{value / factor:.6g} {quantity.shown_in}".removesuffix(" 1") for value in found]


def _rows(line: Given) -> "TableRows | None":
    """The table that the line names, unverified; None where there is none."""
    if not line.source:
        return None
    from tendon_cli.cube.rows import TableRows
    from tendon_cli.cube.source import file_of, table_in
    from tendon_cli.tables.read import TableFiles

    try:
        path = Path(line.source)
        if path.suffix.lower() == ".csv":
            return TableRows(table_in(path))
        file = file_of(path, line.options.get("table"))
        files = sorted(file.glob("part-*.parquet")) if file.is_dir() else [file]
        if not all(each.is_file() for each in files):  # a pipe would be waited for
            return None
        rows = TableRows(TableFiles(tuple(files)))
        rows.table.schema  # noqa: B018 - what cannot be read is found here
    except (TendonError, OSError, ValueError, IndexError):  # an error of Arrow is a ValueError or an OSError
        return None
    return rows


def _units(_line: Given) -> Words:
    from tendon_cli.units import UNITS

    return [(unit.symbol, unit.dimension) for unit in UNITS.values()]


def _templates(_line: Given) -> Words:
    from tendon_cli.studies.starter import TEMPLATES

    return TEMPLATES.items()


def _tables(line: Given) -> Words:
    """The tables of the folder that the line names, else all that there may be."""
    from tendon_cli.cube.source import TABLES

    found = [name for name in TABLES if line.source and (Path(line.source) / f"{name}.parquet").exists()]
    return [(name, "") for name in found or TABLES]


def _cases(line: Given) -> Words:
    study = _study(line)
    return [(case.name, "") for case in study.cases] if study is not None else []


def _persons(line: Given) -> Words:
    """Those of every survey, and those of the study that the line names."""
    from tendon_cli.studies.people.population import NAMED

    study = _study(line)
    names = study.people.population.names if study is not None and study.people is not None else ()
    return [(name, "") for name in (*NAMED, *names[:_MOST_NAMES]) if name.isprintable()]


def _study(line: Given) -> Any:
    """The study that the line names; None where it cannot be read."""
    if line.source in ("", "-"):
        return None
    from tendon_cli.studies.load import load_study

    try:
        return load_study(Path(line.source))
    except TendonError:
        return None


KNOWN: dict[str, Callable[[Given], Words]] = {
    "settings": _settings,
    "apart": _keys,
    **dict.fromkeys(("columns", "quantity", "x", "colour", "panels", "sort"), _columns),
    "where": _filters,
    "template": _templates,
    "unit": _units,
    "table": _tables,
    "case": _cases,
    "person": _persons,
    "size": lambda _line: [("column", "85 mm"), ("page", "175 mm")],
}
"""By the name of a parameter, the words that complete it."""
