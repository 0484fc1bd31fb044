"""Files that a study names: the route of a sheath, a fitted friction coefficient, curves, people."""

from __future__ import annotations

import errno
import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tendon_cli.errors import Fault, InputError, StudyError
from tendon_cli.files import read_file
from tendon_cli.space.axis import SIDES
from tendon_cli.studies import angle_curves
from tendon_cli.studies.parts import Part
from tendon_cli.studies.people.people_section import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.people.people_section import People
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.toml_reading import MAX_BYTES, read_toml
from tendon_cli.studies.values import Values
from tendon_cli.units import shorten


@dataclass
class Attachments:
    """Reads the files of one study, once each, and remembers what they gave."""

    folder: Path
    sources: dict[str, dict[str, Any]] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def resolve(self, study: Study) -> Study:
        """The study with numbers in the place of files; raises InputError, and collects `faults` of keys."""
        study = self._trajectory(study)
        update: dict[str, Any] = {
            "sheath": self._sheath(study.sheath, "sheath"),
            **self._curves(study),
        }
        if study.cases:
            update["cases"] = tuple(
                case.model_copy(
                    update={
                        "sheath": self._sheath(getattr(case, "sheath", None), f"cases.{at}.sheath")
                    }
                )
                for at, case in enumerate(study.cases)
            )
        if study.people is not None:
            update["people"] = self._people(study.people)
        return study.replaced(update) if self.sources else study

    def _trajectory(self, study: Study) -> Study:
        """The study with the rows of its motion in time; raises InputError."""
        file, key = study.motion.trajectory, "motion.trajectory"
        content = self._read(file, key, angle_curves.MAX_BYTES) if isinstance(file, str) else None
        if content is None:
            return study
        from tendon_cli.studies import measured_motion  # only a trajectory pays for its import

        where = shorten(str(file), 200)
        rows = angle_curves.read_curve(content, where, angle_curves.TRAJECTORY)
        motion = study.motion.model_copy(update={"trajectory": rows})
        if (wrong := measured_motion.trajectory_fault(motion)) is not None:
            self.faults.append(wrong)
            motion = motion.model_copy(update={"trajectory": None})
        self._note(key, str(file), content, **measured_motion.facts_of(motion, where))
        return study.replaced({"motion": motion})

    def _curves(self, study: Study) -> dict[str, Any]:
        """The tables of joint and load with the curves of their files; raises InputError."""
        update: dict[str, Any] = {}
        for table, name in (("joint", "torque"), ("joint", "excursion"), ("load", "torque")):
            part = update.get(table) or getattr(study, table)
            file, is_travel = getattr(part, name), name == "excursion"
            content = (
                self._read(file, f"{table}.{name}", angle_curves.MAX_BYTES)
                if isinstance(file, str)
                else None
            )
            if content is None:
                continue
            where = shorten(file, 200)
            curve = angle_curves.read_curve(
                content, where, angle_curves.EXCURSION if is_travel else angle_curves.TORQUE
            )
            if (beyond := angle_curves.not_covered(study, curve, is_travel=is_travel)) is not None:
                raise InputError(
                    beyond, where=where, hint="extend the table, or ask for fewer angles"
                )
            warnings = angle_curves.warnings_of(study, curve, where) if is_travel else []
            self._note(f"{table}.{name}", file, content, rows=len(curve.angles), warnings=warnings)
            update[table] = part.model_copy(update={name: curve})
        return update

    def _people(self, people: People) -> People:
        content = self._read(people.statistics, "people.statistics", MAX_BYTES)
        if content is not None:
            from tendon_cli.studies.people.survey import (
                read_survey,
            )  # only one's own statistics pay for its import

            survey = read_survey(content, shorten(people.statistics or "", 200))
            men, women = survey.male.persons, survey.female.persons
            self._note("people.statistics", people.statistics, content, men=men, women=women)
            people = people.with_file("statistics", content)
        content = self._read(people.file, "people.file", MAX_PEOPLE_BYTES)
        if content is None or people.statistics is not None:
            return people
        known = people.with_file("file", content)
        persons = known.read(shorten(people.file or ""))
        self._note(
            "people.file", people.file, content, persons=len(persons), warnings=list(persons.notes)
        )
        return known

    def _sheath(self, sheath: Any, key: str) -> Any:
        """A sheath table and its sides with their files read."""
        if sheath is None:
            return None
        update = self._numbers(sheath, key)
        for side in SIDES:
            inner: Part | None = getattr(sheath, side, None)
            if inner is not None:
                bend = update.get("bend_angle") or _stated_bend(sheath)
                update[side] = inner.model_copy(update=self._numbers(inner, f"{key}.{side}", bend))
        return sheath.model_copy(update=update)

    def _numbers(self, sheath: Any, key: str, bend: Values | None = None) -> dict[str, Any]:
        """The numbers that files give; `bend` is the bend angle of both sides, used if the table has none."""
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
        from tendon_cli.studies import way_points  # only a routed sheath pays for its import

        content = self._read(name, key, way_points.MAX_BYTES)
        if content is None:
            return None
        where = shorten(name, 200)
        measured, warnings = way_points.measure_route(content, where, smoothing)
        self._note(
            key,
            name,
            content,
            bend_angle=measured.bend_angle,
            standard_error=measured.standard_error,
            as_it_stands=measured.as_it_stands,
            noise=measured.noise,
            path_smoothing=smoothing,
            warnings=warnings,
            note=way_points.route_note(measured, where),
        )
        return _estimate(
            "sheath.bend_angle",
            f"{measured.bend_angle!r} rad",
            f"{measured.standard_error!r} rad",
            key,
        )

    def _friction(self, name: str, key: str, bend: Values | None) -> Values | None:
        """A coefficient and its standard error, or both times a bend angle that the study has to state."""
        content = self._read(name, key, MAX_BYTES)
        if content is None:
            return None
        number, where = keys()["sheath.friction"].number, shorten(name, 200)
        hint = "`tendon fit-friction readings.csv --out friction.toml` writes one"
        try:
            fit = read_toml(content.decode("utf-8-sig")).content["friction"]
            is_of_bend = "coefficient" not in fit and "friction_bend" in fit
            angle = (
                bend.single
                if is_of_bend and isinstance(bend, Values) and not bend.is_axis
                else 1.0 - is_of_bend
            )
            if angle <= 0.0:
                help_ = "state the bend angle that the sheath had when it was measured, or fit with --bend-angle"
                self.faults.append(
                    Fault(key, "the fit is of μφ and needs one sheath.bend_angle beside it", help_)
                )
                return None
            product = ("friction_bend", "friction_bend_standard_error")
            names = product if is_of_bend else ("coefficient", "standard_error")
            coefficient, error = (number.measure(fit[name]).si / angle for name in names)
            estimate = _estimate("sheath.friction", coefficient, error, key)
        except (StudyError, ValueError, KeyError, TypeError, RecursionError):
            problem = "not a friction fragment, expected a table [friction] with coefficient (0 to 10), standard_error"
            raise InputError(problem, where=where, hint=hint) from None
        if not error <= 10.0:
            raise InputError(
                f"the standard error {error:g} is not between 0 and 10", where=where, hint=hint
            )
        source = fit.get("source")
        fitted_from = shorten(source) if isinstance(source, str) else None
        self._note(
            key, name, content, friction=coefficient, standard_error=error, fitted_from=fitted_from
        )
        return estimate

    def _read(self, name: str | None, key: str, most: int) -> bytes | None:
        """A regular file next to the study, if one is named; one that cannot be read is a fault of its key."""
        if name is None:
            return None
        try:
            return read_file(self.folder / name, most)
        except FileNotFoundError:
            self.faults.append(Fault(key, f'there is no file "{shorten(name)}" beside the study'))
        except (OSError, ValueError) as error:
            if isinstance(error, OSError) and error.errno == errno.EFBIG:
                raise InputError(
                    f"{error.strerror}, expected less", where=shorten(name, 200)
                ) from None
            reason = getattr(error, "strerror", None) or "the name is not one"
            self.faults.append(Fault(key, f'"{shorten(name)}" cannot be read: {reason}'))
        return None

    def _note(self, key: str, name: str | None, content: bytes, **facts: Any) -> None:
        self.sources[key] = {
            "file": Path(name or "").name,
            "sha256": hashlib.sha256(content).hexdigest(),
            **facts,
        }


def _estimate(number: str, middle: float | str, error: float | str, key: str) -> Values | None:
    """A number with its standard error; a case takes the number only."""
    return keys()[number].number.read(
        middle if key.startswith("cases.") else {"mean": middle, "std": error}
    )


def _stated_bend(sheath: Any) -> Values | None:
    """The bend angle that stands in the table; None for its default, at which nobody measured."""
    return sheath.bend_angle if "bend_angle" in sheath.model_fields_set else None
