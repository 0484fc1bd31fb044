"""Numbers of a suit from a file that `tendon fit-suit` wrote, for a study that names it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from tendon_cli.errors import InputError, StudyError
from tendon_cli.studies.correlation import Correlation
from tendon_cli.studies.parts import Part
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.toml_reading import MAX_BYTES, read_toml
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import SI_UNIT, shorten

__all__ = ["MAX_BYTES", "FittedSuit", "read_fitted", "with_numbers"]

_HINT = "`tendon fit-suit study.toml log.csv --out fit.toml` writes one"


@dataclass(frozen=True, eq=False)
class FittedSuit:
    """Numbers of a suit with their laws and their correlation."""

    numbers: Mapping[str, StudyNumber]
    correlation: Correlation
    logs: tuple[str, ...]
    warnings: tuple[str, ...]
    """Warnings of the fit."""


def read_fitted(content: bytes, where: str) -> FittedSuit:
    """Read the numbers of a suit.

    Args:
        content: Bytes of the file.
        where: Name of the file, for messages.

    Raises:
        InputError: if the file is not one of `tendon fit-suit`.
    """
    try:
        document = read_toml(content.decode("utf-8-sig")).content
        written = document["numbers"]
        numbers = {key: _number(key, law) for key, law in written.items()}
        names = list(document["covariance"]["keys"])
        covariance = np.array(document["covariance"]["matrix"], dtype=np.float64)
        deviation = np.sqrt(np.diag(covariance))
        matrix = covariance / np.outer(deviation, deviation)
        rows = tuple(tuple(row) for row in (0.5 * (matrix + matrix.T)).tolist())
        correlation = Correlation(keys=tuple(names), matrix=rows)
        _check_keys(names, numbers, matrix)
        fit = document.get("fit", {})
        logs = tuple(str(log) for log in fit.get("logs", ()))
        warnings = tuple(str(warning) for warning in fit.get("warnings", ()))
    except (StudyError, ValueError, KeyError, TypeError, RecursionError, AttributeError):
        expected = "tables [numbers] with value, std and [covariance] with keys, matrix"
        problem = f"not the numbers of a fitted suit, expected {expected}"
        raise InputError(problem, where=where, hint=_HINT) from None
    except PydanticCustomError as error:
        raise InputError(error.message(), where=where, hint=_HINT) from None
    return FittedSuit(numbers, correlation, logs, warnings)


def _check_keys(names: list[str], numbers: Mapping[str, StudyNumber], matrix: Any) -> None:
    """Raise ValueError unless numbers and covariance have the same keys."""
    if set(names) != set(numbers) or not np.isfinite(matrix).all():
        raise ValueError("numbers and covariance differ")


def _number(key: str, law: Mapping[str, Any]) -> StudyNumber:
    """Return one number with its law: uniform between two ends, or normal."""
    mark = keys()[key].number
    dimension = mark.quantity.dimension
    unit = "" if dimension == "number" else f" {SI_UNIT[dimension]}"
    if "from" in law:
        text = f"{_plain(law['from'])!r}{unit} to {_plain(law['to'])!r}{unit}"
        number = mark.read(text)
    else:
        value = _plain(law["value"])
        deviation = _plain(law["std"])
        mean: object = value if not unit else f"{value!r}{unit}"
        std: object = deviation if not unit else f"{deviation!r}{unit}"
        number = mark.read({"mean": mean, "std": std})
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
        annotation = type(part).model_fields[name].annotation
        types = getattr(annotation, "__args__", (annotation,))
        inner = next(one for one in types if isinstance(one, type) and issubclass(one, Part))()
    return part.changed(**{name: _changed(inner, rest, number)})
