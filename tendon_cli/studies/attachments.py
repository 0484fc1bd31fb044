"""Files that a study names: the route of a sheath, a fitted friction coefficient, people."""

from __future__ import annotations

import errno
import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tendon_cli.errors import Fault, InputError, StudyError
from tendon_cli.files import read_file
from tendon_cli.space.axis import SIDES
from tendon_cli.studies import curves
from tendon_cli.studies.parts import Part
from tendon_cli.studies.people.asked import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.people.asked import People
from tendon_cli.studies.reading import MAX_BYTES, read_toml
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import Values
from tendon_cli.units import shorten


@dataclass
class Attachments:
    """Reads the files of one study, once each, and remembers what they gave."""

    folder: Path
    sources: dict[str, dict[str, Any]] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def resolve(self, study: Study) -> Study:
        """The study with numbers in the place of files; raises InputError, and gathers `faults` of keys."""
        update: dict[str, Any] = {"sheath": self._sheath(study.sheath, "sheath")}
        if study.cases:
            update["cases"] = tuple(self._case(case, f"cases.{at}") for at, case in enumerate(study.cases))
        update |= self._curves(study)
        if study.people is not None:
            update["people"] = self._people(self._statistics(study.people))
        return study.replaced(update) if self.sources else study

    def _curves(self, study: Study) -> dict[str, Any]:
        """The tables of joint and load with the curves of their files; raises InputError."""
        update: dict[str, Any] = {}
        of = curves.TORQUE
        for table, name, columns in (
            ("joint", "torque", of),
            ("joint", "excursion", curves.EXCURSION),
            ("load", "torque", of),
        ):
            part = update.get(table) or getattr(study, table)
            file, key = getattr(part, name), f"{table}.{name}"
            content = self._read(file, key, curves.MAX_BYTES) if isinstance(file, str) else None
            if content is None:
                continue
            where = shorten(file, 200)
            found = curves.read_curve(content, where, columns)
            curves.check_covers(study, found, key, where)
            warnings = curves.warnings_of(found, where) if name == "excursion" else []
            self._note(key, file, content, rows=len(found.angles), warnings=warnings)
            update[table] = part.model_copy(update={name: found})
        return update

    def _statistics(self, people: People) -> People:
        name = people.statistics
        content = self._read(name, "people.statistics", MAX_BYTES) if name is not None else None
        if name is None or content is None:
            return people
        from tendon_cli.studies.people.survey import read_survey  # only one's own statistics pay for its import

        found = read_survey(content, shorten(name, 200))
        self._note("people.statistics", name, content, men=found.male.persons, women=found.female.persons)
        return people.with_statistics(content)

    def _people(self, people: People) -> People:
        name = people.file
        content = self._read(name, "people.file", MAX_PEOPLE_BYTES) if name is not None else None
        if name is None or content is None or people.statistics is not None:
            return people
        known = people.with_content(content)
        persons = known.read(shorten(name))
        self._note("people.file", name, content, persons=len(persons), warnings=list(persons.notes))
        return known

    def _case(self, case: Any, key: str) -> Any:
        if case.sheath is None:
            return case
        return case.model_copy(update={"sheath": self._sheath(case.sheath, f"{key}.sheath")})

    def _sheath(self, sheath: Any, key: str) -> Any:
        """A sheath table and its sides with their files read."""
        update = self._numbers(sheath, key)
        for side in SIDES:
            inner: Part | None = getattr(sheath, side, None)
            if inner is not None:
                bend = update.get("bend_angle") or _stated_bend(sheath)
                update[side] = inner.model_copy(update=self._numbers(inner, f"{key}.{side}", bend))
        return sheath.model_copy(update=update)

    def _numbers(self, sheath: Any, key: str, bend: Values | None = None) -> dict[str, Any]:
        """The numbers that files give; `bend` is the bend angle of both sides, which one of its own goes before."""
        update: dict[str, Any] = {}
        if sheath.path is not None:
            smoothing = sheath.path_smoothing.single if sheath.path_smoothing is not None else 0.0
            bend_angle = self._bend_angle(sheath.path, smoothing, f"{key}.path")
            update |= {"bend_angle": bend_angle, "path": None, "path_smoothing": None}
        if sheath.friction_from is not None:
            bend = update.get("bend_angle") or _stated_bend(sheath) or bend
            friction = self._friction(sheath.friction_from, f"{key}.friction_from", bend)
            update |= {"friction": friction, "friction_from": None}
        return update

    def _bend_angle(self, name: str, smoothing: float, key: str) -> Values | None:
        from tendon_cli.studies import route  # only a routed sheath pays for its import

        content = self._read(name, key, route.MAX_BYTES)
        if content is None:
            return None
        where = shorten(name, 200)
        found, warnings = route.measure_route(content, where, smoothing)
        self._note(
            key, name, content, bend_angle=found.bend_angle, standard_error=found.standard_error,
            as_it_stands=found.as_it_stands, noise=found.noise, path_smoothing=smoothing, warnings=warnings,
            note=route.route_note(found, where),
        )  # fmt: skip
        return _estimate("sheath.bend_angle", f"{found.bend_angle!r} rad", f"{found.standard_error!r} rad", key)

    def _friction(self, name: str, key: str, bend: Values | None) -> Values | None:
        content = self._read(name, key, MAX_BYTES)
        if content is None:
            return None
        hint = "`tendon fit-friction readings.csv --out friction.toml` writes one"
        try:
            fit = read_toml(content.decode("utf-8-sig")).content["friction"]
            if "coefficient" not in fit and "friction_bend" in fit:
                angle = self._bend_of(bend, key)
                if angle is None:
                    return None
                coefficient = _number(fit["friction_bend"]) / angle
                error = _number(fit["friction_bend_standard_error"]) / angle
            else:
                coefficient, error = _number(fit["coefficient"]), _number(fit["standard_error"])
        except (StudyError, ValueError, KeyError, TypeError, RecursionError):
            problem = "not a friction fragment, expected a table [friction] with coefficient and standard_error"
            raise InputError(problem, where=shorten(name, 200), hint=hint) from None
        if not 0.0 <= coefficient <= 10.0:
            raise InputError(
                f"the coefficient {coefficient:g} is not between 0 and 10", where=shorten(name, 200), hint=hint
            )
        if not 0.0 <= error <= 10.0:
            problem = f"the standard error {error:g} is not between 0 and 10"
            raise InputError(problem, where=shorten(name, 200), hint=hint)
        source = fit.get("source")
        self._note(
            key, name, content, friction=coefficient, standard_error=error,
            fitted_from=shorten(source) if isinstance(source, str) else None,
        )  # fmt: skip
        return _estimate("sheath.friction", coefficient, error, key)

    def _bend_of(self, bend: Values | None, key: str) -> float | None:
        """The one bend angle, rad, of the sheath that μφ was measured on; a fault if it is not stated."""
        angle = None if bend is None or bend.is_axis else bend.single
        if angle is None or not angle > 0.0:
            hint = "state the bend angle that the sheath had when it was measured, or fit with --bend-angle"
            self.faults.append(Fault(key, "the fit is of μφ and needs one sheath.bend_angle beside it", hint))
            return None
        return float(angle)

    def _read(self, name: str, key: str, most: int) -> bytes | None:
        """A regular file next to the study; what cannot be read is a fault of the key that names it."""
        try:
            return read_file(self.folder / name, most)
        except FileNotFoundError:
            self.faults.append(Fault(key, f'there is no file "{shorten(name)}" beside the study'))
        except (OSError, ValueError) as error:
            if isinstance(error, OSError) and error.errno == errno.EFBIG:
                raise InputError(f"{error.strerror}, expected less", where=shorten(name, 200)) from None
            reason = getattr(error, "strerror", None) or "the name is not one"
            self.faults.append(Fault(key, f'"{shorten(name)}" cannot be read: {reason}'))
        return None

    def _note(self, key: str, name: str, content: bytes, **facts: Any) -> None:
        self.sources[key] = {"file": Path(name).name, "sha256": hashlib.sha256(content).hexdigest(), **facts}


def _estimate(number: str, middle: float | str, error: float | str, key: str) -> Values | None:
    """A number with its standard error; a case takes the number only."""
    said = middle if key.startswith("cases.") else {"mean": middle, "std": error}
    return keys()[number].number.read(said)


def _stated_bend(sheath: Any) -> Values | None:
    """The bend angle that stands in the table; None for its default, at which nobody measured."""
    return sheath.bend_angle if "bend_angle" in sheath.model_fields_set else None


def _number(value: object) -> float:
    """A number of a fragment; raises TypeError for anything else, such as a truth value."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e9:
        raise TypeError
    return float(value)
