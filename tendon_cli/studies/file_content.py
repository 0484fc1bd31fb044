"""Field that names a file, or holds what it held: in a record, or as a DataFrame of a program."""

from __future__ import annotations

import base64
import csv
import io
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema

from tendon_cli.studies.fields import FieldMark, fault
from tendon_cli.units import described

MAX_BYTES = 500_000_000
"""Largest size of a file of people, bytes."""
_LONGEST_NAME = 4096
_PACKED = "data:;base85,"
"""Beginning of a text that is the packed content of a file."""


@dataclass(frozen=True)
class FileContent:
    """Content of a file, in the place of its name."""

    packed: str
    """The content as text that a study can hold in the place of the name."""

    @classmethod
    def of(cls, content: bytes) -> FileContent:
        """Return the content of a file."""
        return cls(_PACKED + base64.b85encode(zlib.compress(content, 6)).decode("ascii"))

    @classmethod
    def of_columns(cls, columns: Mapping[str, Sequence[Any]]) -> FileContent:
        """Return the content of a CSV with these columns, by their headers."""
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        return cls.of(text.getvalue().encode())

    @property
    def content(self) -> bytes:
        """The content of the file.

        Raises:
            PydanticCustomError: `packed` is no packed content, or that of more than `MAX_BYTES`.
        """
        try:
            inflate = zlib.decompressobj()
            content = inflate.decompress(
                base64.b85decode(self.packed.removeprefix(_PACKED)), MAX_BYTES + 1
            )
        except (ValueError, zlib.error):
            raise fault("not the packed content of a file of people") from None
        if len(content) > MAX_BYTES or not inflate.eof:
            raise fault("is too large for a file of people, or was cut short")
        return content

    def document(self) -> str:
        """Return the content as a record has it."""
        return self.packed


@dataclass(frozen=True)
class FileField(FieldMark):
    """Mark of a field that names a file; a record, or a program, may give its content instead."""

    description: str
    """Meaning of the field, for the schema."""
    takes_columns: bool = False
    """True if a program may give the columns of a CSV."""

    def read(self, value: object) -> str | FileContent | None:
        """Return the name of a file as it is, and columns as the content of a file.

        Raises:
            PydanticCustomError: The value is neither.
        """
        if value is None or isinstance(value, FileContent):
            return value
        if isinstance(value, str) and value.startswith(_PACKED):
            packed = FileContent(value)
            packed.content  # noqa: B018 - refused here if it cannot be unpacked
            return packed
        if isinstance(value, str) and 0 < len(value) <= _LONGEST_NAME:
            return value
        expected = "the name of a file"
        if self.takes_columns:
            if isinstance(value, dict):
                lengths = {len(cells) if isinstance(cells, list) else 0 for cells in value.values()}
                if len(lengths) == 1 and 0 not in lengths:
                    return FileContent.of_columns(value)
            expected += ", or columns of one length"
        raise fault(f"{described(value)} is not possible, expected {expected}")

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"description": self.description, "type": "string", "minLength": 1}
