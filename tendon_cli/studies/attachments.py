"""Files that a study names: routes of sheaths, fitted friction coefficients, curves, people."""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tendon_cli.errors import Fault, InputError, StudyError
from tendon_cli.files import read_input
from tendon_cli.quantities import SIDES
from tendon_cli.readers.table import read_table
from tendon_cli.studies import angle_curves, study_curves
from tendon_cli.studies.angle_curves import CurveColumns, CurveTable
from tendon_cli.studies.checks import sheath_faults
from tendon_cli.studies.file_content import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.file_content import FileContent
from tendon_cli.studies.json_schema import faults_of
from tendon_cli.studies.magnitude import Slip, slip_faults, slip_notes
from tendon_cli.studies.parts import FILES_OF_SHEATH, Sheath, SheathSide
from tendon_cli.studies.people.people_section import People
from tendon_cli.studies.row_reading import (
    CASES,
    RowReader,
    carried_faults,
    columns_set,
    flat_keys,
)
from tendon_cli.studies.row_table import RowTable, StatedRole
from tendon_cli.studies.space.axis import CASE_AXIS
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.table_section import MAX_BYTES as MOST_TABLE_BYTES
from tendon_cli.studies.table_section import MOST_ROWS, TableSection
from tendon_cli.studies.toml_reading import MAX_BYTES, KeyPlaces, read_toml, shown
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import shorten

_CURVES = {
    ("joint", "torque"): (angle_curves.TORQUE,),
    ("joint", "excursion"): (angle_curves.EXCURSION,),
    ("load", "torque"): (angle_curves.TASK_OVER_ANGLE, angle_curves.TASK_OVER_TIME),
}
"""Kinds of curves by the tables and keys that may name their files."""
_TORQUE = "torque"
"""Column of the torque of a task, of which a trajectory may have one."""
_LARGEST_ERROR = 10.0
"""Largest standard error of a friction coefficient."""


@dataclass(frozen=True)
class _File:
    """File that a study names."""

    key: str
    """Dotted key that names it."""
    name: str
    """Path from the folder of the study, or of the base that names it."""
    content: bytes

    @property
    def where(self) -> str:
        """Its name in messages."""
        return shorten(self.name, 200)


@dataclass
class Attachments:
    """Reader of the files that one study names; it reads each once and keeps what it gave."""

    folder: Path
    """Folder of the study, in which the files are looked up."""
    accepts_slips: bool = False
    """True if values far from any arm are notes, and not faults."""
    places: KeyPlaces = field(default_factory=KeyPlaces)
    """Files that state the keys; a file of a base is looked up in the folder of the base."""
    sources: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Name, hash and facts of each file that was read, by the key that names it."""
    faults: list[Fault] = field(default_factory=list)
    """Faults of keys whose files could not be read, or do not fit the study."""

    def resolve(self, study: Study) -> Study:
        """Return the study with the content of its files in place of their names; collect `faults`.

        Raises:
            InputError: The content of a file cannot be trusted.
        """
        study = self._with_fitted_suit(study)
        study = self._with_trajectory(study)
        update = {"sheath": self._sheath(study.sheath), **self._curves(study)}
        if study.people is not None:
            update["people"] = self._people(study.people)
        return study.replaced(update) if self.sources else study

    # --- Tables of rows --------------------------------------------------------------------------

    def with_tables(self, study: Study) -> Study:
        """Return the study with the rows of its cases and tables in place of what names them.

        All faults of the rows are collected. Numbers that are at fault are left out.
        """
        tables = []
        for at, section in enumerate(study.table):
            wrong = [*section.contradictions(at)]
            self.faults += wrong
            table = None if wrong else self._rows(section, at)
            if table is not None:
                tables.append(table)
        self.faults += carried_faults(tables)
        cases = None
        if study.cases is not None:
            reader = self._reader_of_rows(CASE_AXIS, study.cases, CASES)
            cases = self._read_rows(reader, "condition")
        if cases is None and not tables:
            return study
        return study.replaced({"cases": cases, "table": tuple(tables)})

    def _rows(self, section: TableSection, at: int) -> RowTable | None:
        """Return the rows of a table; None if its file cannot be read.

        Args:
            section: The table as the study states it.
            at: Its place in the study, from 0.
        """
        if section.sample is not None:
            self.sources[f"table.{at}.sample"] = section.sample_facts
            return section.sampled(at)
        name = section.name or ""
        reader: RowReader | None
        if section.file is not None:
            reader = self._reader_of_file(name, section.file, at)
        elif isinstance(section.rows, dict):
            reader = RowReader.of_columns(name, section.rows, f"table.{at}")
        else:
            reader = self._reader_of_rows(name, section.rows, f"table.{at}")
        return None if reader is None else self._read_rows(reader, section.role)

    def _read_rows(self, reader: RowReader, role: StatedRole | None) -> RowTable:
        """Return the table of some rows, and collect its faults."""
        table = reader.read(role)
        self.faults += [replace(fault, is_of_file=reader.are_texts) for fault in reader.faults]
        return table

    def _reader_of_rows(
        self, name: str, rows: Sequence[Mapping[str, Any]], where: str
    ) -> RowReader:
        """Return the reader of rows that a study states, with numbers in place of files."""
        place = CASES if where == CASES else f"{where}.rows"
        stated = [dict(flat_keys(row)) for row in rows]
        for at, row in enumerate(stated):
            self._resolve_row(row, f"{place}.{at}")
        return RowReader.of_rows(name, stated, where)

    def _resolve_row(self, row: dict[str, Any], place: str) -> None:
        """Put the numbers of the sheaths of a row in place of the files that give them.

        Args:
            row: Its cells by dotted keys; changed.
            place: Its place in the study.
        """
        of_both: StudyNumber | None = None
        for table in ("sheath", *(f"sheath.{side}" for side in SIDES)):
            of_files = (*FILES_OF_SHEATH.values(), "path_smoothing")
            files = {name: f"{table}.{name}" for name in of_files}
            stated = {name: row.pop(key) for name, key in files.items() if key in row}
            if not stated:
                continue
            numbers = {name: f"{table}.{name}" for name in FILES_OF_SHEATH}
            stated |= {name: row[key] for name, key in numbers.items() if key in row}
            where = f"{place}.{table}"
            try:
                sheath = SheathSide.model_validate(stated)
                self.faults += sheath_faults(where, sheath)
                found = self._sheath_numbers(sheath, where, of_both)
            except ValidationError as error:
                wrong = faults_of(error, KeyPlaces())
                self.faults += [replace(fault, key=f"{where}.{fault.key}") for fault in wrong]
                continue
            except InputError as error:
                self.faults.append(_fault_of_file(error, where))
                continue
            of_both = found.get("bend_angle") or _stated_bend(sheath)
            for name, key in numbers.items():
                if found.get(name) is not None:
                    dimension = keys()[f"sheath.{name}"].number.quantity.dimension
                    row[key] = found[name].document(dimension)

    def _reader_of_file(self, name: str, named: str, at: int) -> RowReader | None:
        """Return the reader of the file of a table; None if it cannot be read."""
        file = self._read(named, f"table.{at}.file", MOST_TABLE_BYTES)
        if file is None:
            return None
        if file.content.count(b"\n") > MOST_ROWS + 1:
            problem = f'"{shorten(file.name)}" has more than {MOST_ROWS:,} lines'
            hint = f"a table has {MOST_ROWS:,} rows at most"
            self.faults.append(Fault(file.key, problem, hint))
            return None
        try:
            table = read_table(
                file.content, columns_set, source=file.where, most_bytes=MOST_TABLE_BYTES
            )
        except InputError as error:
            self.faults.append(_fault_of_file(error, file.where))
            return None
        self._note(file, rows=len(table))
        reader = RowReader.of_table(name, table)
        self.faults += [_fault_of_file(error, file.where) for error in table.faults]
        return reader

    # --- A fitted suit ---------------------------------------------------------------------------

    def _with_fitted_suit(self, study: Study) -> Study:
        """Return the study with the numbers of a fitted suit, and their correlation.

        A number that is an axis of the study stays one: the study then asks about other suits.
        """
        file = self._read(study.fitted_from, "fitted_from", MAX_BYTES)
        if file is None:
            return study
        from tendon_cli.studies.fitted_suit import read_fitted, with_numbers  # if it is named

        where = file.where
        fitted, correlation, logs, warned = read_fitted(file.content, where)
        for key in ("sheath.friction_from", "sheath.path"):
            name = key.partition(".")[2]
            if getattr(study.sheath, name) is not None:
                problem = "cannot be given with fitted_from, which also gives it"
                self.faults.append(Fault(key, problem, "leave one of them out"))
        stated = {key: study.numbers[key] for key in fitted if key in study.numbers}
        axes = [key for key, number in stated.items() if number.is_axis]
        numbers = {key: number for key, number in fitted.items() if key not in axes}
        warnings = [f"{where}: the fit warned: {warning}" for warning in warned]
        if axes:
            listed = ", ".join(axes)
            warnings.append(f"{listed}: the study's own values, not those fitted in {where}")
        note = (
            f"{where}: {len(numbers)} numbers of this suit as fitted to {shorten(', '.join(logs))},"
            " drawn with their correlation"
        )
        self._note(
            file,
            logs=logs,
            stated={key: stated[key].single for key in numbers if key in stated},
            fitted={key: number.single for key, number in numbers.items()},
            warnings=warnings,
            note=note,
        )
        study = with_numbers(study, numbers)
        return study.replaced({"correlation": correlation, "fitted_from": None})

    # --- Motion and curves -----------------------------------------------------------------------

    def _with_trajectory(self, study: Study) -> Study:
        """Return the study with the rows of its motion in time in place of their file.

        The torque of a third column becomes the torque of its load.
        """
        stated = study.motion.trajectory
        rows = self._trajectory_rows(study) if isinstance(stated, str) else stated
        if rows is None:
            return study
        task = study.load.torque
        if _TORQUE in rows.columns:
            if task is not None and task != stated:
                problem = (
                    f"cannot be given with motion.trajectory, whose column {_TORQUE} also gives it"
                )
                self.faults.append(Fault("load.torque", problem, "leave one of them out"))
            task = CurveTable({name: rows.columns[name] for name in ("time", _TORQUE)})
        motion = study.motion.model_copy(update={"trajectory": rows.without(_TORQUE)})
        load = study.load.model_copy(update={"torque": task})
        return study.replaced({"motion": motion, "load": load})

    def _trajectory_rows(self, study: Study) -> CurveTable | None:
        """Return the rows of the file of a motion in time; None if they cannot be smoothed."""
        file = self._read(study.motion.trajectory, "motion.trajectory", angle_curves.MAX_BYTES)
        if file is None:
            return None
        from tendon_cli.studies import measured_motion  # only a trajectory pays for its import

        rows, notes = self._curve(file, angle_curves.TRAJECTORY)
        motion = study.motion.model_copy(update={"trajectory": rows})
        short = measured_motion.short_record(motion)
        if short is not None:
            raise InputError(short.problem, where=file.where, hint=short.hint)
        wrong = measured_motion.trajectory_fault(motion)
        if wrong is not None:
            self.faults.append(wrong)
            self._note(file, warnings=[*notes, *self._judged(file.key, rows.slips)])
            return None
        facts = measured_motion.facts_of(motion, file.where)
        facts["warnings"] = [*notes, *facts["warnings"]]
        self._note(file, **facts)
        return rows

    def _curves(self, study: Study) -> dict[str, Any]:
        """Return the tables of joint and load with curves in place of their files."""
        update: dict[str, Any] = {}
        has_time = study.motion.trajectory is not None
        for (table, name), kinds in _CURVES.items():
            part = update.get(table, getattr(study, table))
            file = self._read(getattr(part, name), f"{table}.{name}", angle_curves.MAX_BYTES)
            if file is None:
                continue
            is_travel = name == "excursion"
            preferred = kinds[::-1] if has_time else kinds
            curve, warnings = self._curve(file, *preferred)
            beyond = study_curves.not_covered(study, curve, is_travel=is_travel)
            if beyond is not None:
                hint = study_curves.hint_to_cover(curve)
                raise InputError(beyond, where=file.where, hint=hint)
            if is_travel:
                warnings += study_curves.warnings_of(study, curve, file.where)
            facts: dict[str, Any] = {"rows": curve.rows, "warnings": warnings}
            if curve.is_in_time:
                facts["note"] = f"{file.where}: {study_curves.task_note(curve)}"
            self._note(file, **facts)
            update[table] = part.model_copy(update={name: curve})
        return update

    def _curve(self, file: _File, *kinds: CurveColumns) -> tuple[CurveTable, list[str]]:
        """Return a curve as `read_curve` does; errors list slips that the study does not accept."""
        return angle_curves.read_curve(
            file.content, file.where, *kinds, accepts_slips=self.accepts_slips
        )

    # --- People ----------------------------------------------------------------------------------

    def _people(self, people: People) -> People:
        """Return the table of people with the content of its files."""
        file = self._read(people.statistics, "people.statistics", MAX_BYTES)
        if file is not None:
            # Only a study with its own statistics pays for the import.
            from tendon_cli.studies.people.survey import read_survey

            survey = read_survey(file.content, file.where)
            self._note(file, men=survey.male.persons, women=survey.female.persons)
            people = people.changed(statistics=FileContent.of(file.content))
        if isinstance(people.file, FileContent) and not self.accepts_slips:
            self._judged("people.file", people.population.slips)
        file = self._read(people.file, "people.file", MAX_PEOPLE_BYTES)
        if file is None or isinstance(people.statistics, str):
            return people
        known = people.changed(file=FileContent.of(file.content))
        persons = known.bodies(where=shorten(file.name), accepts_slips=self.accepts_slips)
        warnings = [*persons.notes, *self._judged(file.key, persons.slips)]
        self._note(file, persons=len(persons.persons), warnings=warnings)
        return known

    # --- Sheaths ---------------------------------------------------------------------------------

    def _sheath(self, sheath: Sheath) -> Sheath:
        """Return the table of sheaths, and of its sides, with numbers in place of files."""
        update = self._sheath_numbers(sheath, "sheath")
        of_both = update.get("bend_angle") or _stated_bend(sheath)
        for side in SIDES:
            inner = getattr(sheath, side)
            if inner is not None:
                numbers = self._sheath_numbers(inner, f"sheath.{side}", of_both)
                update[side] = inner.model_copy(update=numbers)
        return sheath.model_copy(update=update)

    def _sheath_numbers(
        self, sheath: Any, key: str, of_both: StudyNumber | None = None
    ) -> dict[str, Any]:
        """Return the numbers that the files of a table of sheaths give.

        Args:
            sheath: The table, of both sides or of one.
            key: Dotted key of the table.
            of_both: Bend angle of both sides, for a table of one side without its own.
        """
        update: dict[str, Any] = {}
        if sheath.path is not None:
            smoothing = sheath.path_smoothing.single if sheath.path_smoothing is not None else 0.0
            bend_angle = self._bend_angle(sheath.path, smoothing, f"{key}.path")
            update |= {"bend_angle": bend_angle, "path": None, "path_smoothing": None}
        if sheath.friction_from is not None:
            bend = update.get("bend_angle") or _stated_bend(sheath) or of_both
            friction = self._friction(sheath.friction_from, f"{key}.friction_from", bend)
            update |= {"friction": friction, "friction_from": None}
        return update

    def _bend_angle(self, named: str, smoothing: float, key: str) -> StudyNumber | None:
        """Return the bend angle of a route with its standard error; None if it cannot be read.

        Args:
            named: File of way-points.
            smoothing: Standard deviation of the noise of the way-points, m.
            key: Dotted key that names the file.
        """
        from tendon_cli.studies import way_points  # only a routed sheath pays for its import

        file = self._read(named, key, way_points.MAX_BYTES)
        if file is None:
            return None
        route = way_points.read_route(file.content, file.where)
        measured, warnings = way_points.measure_route(route, file.where, smoothing)
        warnings += self._judged(key, route.slips(file.where))
        self._note(
            file,
            bend_angle=measured.bend_angle,
            standard_error=measured.standard_error,
            as_it_stands=measured.sum_of_turns,
            noise=measured.noise,
            path_smoothing=smoothing,
            warnings=warnings,
            note=way_points.route_note(measured, file.where),
        )
        middle = f"{measured.bend_angle!r} rad"
        error = f"{measured.standard_error!r} rad"
        return _estimate("sheath.bend_angle", middle, error, key)

    def _friction(self, named: str, key: str, bend: StudyNumber | None) -> StudyNumber | None:
        """Return a fitted friction coefficient with its standard error.

        A fit without a bend angle gives the product μφ instead, which is divided by the bend angle
        that the study states.

        Args:
            named: File with the fit, as `tendon fit-friction` writes it.
            key: Dotted key that names the file.
            bend: Bend angle φ that the study states; None if it states none.
        """
        file = self._read(named, key, MAX_BYTES)
        if file is None:
            return None
        number = keys()["sheath.friction"].number
        hint = "`tendon fit-friction readings.csv --out friction.toml` writes one"
        try:
            fit = read_toml(file.content.decode("utf-8-sig")).content["friction"]
            is_product = "coefficient" not in fit and "friction_bend" in fit
            if is_product:
                angle = bend.single if isinstance(bend, StudyNumber) and not bend.is_axis else 0.0
                coefficient_key = "friction_bend"
                error_key = "friction_bend_standard_error"
            else:
                angle = 1.0
                coefficient_key = "coefficient"
                error_key = "standard_error"
            if angle <= 0.0:
                self.faults.append(
                    Fault(
                        key,
                        "the fit gives only μφ, so it needs a single sheath.bend_angle",
                        "state the bend angle that the sheath had when it was measured, or fit "
                        "with --bend-angle",
                    )
                )
                return None
            coefficient = number.measure(fit[coefficient_key]).si / angle
            error = number.measure(fit[error_key]).si / angle
            estimate = _estimate("sheath.friction", coefficient, error, key)
        except (StudyError, ValueError, KeyError, TypeError, RecursionError):
            expected = "a table [friction] with coefficient (0 to 10), standard_error"
            problem = f"not a friction fragment, expected {expected}"
            raise InputError(problem, where=file.where, hint=hint) from None
        if not error <= _LARGEST_ERROR:
            problem = f"the standard error {error:g} is not between 0 and 10"
            raise InputError(problem, where=file.where, hint=hint)
        source = fit.get("source")
        fitted_from = shorten(source) if isinstance(source, str) else None
        self._note(file, friction=coefficient, standard_error=error, fitted_from=fitted_from)
        return estimate

    # --- Files -----------------------------------------------------------------------------------

    def _read(self, name: object, key: str, most: int) -> _File | None:
        """Return a regular file next to the one that names it, if one is named.

        A file that cannot be read is a fault of its key; one that is too large is an InputError.

        Args:
            name: Path from the folder of the study, or of the base that names it; anything but
                text for no file.
            key: Dotted key that names the file.
            most: Largest size, bytes.
        """
        if not isinstance(name, str):
            return None
        try:
            path = self.folder / self.places.folder_of(key) / name
            return _File(key, name, read_input(path, most))
        except FileNotFoundError:
            stated_by = self.places.file_of(key)
            neighbour = "the study" if stated_by is None else shown(stated_by)
            problem = f'there is no file "{shorten(name)}" beside {neighbour}'
            hint = None
            if not name.isprintable():
                hint = "in double quotes a backslash begins an escape: single quotes, or /"
            self.faults.append(Fault(key, problem, hint))
        except (OSError, ValueError) as error:
            if isinstance(error, OSError) and error.errno == errno.EFBIG:
                problem = f"{error.strerror}, expected less"
                raise InputError(problem, where=shorten(name, 200)) from None
            reason = getattr(error, "strerror", None) or "it is not the name of a file"
            self.faults.append(Fault(key, f'"{shorten(name)}" cannot be read: {reason}'))
        return None

    def _judged(self, key: str, slips: tuple[Slip, ...]) -> list[str]:
        """Return notes on values far from any arm; if they are not accepted, collect faults."""
        if self.accepts_slips:
            return [*slip_notes(key, slips)]
        self.faults += slip_faults(key, slips)
        return []

    def _note(self, file: _File, **facts: Any) -> None:
        """Keep the name and the hash of a file, and facts about it, in `sources`."""
        self.sources[file.key] = {
            "file": Path(file.name).name,
            "sha256": hashlib.sha256(file.content).hexdigest(),
            **facts,
        }


def _fault_of_file(error: InputError, where: str) -> Fault:
    """Return the error of a file as a fault of the study that names it."""
    return Fault(error.where or where, error.message, error.hint, is_of_file=True)


def _estimate(number: str, middle: float | str, error: float | str, key: str) -> StudyNumber | None:
    """Return a number with its standard error; for a row of a table, the number only.

    Args:
        number: Key of the number, such as `sheath.friction`.
        middle: Estimate of the number, as a study file may say it.
        error: Standard error, likewise.
        key: Dotted key that names the file of the estimate.
    """
    is_of_row = key.startswith(("cases.", "table."))
    return keys()[number].number.read(middle if is_of_row else {"mean": middle, "std": error})


def _stated_bend(sheath: Any) -> StudyNumber | None:
    """Return the bend angle that a table states; None for its default, which nobody measured."""
    return sheath.bend_angle if "bend_angle" in sheath.model_fields_set else None
