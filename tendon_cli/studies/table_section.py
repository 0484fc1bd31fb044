"""Section `[[table]]` of a study: an axis of rows from a CSV, from the study, or from a sample."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    GetJsonSchemaHandler,
    TypeAdapter,
    WithJsonSchema,
    create_model,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError

from tendon_cli.errors import Fault
from tendon_cli.studies.contents import DESIGN_PARTS, keys
from tendon_cli.studies.design_section import Seed
from tendon_cli.studies.fields import FieldMark, fault, fault_inside, hint_at_nearest, whole_number
from tendon_cli.studies.gone import IS_GONE, instead_of
from tendon_cli.studies.parts import FileName, Part, field_default
from tendon_cli.studies.row_reading import flat_keys, known_columns, row_keys
from tendon_cli.studies.row_table import NAME, RowTable, StatedRole
from tendon_cli.studies.values import StudyNumber, Uncertain, sample_numbers
from tendon_cli.units import described, shorten

MOST_ROWS = 10**6
"""Largest number of rows of a table."""
MAX_BYTES = 2**28
"""Size of the largest CSV of rows."""
_SAMPLERS = {
    "sobol": "scrambled Sobol points",
    "latin-hypercube": "points of a Latin hypercube",
    "random": "random points",
}
"""Ways to draw a sample, in words."""

_NAME = r"^[A-Za-z_][A-Za-z0-9_]{0,63}$"


def _read_name(value: object) -> str | None:
    """Return the name of a table; refuse any that cannot be the beginning of a column's."""
    if value is None:
        return None
    if not isinstance(value, str) or not re.match(_NAME, value):
        problem = f"{described(value)} is not a name for a table, expected letters, digits and _"
        raise fault(problem, "such as spring")
    return value


TableName = Annotated[
    str | None,
    BeforeValidator(_read_name),
    WithJsonSchema({"type": "string", "pattern": _NAME}),
]


@dataclass(frozen=True)
class RowsField(FieldMark):
    """Mark of a field that holds rows: a list of tables, or a table of columns."""

    def read(self, value: object) -> Any:
        """Return rows as they are; what stands in them is read with those of files.

        A record has columns as lists, each with its header first.

        Raises:
            PydanticCustomError: The value is neither rows nor columns.
        """
        if value is None:
            return None
        if isinstance(value, dict):
            return _checked_columns(value)
        if not isinstance(value, (list, tuple)):
            raise fault(f"{described(value)} is not a list of rows, expected rows in braces")
        if not value:
            raise fault("an empty list, expected at least one row")
        if all(isinstance(column, list) and column for column in value):
            return _checked_columns({column[0]: column[1:] for column in value})
        for at, row in enumerate(value):
            if not isinstance(row, dict):
                hint = 'such as { name = "P1", "spring.stiffness" = "1.5 kN/m" }'
                raise fault(f"row {at + 1}: {described(row)}, expected keys in braces", hint)
        return tuple(value)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        cell = {"type": ["string", "number", "boolean", "null", "object"]}
        row = {
            "type": "object",
            "properties": {NAME: {"type": ["string", "number"], "description": "name of the row"}},
            "additionalProperties": cell,
        }
        columns = {
            "type": "object",
            "additionalProperties": {"type": "array", "items": cell},
        }
        return {
            "description": "the rows, or for programs a list for each header: a name, keys of the "
            "study, quoted, with a unit in brackets or in each cell, and other columns",
            "anyOf": [{"type": "array", "items": row, "minItems": 1}, columns],
        }


def _checked_columns(columns: dict[Any, Any]) -> dict[Any, Any]:
    """Return columns by their headers; refuse any that are not lists of one length."""
    lengths = set()
    for header, cells in columns.items():
        if not isinstance(cells, (list, tuple)):
            problem = f"{described(cells)} is not a column, expected a list of cells"
            hint = "in TOML, each row of cases starts with [[cases]]"
            raise fault_inside(shorten(str(header)), fault(problem, hint))
        lengths.add(len(cells))
    if len(lengths) > 1:
        listed = " and ".join(f"{length:,}" for length in sorted(lengths))
        raise fault(f"columns of {listed} cells, expected the same number in all")
    if not lengths or not max(lengths):
        raise fault("holds no rows, expected at least one")
    return columns


class CasesField(RowsField):
    """Mark of `[[cases]]`: the rows of the table `case`, which may be none."""

    def read(self, value: object) -> Any:
        """Return rows as `RowsField` does; None for an empty list."""
        return None if value == [] else super().read(value)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        parts: dict[str, Any] = {key: (part | None, None) for key, part in DESIGN_PARTS.items()}
        parts["name"] = (str, field_default(description="name of the case, different for each"))
        case = create_model("Case", __base__=Part, **parts)
        return handler(TypeAdapter(list[case]).core_schema)  # type: ignore[valid-type]


@dataclass(frozen=True)
class _BetweenField(FieldMark):
    """Mark of a field that holds the numbers of a sample: a distribution for each key."""

    def read(self, value: object) -> Any:
        """Return the uncertain number of each dotted key.

        Raises:
            PydanticCustomError: A key is unknown, or has no distribution.
        """
        if value is None:
            return None
        if not isinstance(value, dict) or not value:
            hint = 'such as { "spring.stiffness" = "1 kN/m to 8 kN/m" }'
            raise fault(f"{described(value)} is not a table, expected a range for each key", hint)
        numbers: dict[str, StudyNumber] = {}
        for key, stated in flat_keys(value):
            instead = instead_of(key.split("."))
            if instead is not None:
                raise fault_inside(key, fault(IS_GONE, instead))
            if key in row_keys() and key not in keys():
                problem = "is a choice of words, which has no range; rows of a table take it"
                raise fault_inside(key, fault(problem))
            if key not in row_keys():
                near = hint_at_nearest(key, row_keys(), cutoff=0.6)
                raise fault_inside(shorten(key), fault("unknown key", near))
            try:
                number = keys()[key].number.read(stated)
            except PydanticCustomError as error:
                raise fault_inside(key, error) from None
            if number is None or number.uncertain is None:
                given = described(stated)
                hint = 'such as "0.4 to 1.0", or "0.07 +/- 0.02"'
                problem = f"{given} is neither a range nor a distribution"
                raise fault_inside(key, fault(problem, hint))
            numbers[key] = number
        return numbers

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        number = {"type": ["string", "object"]}
        return {
            "description": 'range or distribution of each number: "1 kN/m to 8 kN/m", '
            '"0.07 +/- 0.02"',
            "type": "object",
            "additionalProperties": number,
            "minProperties": 1,
        }


class TableSection(Part):
    """Table of rows, each of which sets several numbers of the study together."""

    name: TableName = field_default(
        None, description="name of the axis, and of the column that says which row"
    )
    role: StatedRole | None = field_default(
        None,
        description="what the rows are: choices, conditions that a design must survive, or draws "
        "of which a share is enough; default: condition if all keys are those of conditions",
    )
    file: FileName | None = field_default(
        None, description="a CSV with a column name, and keys of the study with units as headers"
    )
    rows: Annotated[Any, RowsField()] = None
    sample: Literal["sobol", "latin-hypercube", "random"] | None = field_default(
        None, description="rows that are drawn between bounds, the same on every machine"
    )
    count: Annotated[int, *whole_number(1, MOST_ROWS)] | None = field_default(
        None, description="number of rows of the sample"
    )
    seed: Seed | None = field_default(
        None, description="the same seed draws the same rows; default 1"
    )
    between: Annotated[Any, _BetweenField()] = None

    @model_validator(mode="before")
    @classmethod
    def _columns_as_rows(cls, content: Any) -> Any:
        """Take the columns of a DataFrame, which may stand in the place of a file, as rows."""
        if not isinstance(content, dict) or not isinstance(content.get("file"), dict):
            return content
        others = {name: value for name, value in content.items() if name != "file"}
        return {"rows": content["file"], **others}

    def contradictions(self, at: int) -> Iterator[Fault]:
        """Yield a fault for each key that contradicts another, or lacks one.

        Args:
            at: Place of the table in the study, from 0.
        """
        place = f"table.{at}"
        if self.name is None:
            yield Fault(f"{place}.name", "is missing, a table needs it", "such as spring")
        elif self.name in known_columns():
            problem = f'"{self.name}" is a column of the tables of every study'
            yield Fault(f"{place}.name", problem, f'such as "{self.name}s" or "part"')
        given = [name for name in ("file", "rows", "sample") if getattr(self, name) is not None]
        if not given:
            problem = "the table has no rows"
            hint = 'add file = "springs.csv", rows = [...] or sample = "sobol"'
            yield Fault(place, problem, hint)
        elif len(given) > 1:
            yield Fault(f"{place}.{given[1]}", f"cannot be given with {given[0]}", "leave one out")
        if self.sample is None:
            for name in ("count", "seed", "between"):
                if getattr(self, name) is not None:
                    problem = "belongs to a sample, but this table has none"
                    yield Fault(f"{place}.{name}", problem, 'add sample = "sobol"')
            return
        if self.count is None:
            yield Fault(f"{place}.count", "is missing, a sample needs it", "such as 512")
        if self.between is None:
            problem = "is missing, a sample needs it"
            yield Fault(f"{place}.between", problem, '{ "spring.stiffness" = "1 kN/m to 8 kN/m" }')

    # --- Rows ------------------------------------------------------------------------------------

    def sampled(self, at: int) -> RowTable:
        """Return the table of a sample.

        Args:
            at: Place of the table in the study, from 0.
        """
        known: dict[str, Uncertain] = {
            key: number.uncertain
            for key, number in sorted(self.between.items())
            if number.uncertain
        }
        count = self.count or 1
        numbers = sample_numbers(known, self.sample or "sobol", count, self._seed)
        readings = {
            key: number.dimension for key, number in self.between.items() if number.dimension
        }
        where = f"table.{at}"
        slips = tuple(slip for number in self.between.values() for slip in number.slips)
        name = self.name or ""
        return RowTable(
            name,
            name,
            numbers,
            tuple(map(str, range(1, count + 1))),
            stated_role=self.role,
            readings=readings,
            slips={where: slips} if slips else {},
            where=where,
        )

    @property
    def _seed(self) -> int:
        return 1 if self.seed is None else self.seed

    @property
    def sample_facts(self) -> dict[str, Any]:
        """Facts on the sample for the record, with a sentence, its `note`."""
        kind = _SAMPLERS[self.sample or "sobol"]
        count = self.count or 1
        note = (
            f"table {self.name}: {count:,} {kind} of {', '.join(self.between)}, seed {self._seed}"
        )
        if self.sample == "sobol" and count.bit_count() > 1:
            note += f"; {1 << count.bit_length()} would fill the space more evenly"
        between = {
            key: number.document(keys()[key].number.quantity.dimension)
            for key, number in self.between.items()
        }
        return {
            "sample": self.sample,
            "count": count,
            "seed": self._seed,
            "between": between,
            "note": note,
        }
