"""A CSV file as lines, cells and columns of text: comma, semicolon or tab between cells, lines of comments left out."""

from __future__ import annotations

import csv
import re
from typing import Any

from tendon_cli.errors import InputError

SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma"}
"""In this order: a comma is believed last, since in a file separated by semicolons or tabs it is the decimal sign."""
LONGEST_LINE = 64 * 2**10
_COMMENT = ("#", "%", "//", "*")
_AS_CSV = "save it as CSV in UTF-8 or UTF-16"
_CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f-\x9f]")
"""Signs that no Latin-1 text has."""


def lines_of(content: bytes, source: str) -> list[str]:
    """The lines of a text in UTF-8, UTF-16 with its mark, or Latin-1, the first of which is line 1; no line ends."""
    if not content.strip(b" \t\r\n\0\xef\xbb\xbf\xff\xfe"):
        raise InputError("the file is empty", where=source)
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        raise InputError("the file is in UTF-32", where=source, hint=_AS_CSV)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        hint = 'in the spreadsheet: "Save as", then the type "CSV UTF-8"'
        raise InputError("is a workbook of a spreadsheet, not text", where=source, hint=hint)
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in content and not wide:
        line = content.count(b"\n", 0, content.index(b"\0")) + 1
        raise InputError(
            "a zero byte: this is not text", where=f"{source}, line {line}", hint=_AS_CSV
        )
    encoding = "utf-16" if wide else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        if wide or _CONTROL.search(content):
            line = content[: error.start].decode(encoding, errors="ignore").count("\n") + 1
            problem = f"bytes that are not {'UTF-16' if wide else 'UTF-8'} text"
            raise InputError(problem, where=f"{source}, line {line}", hint=_AS_CSV) from None
        text = content.decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if max(map(len, lines)) > LONGEST_LINE:
        long = next(
            number for number, line in enumerate(lines, start=1) if len(line) > LONGEST_LINE
        )
        raise InputError(
            f"a line of more than {LONGEST_LINE} characters", where=f"{source}, line {long}"
        )
    return lines


def is_comment(line: str) -> bool:
    """Whether a line is empty or begins with a comment sign (a footnote's asterisk included)."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t",;') or text.startswith(_COMMENT)


def cells_of(line: str, separator: str, place: str) -> list[str]:
    """The cells of one line, quotes removed; a quoted cell may not run over the end of the line."""
    try:
        cells = next(
            csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t", strict=True)
        )
    except csv.Error as error:
        raise InputError(
            f"not a row of CSV: {error}", where=place, hint="check the quotes in this line"
        ) from error
    return [cell.strip() for cell in cells]


def texts_of(
    lines: list[str], kept: list[int], separator: str, source: str, width: int, needed: int
) -> list[Any]:
    """The cells of each of `width` columns in the `kept` lines, as Arrow arrays of text without spaces around them.

    Rows may leave out what comes after the `needed` columns; empty cells beyond the last do not count.
    """
    import pyarrow as pa  # only files of rows pay for its import
    import pyarrow.compute as pc
    from pyarrow import csv as table

    body = [lines[at] for at in kept]
    odd = [
        row for row, line in enumerate(body) if '"' in line or line.count(separator) != width - 1
    ]
    for row in odd:  # the others need no look
        place = f"{source}, line {kept[row] + 1}"
        cells = _fitted(cells_of(body[row], separator, place), separator, place, width, needed)
        body[row] = separator.join(cell.replace(separator, "\x1f") for cell in cells)
    names = [str(index) for index in range(width)]
    read = table.read_csv(
        pa.py_buffer("\n".join(body).encode()),
        read_options=table.ReadOptions(column_names=names, block_size=1 << 26),
        parse_options=table.ParseOptions(
            delimiter=separator, quote_char=False, ignore_empty_lines=False
        ),
        convert_options=table.ConvertOptions(
            column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=False
        ),
    )
    texts = [pc.utf8_trim_whitespace(column.combine_chunks()) for column in read.columns]
    return [pc.replace_substring(text, "\x1f", separator) for text in texts] if odd else texts


def _fitted(cells: list[str], separator: str, place: str, width: int, needed: int) -> list[str]:
    """The cells of a row, as many as columns."""
    while len(cells) > width and not cells[-1]:
        cells.pop()
    if needed <= len(cells) <= width:
        return cells + [""] * (width - len(cells))
    is_decimal = separator == "," and len(cells) > width
    hint = (
        "a decimal comma read as a separator? separate the columns by semicolons"
        if is_decimal
        else None
    )
    count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
    problem = f"{count} where the header has {width} (separator: {SEPARATORS[separator]})"
    raise InputError(problem, where=place, hint=hint)
