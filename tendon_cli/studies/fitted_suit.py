"""Numbers of a suit from a file that `tendon fit-suit` wrote, for a study that names it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from tendon_cli.errors import InputError, StudyError
from tendon_cli.studies.contents import field_kinds
from tendon_cli.studies.correlation import Correlation
from tendon_cli.studies.parts import Part
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.toml_reading import read_toml
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import SI_UNIT, shorten

_HINT = "`tendon fit-suit study.toml log.csv --out fit.toml` writes one"


def read_fitted(
    content: bytes, where: str
) -> tuple[dict[str, StudyNumber], Correlation, list[str], list[str]]:
    """Return the numbers of a suit with their correlation, its logs, and warnings of the fit.

    Args:
        content: Bytes of the file.
        where: Name of the file, for messages.

    Raises:
        InputError: if the file is not one of `tendon fit-suit`.
    """
    try:
        document = read_toml(content.decode("utf-8-sig")).content
        numbers = {key: _number(key, law) for key, law in document["numbers"].items()}
        names = tuple(document["covariance"]["keys"])
        covariance = np.array(document["covariance"]["matrix"], dtype=np.float64)
        deviation = np.sqrt(np.diag(covariance))
        matrix = covariance / np.outer(deviation, deviation)
        rows = tuple(tuple(row) for row in (0.5 * (matrix + matrix.T)).tolist())
        correlation = Correlation(keys=names, matrix=rows)
        fit = document.get("fit", {})
        logs = [*map(str, fit.get("logs", ()))]
        warnings = [*map(str, fit.get("warnings", ()))]
        is_whole = set(names) == set(numbers) and np.isfinite(matrix).all()
    except (StudyError, ValueError, KeyError, TypeError, RecursionError, AttributeError):
        is_whole = False
    except PydanticCustomError as error:
        raise InputError(error.message(), where=where, hint=_HINT) from None
    if not is_whole:
        expected = "tables [numbers] with value, std and [covariance] with keys, matrix"
        problem = f"not the numbers of a fitted suit, expected {expected}"
        raise InputError(problem, where=where, hint=_HINT)
    return numbers, correlation, logs, warnings


def _number(key: str, law: Mapping[str, Any]) -> StudyNumber:
    """Return one number with its law: uniform between two ends, or normal."""
    mark = keys()[key].number
    dimension = mark.quantity.dimension
    unit = "" if dimension == "number" else f" {SI_UNIT[dimension]}"

    def stated(name: str) -> float | str:
        value = _plain(law[name])
        return f"{value!r}{unit}" if unit else value

    if "from" in law:
        number = mark.read(f"{stated('from')} to {stated('to')}")
    else:
        number = mark.read({"mean": stated("value"), "std": stated("std")})
    if number is None:
        raise ValueError(f"{shorten(key)} has no value")
    return number


def _plain(value: object) -> float:
    """Return a number; raise TypeError for anything else, such as true."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{value!r} is not a number")
    return float(value)


def with_numbers(study: Study, numbers: Mapping[str, StudyNumber]) -> Study:
    """Return a study with other numbers at some dotted keys."""
    update: dict[str, Any] = {}
    for key, number in numbers.items():
        table, *path = key.split(".")
        part = update.get(table, getattr(study, table))
        update[table] = _changed(part, path, number)
    return study.replaced(update)


def _changed(part: Part, path: list[str], number: StudyNumber) -> Part:
    """Return a table with a number at a path of names in it."""
    name, *rest = path
    if not rest:
        return part.changed(**{name: number})
    inner = getattr(part, name)
    if inner is None:
        kind = field_kinds(type(part))[name]
        inner = kind() if isinstance(kind, type) else None
    return part.changed(**{name: _changed(inner, rest, number)})
