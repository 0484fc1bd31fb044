"""One table in every way in which loggers, spreadsheets and programs write it, and in hostile ways.

Each feature's tests write their own table in all of these ways.
"""

from __future__ import annotations

import codecs
import gzip
from collections.abc import Sequence
from dataclasses import dataclass

Content = str | bytes
PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + bytes(range(256))
BOMB = gzip.compress(bytes(70_000_000), compresslevel=1)
"""A few kilobytes that would be 70 MB."""
RANDOM_BYTES = bytes((i * 7919 + i // 3) % 255 + 1 for i in range(5000))


@dataclass(frozen=True)
class Written:
    """A table to be written: names, units and cells with decimal points."""

    names: Sequence[str]
    units: Sequence[str]
    rows: Sequence[Sequence[str]]

    @property
    def headers(self) -> list[str]:
        """Names with their units in brackets."""
        pairs = zip(self.names, self.units, strict=True)
        return [f"{name} ({unit})" if unit else name for name, unit in pairs]

    def text(self, separator: str = ",", decimal: str = ".", end: str = "\n") -> str:
        """Return header and rows."""
        return self.of_lines(self.headers, separator=separator, decimal=decimal, end=end)

    def of_lines(
        self, *above: Sequence[str], separator: str = ",", decimal: str = ".", end: str = "\n"
    ) -> str:
        """Return rows below other lines."""
        rows = [[cell.replace(".", decimal) for cell in row] for row in self.rows]
        return "".join(separator.join(cells) + end for cells in [*above, *rows])

    def of(self, place: int, cell: str, row: int = 1) -> str:
        """Return the table with another cell in a column of a row."""
        rows = [list(cells) for cells in self.rows]
        rows[row][place] = cell
        return Written(self.names, self.units, rows).text()


def good(table: Written) -> dict[str, Content]:
    """Return the table in every way that is read as the same numbers."""
    plain = table.text()
    named = list(table.names)
    units = list(table.units)
    semicolons = table.text(";", ",")
    middle = len(plain.splitlines()) // 2 + 1
    lines = plain.splitlines(keepends=True)
    quoted = [['"' + cell + '"' for cell in cells] for cells in (table.headers, *table.rows)]
    spaced = "".join("  ".join(cells) + "\n" for cells in (table.headers, *table.rows))
    toa5 = (
        '"TOA5","rig","LOGGER","0000"\n' + table.of_lines(named, units, ["Smp"] * len(named))
    ).replace(*('",', '",'))
    ways: dict[str, Content] = {
        "commas": plain,
        "semicolons and decimal commas": semicolons,
        "semicolons and decimal points": table.text(";"),
        "tabs": table.text("\t"),
        "tabs and decimal commas": table.text("\t", ","),
        "runs of spaces": spaced,
        "UTF-8 with a mark": codecs.BOM_UTF8 + plain.encode(),
        "UTF-16": plain.encode("utf-16"),
        "UTF-16 big-endian": codecs.BOM_UTF16_BE + semicolons.encode("utf-16-be"),
        "Windows-1252": ("# Pr\u00fcfer: M\u00fcller \u2013 5 \u20ac\n" + plain).encode("cp1252"),
        "Windows line ends": table.text(end="\r\n"),
        "old Macintosh line ends": table.text(end="\r"),
        "no last line end": plain.rstrip("\n"),
        "blank lines": plain.replace("\n", "\n\n"),
        "a comma at each row's end": plain.replace("\n", ",\n"),
        "a comma at each row's end but the header's": "".join(
            [lines[0], *(line.replace("\n", ",\n") for line in lines[1:])]
        ),
        "quotes around everything": "".join(",".join(cells) + "\n" for cells in quoted),
        "spaces around cells": plain.replace(",", " , "),
        "fixed spaces around cells": plain.replace(",", "\u00a0,\u00a0"),
        "minus as a page sets it": plain.replace("-", "\u2212"),
        "comments above": '# rig 3; 2024\n% second\n// third\n"# fourth"\n' + plain,
        "titles above": "Rig 3 of the laboratory, brake wire\nmeasured by hand\n" + plain,
        "the header behind a sign": "# made by hand\n# " + plain,
        "the header behind %": "%" + plain,
        "sep=": "sep=;\n" + semicolons,
        "the header again": "".join([*lines[:middle], lines[0], *lines[middle:]]),
        "units in a row of their own": table.of_lines(named, units),
        "units in brackets in a row of their own": table.of_lines(
            named, [f"({unit})" if unit else "" for unit in units]
        ),
        "units in a row, semicolons, a title": "Messung vom 12.03.2024;;\n"
        + table.of_lines(named, units, separator=";", decimal=","),
        "a logger's head": toa5,
        "LabVIEW's head": "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n"
        "***End_of_Header***\t\n\t\nChannels\t3\n***End_of_Header***\n" + table.text("\t"),
        "OpenSim's head": "Coordinates\nversion=1\nnRows=4\ninDegrees=yes\n\nendheader\n"
        + table.text("\t"),
        "packed": gzip.compress(plain.encode()),
    }
    if not any(units):
        ways = {way: text for way, text in ways.items() if "units in" not in way}
    return ways


def hostile(table: Written, number: int) -> dict[str, tuple[Content, str, str]]:
    """Return files that every feature refuses, each with place and words of its fault.

    Args:
        table: The table, of three rows or more.
        number: Place of a column whose cells are numbers.
    """
    plain = table.text()
    width = len(table.names)
    column = f"line 3, column {number + 1}"
    lines = plain.splitlines(keepends=True)
    semicolons = table.text(";", ",").splitlines(keepends=True)
    thousand = semicolons[2].rstrip("\n").split(";")
    thousand[number] = "1.250"
    decimal = semicolons[1].rstrip("\n").split(";")
    decimal[number] = "5,5"
    german = [semicolons[0], ";".join(decimal) + "\n", ";".join(thousand) + "\n", semicolons[3]]
    return {
        "empty": (" \n\n\t\n", "", "empty"),
        "comments only": ("# nothing\n# at all\n", "", "comments only"),
        "header only": (lines[0], "line 1", "below the header"),
        "a word": (table.of(number, "oops"), column, '"oops", expected a number'),
        "a formula": (table.of(number, "=1+1"), column, '"=1+1"'),
        "hexadecimal": (table.of(number, "0x1F"), column, '"0x1F"'),
        "other digits": (table.of(number, "\u0660.\u0668"), column, "expected a number"),
        "underscores": (table.of(number, "1_0.8"), column, '"1_0.8"'),
        "infinite": (table.of(number, "inf"), column, '"inf"'),
        "too large a number": (table.of(number, "1e999"), column, "too large"),
        "a thousands point": ("".join(german), column, '"1.250" has the decimal sign "."'),
        "a quoted decimal comma": (table.of(number, '"1,236"'), column, "comma"),
        "zeros in front": (table.of(number, "028"), column, "begins with a zero"),
        "a row too short": (
            "".join([*lines[:2], lines[2].split(",")[0] + "\n", *lines[3:]]),
            "line 3",
            f"1 cell where the header has {width}",
        ),
        "a row too long": (
            "".join([*lines[:2], lines[2].rstrip("\n") + ",7\n", *lines[3:]]),
            "line 3",
            f"{width + 1} cells where the header has {width}",
        ),
        "an open quote": (table.of(number, '"0.858'), "line 3", "not a row of CSV"),
        "a quote that closes early": (table.of(number, '"0.8"58'), "line 3", "not a row of CSV"),
        "zero byte": (plain.encode() + b"1,1.2\0,1.0\n", f"line {len(lines) + 1}", "zero byte"),
        "a power cut": (plain.encode() + bytes(512), "", f"line {len(lines)} is the last whole"),
        "a power cut within a line": (
            plain.encode() + b"1,1." + bytes(9),
            "",
            f"line {len(lines)} is the last whole",
        ),
        "a workbook": (b"PK\x03\x04\x14\0\x06\0" + bytes(100), "", "workbook"),
        "UTF-32": (plain.encode("utf-32"), "", "UTF-32"),
        "half a UTF-16 character": (plain.encode("utf-16") + b"\x0a", "line", "not UTF-16"),
        "an image": (PNG, "line", "zero byte"),
        "one endless line": ("1," * 10**6, "line 1", "65536"),
        "random bytes": (RANDOM_BYTES, "line 1", "not UTF-8"),
        "broken gzip": (b"\x1f\x8b" + RANDOM_BYTES, "", "gzip"),
        "a bomb": (BOMB, "", "when unpacked"),
    }
