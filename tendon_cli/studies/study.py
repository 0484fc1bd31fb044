"""A whole study: its tables, its numbers by key, its axes and its record."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
from pydantic import PrivateAttr

from tendon_cli import say
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.quantities import SIDES
from tendon_cli.say.display import Displayed
from tendon_cli.studies import parts
from tendon_cli.studies.angle_curves import CurveTable
from tendon_cli.studies.contents import (
    DESIGN_PARTS,
    Key,
    Title,
    keys,
    marked_numbers,
    part_document,
    values_in,
    warn_of_distributions,
)
from tendon_cli.studies.correlation import Correlation
from tendon_cli.studies.design_section import Goals, Limits, TruthValue, Uncertainty
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.fit_section import Fitting
from tendon_cli.studies.magnitude import Slip, slip_notes
from tendon_cli.studies.parts import Part, field_default
from tendon_cli.studies.people.people_section import People
from tendon_cli.studies.row_table import RowTable
from tendon_cli.studies.space.axis import (
    CASE_AXIS,
    DRAW_AXIS,
    PERSON_AXIS,
    SAMPLE_AXES,
    limit_of,
    of_side,
    split_side,
)
from tendon_cli.studies.space.space import ANCHORS
from tendon_cli.studies.table_section import CasesField, TableSection
from tendon_cli.studies.usual import UsualDeviation
from tendon_cli.studies.values import StudyNumber, Uncertain
from tendon_cli.verbs.registry import load

__all__ = ["Key", "Study", "keys"]

EXTENDS = "extends"
"""Key that names the study file which a study extends."""
_GIVEN_TABLES = ("load", "joint", "anchor", "setting", "arm")
"""Tables of numbers that a designer does not decide."""
_VARIED = "tendon_cli.studies.load.varied_study"
"""Function behind `vary`, by its name: what checks studies takes them, and lies above."""
_UNNAMED = "study"
"""Name of a study that has none."""
_FEWEST_DRAWS = 16
"""Draws of usual deviations that each person of a file has at least."""
_DRAWS_ALONG_MOTION = 64
"""Draws of usual deviations along a motion in time, where each window takes long."""
_MOST_PAIRS = 2**12
"""Pairs of persons of a file and such draws, beyond which each person has fewer."""
_MAX_VALUES = 6
"""Values of an axis that a text shows; of a longer one only the first and the last."""
_IDLE_INERTIA = (
    "motion.inertia counts along a trajectory, and in logs that `tendon fit-suit` reads: states of"
    " single angles have none"
)
_TABLES_OF_SIDES = ("sheath", "tendon", "spring", "anchor")
"""Tables of numbers that each side has for itself."""
_STRAP_WIDTH = "arm.contact_width"
"""Number of these tables that a designer does decide."""


class StudyTables(Part):
    """The tables of a study, as its file states them."""

    name: parts.Name = field_default(
        _UNNAMED, description="name of the run folder; without it, the stem of the file's name"
    )
    title: Title = field_default("", description="for figures")
    extends: parts.FileName | None = field_default(
        None,
        exclude=True,
        description="study file whose keys hold unless this one states them; its name is not "
        "taken over",
    )
    allow_implausible: TruthValue = field_default(
        default=False, description="true accepts implausible numbers, with a note"
    )
    arm: parts.Arm = parts.Arm()
    sheath: parts.Sheath = parts.Sheath()
    tendon: parts.Tendon = parts.Tendon()
    spring: parts.Spring = parts.Spring()
    anchor: parts.Anchor = parts.Anchor()
    joint: parts.Joint = parts.Joint()
    setting: parts.Setting = parts.Setting()
    spool: parts.Spool = parts.Spool()
    load: parts.Load = parts.Load()
    motion: parts.Motion = parts.Motion()
    model: parts.Model = parts.Model()
    output: parts.Output = parts.Output()
    cases: Annotated[Any, CasesField()] = field_default(
        None, description="one axis of linked values, such as persons: rows of the table `case`"
    )
    table: tuple[TableSection, ...] = field_default(
        (), description="axes of rows that each set several numbers: catalogues, samples"
    )

    limits: Limits = Limits()
    design: Goals = Goals()
    people: People | None = None
    uncertainty: Uncertainty | None = None

    fitted_from: parts.FileName | None = field_default(
        None,
        description="a file written by `tendon fit-suit --out`: its numbers replace those of the "
        "study, and are drawn with their correlation",
    )
    correlation: Correlation | None = field_default(
        None,
        description="correlation of uncertain numbers, which are drawn together; `fitted_from` "
        "gives it",
    )
    fit: Fitting = field_default(
        Fitting(),
        exclude=True,
        description="how `tendon fit-suit` reads logs; it changes neither tables nor hash",
    )
    figure: tuple[FigureSpec, ...] = field_default(
        (),
        exclude=True,
        description="figures of the run; they change neither its tables nor its hash",
    )


class Study(Displayed, StudyTables):
    """Parameter study: every combination of its axes, in the document's order, is one design."""

    _axes: tuple[str, ...] | None = PrivateAttr(None)
    """Keys of the design axes in the order in which they vary; None for the order of the schema."""
    _sources: dict[str, dict[str, Any]] = PrivateAttr(default_factory=dict)
    """Files that gave numbers of the study, by the key that names each."""
    _usual: dict[str, UsualDeviation] = PrivateAttr(default_factory=dict)
    """Usual deviations that are drawn, as an answer does, by dotted key."""

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_study"

    def __dir__(self) -> list[str]:
        return sorted([*super().__dir__(), "vary", *type(self).model_fields])

    @property
    def text(self) -> str:
        """Name, axes, limits and warnings, in a few lines."""
        lines = []
        if EXTENDS in self.sources:
            lines.append((EXTENDS, str(self.sources[EXTENDS]["file"])))
        lines += [("axis", f"{key}: {_axis_text(self, key)}") for key in self.axes]
        lines.append(("motion", _motion_text(self)))
        if self.conditions:
            lines.append(("conditions", ", ".join(self.conditions)))
        for name, value in self.limits.items():
            lines.append(("limit", f"{name} {say.quantity(name, value)}"))
        if self.uncertain:
            lines.append(("uncertain", ", ".join(self.uncertain)))
        lines += [("note", note) for note in self.notes]
        lines += [("warning", warning) for warning in self.warnings]
        title = self.name if self.name == _UNNAMED else f"study {self.name}"
        if self.title:
            title = f"{self.name}: {self.title}"
        return "\n".join([title, *(f"  {name:<11} {text}" for name, text in lines)])

    # --- Other studies ---------------------------------------------------------------------------

    def vary(self, **settings: Any) -> Study:
        """Return the same study with other values: `study.vary(**{"load.mass": "3 kg"})`.

        Args:
            **settings: New values by their dotted keys.

        Raises:
            StudyError: The study with these values has faults.
            UsageError: A setting has no place in a study.
        """
        varied: Study = load(_VARIED)(self, settings)
        return varied

    def replaced(self, parts: dict[str, Any]) -> Study:
        """Return the same study with some of its tables replaced.

        Values that were computed from the old tables are not kept.
        """
        kept = {name: getattr(self, name) for name in type(self).model_fields}
        study = self.model_construct(self.model_fields_set | parts.keys(), **(kept | parts))
        study._usual = self._usual  # noqa: SLF001 - another study of this class
        return study.ordered(self._axes, self._sources)

    def ordered(self, axes: tuple[str, ...] | None, sources: dict[str, dict[str, Any]]) -> Study:
        """Return the same study with a given order of its axes, and a record of its files.

        Args:
            axes: Keys in the order in which the axes shall vary, slowest first; None for the order
                of the schema.
            sources: Files that gave numbers of the study, by the key that names each.
        """
        study = self.model_copy()
        study._axes = axes  # noqa: SLF001 - another study of this class
        study._sources = sources  # noqa: SLF001
        return study

    # --- Numbers ---------------------------------------------------------------------------------

    @cached_property
    def numbers(self) -> dict[str, StudyNumber]:
        """All numbers of the study, by dotted key.

        A number of one side, such as `tendon.flexor.length`, is among them only if it is given.
        """
        return {
            key: values
            for table in DESIGN_PARTS
            for key, _, values in marked_numbers(getattr(self, table), table)
        }

    @property
    def slips(self) -> dict[str, Sequence[Slip]]:
        """Values far from any arm, by dotted key: those of numbers and of curves."""
        found: dict[str, Sequence[Slip]] = {
            key: value.slips
            for key, _, value in values_in(self, "")
            if isinstance(value, StudyNumber | CurveTable) and value.slips
        }
        for table in self.row_tables:
            found |= table.slips
        return found

    @property
    def limit_names(self) -> tuple[str, ...]:
        """Names of the limits that bound some design: stated for all, on an axis, or by rows."""
        of_rows = (limit_of(key) for table in self.row_tables for key in table.keys)
        stated = {*self.limits.stated, *of_rows}
        return tuple(name for name in type(self.limits).model_fields if name in stated)

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """Words that vary, by dotted key: the places of the springs."""
        springs = parts.with_sides(self.spring, "spring")
        places = {f"{key}.at": spring.at for key, spring in springs.items()}
        return {key: words for key, words in places.items() if isinstance(words, tuple)}

    @property
    def uncertain(self) -> dict[str, Uncertain]:
        """Distributions of the uncertain numbers, by dotted key; those named exact have none."""
        return {
            key: values.uncertain
            for key, values in self.numbers.items()
            if values.uncertain is not None and not is_exact(self, key)
        }

    @property
    def drawing(self) -> Uncertainty | None:
        """Draws of the uncertain numbers; None if nothing is drawn, and each has its middle."""
        stated = self.uncertainty
        if stated is None or not stated.asks_for_draws or not stated.draws or not self.to_draw:
            return None
        return stated

    @property
    def usual(self) -> dict[str, UsualDeviation]:
        """Usual deviations that are drawn, by dotted key; none unless the study is `drawn`."""
        return self._usual

    @property
    def to_draw(self) -> dict[str, Uncertain]:
        """Distributions of all that is drawn, by key: of numbers, and of usual deviations."""
        own = self.uncertain
        if self.usual:
            own = {of: law for key, law in own.items() for of in _drawn_as(self, key)}
        return {**own, **{key: usual.law() for key, usual in self.usual.items()}}

    @property
    def body_numbers(self) -> tuple[str, ...]:
        """Keys of the numbers that come from the body of each person.

        The study has people, and does not state these numbers itself.
        """
        if self.people is None:
            return ()
        # A study without people does without the import.
        from tendon_cli.studies.people.population import OF_THE_BODY

        stated = {f"arm.{name}" for name in self.arm.model_fields_set}
        return tuple(key for key in OF_THE_BODY if key not in stated)

    @property
    def stated_anchors(self) -> tuple[str, ...]:
        """Names of the anchors that the study itself states, the elbow radius among them."""
        return tuple(name for name in ANCHORS if name in self.arm.model_fields_set)

    @property
    def measured_anchors(self) -> tuple[str, ...]:
        """Names of the stated anchors that were measured on the wearer, and are not scaled."""
        return self.stated_anchors if self.arm.anchors == "measured" else ()

    # --- Motion ----------------------------------------------------------------------------------

    @cached_property
    def trajectory(self) -> Trajectory | None:
        """Motion in time, smoothed, with a task over time; None for a study of single angles."""
        if self.motion.trajectory is None:
            return None
        # Only a study with a trajectory pays for the import.
        from tendon_cli.studies.measured_motion import trajectory_of

        return trajectory_of(self.motion, self.load.torque)

    @property
    def angles(self) -> npt.NDArray[np.float64]:
        """All elbow angles of the states, rad, in the order of the rows."""
        return self.motion.elbow_angle.array if self.trajectory is None else self.trajectory.angle

    @property
    def flexion(self) -> npt.NDArray[np.bool_]:
        """True where the joint flexes.

        The shape is (directions, 1), or (1, samples) for a trajectory, along which tendons may
        slide the other way.
        """
        if self.trajectory is not None:
            return self.trajectory.is_flexing[np.newaxis]
        is_flexion = [direction == "flexion" for direction in self.motion.direction]
        return np.array(is_flexion).reshape(-1, 1)

    # --- Axes ------------------------------------------------------------------------------------

    @cached_property
    def row_tables(self) -> tuple[RowTable, ...]:
        """Tables of rows that each set several numbers: the cases, then each `[[table]]`.

        A table is among them once its rows are read.
        """
        return tuple(table for table in (self.cases, *self.table) if isinstance(table, RowTable))

    @property
    def drawn_tables(self) -> tuple[str, ...]:
        """Names of the tables whose rows are draws, of which a share is enough."""
        stated = self.design.conditions or ()
        return tuple(
            table.key
            for table in self.row_tables
            if table.stated_role == "draw" and table.key not in stated
        )

    @property
    def draws(self) -> int:
        """Length of the axis of draws of the uncertain numbers.

        It is 0 if nothing is drawn, or if each person gets one draw: persons of a survey, who are a
        sample, too, where usual deviations are drawn, and any who are as many as the draws.
        """
        if self.drawing is None:
            return 0
        draws = self.drawing.draws
        if self.people is None:
            is_slow = bool(self.usual) and self.motion.trajectory is not None
            return min(draws, _DRAWS_ALONG_MOTION) if is_slow else draws
        persons = self.people.persons
        if persons >= draws or (self.usual and not self.people.is_from_file):
            return 0
        if self.usual:
            return min(draws, max(_FEWEST_DRAWS, _MOST_PAIRS // persons))
        return draws

    @property
    def named_lengths(self) -> dict[str, int]:
        """Numbers of rows, of persons and of draws as far as there are any, by axis."""
        lengths = {table.key: len(table) for table in self.row_tables}
        if self.people is not None:  # a number of 0 while their file is not read
            lengths[PERSON_AXIS] = self.people.persons
        if self.draws:
            lengths[DRAW_AXIS] = self.draws
        return lengths

    @property
    def axes(self) -> tuple[str, ...]:
        """Keys of the design axes, slowest first.

        Tables, `case`, `person` and `draw` are axes of several numbers each.
        """
        varied = [key for key, values in self.numbers.items() if values.is_axis]
        varied += self.words
        if self._axes is not None:
            varied = [key for key in self._axes if key in varied]
        return (*self.named_lengths, *varied)

    @property
    def conditions(self) -> tuple[str, ...]:
        """Axes that a design must survive, slowest first; the others are choices.

        Without `[design] conditions` these are cases, persons, draws, and what a designer does not
        decide: load, joint, anchors, setting and arm, but for the width of the strap; and tables
        whose role says so, or that set nothing else. Persons, draws and intervals are never
        choices.
        """
        stated = self.design.conditions
        if stated is None:
            given = [key for key in self.axes if _is_given(key)]
            tables = [table.key for table in self.row_tables if _is_condition(table)]
            stated = (*tables, *given)
        intervals = [key for key, values in self.numbers.items() if values.is_interval]
        conditions = (*stated, *SAMPLE_AXES, *self.drawn_tables, *intervals)
        return tuple(key for key in self.axes if key in conditions)

    @property
    def serve(self) -> float:
        """Share of persons or draws that a design must serve, 0 to 1; 1 if there are neither."""
        if self.design.serve is not None:
            return self.design.serve.single
        drawn = {*SAMPLE_AXES, *self.drawn_tables}
        return 0.95 if self.named_lengths.keys() & drawn else 1.0

    # --- Remarks and record ----------------------------------------------------------------------

    @property
    def sources(self) -> dict[str, dict[str, Any]]:
        """Files that gave numbers of the study, by the key that names each.

        Each has its name, its hash and facts that were read from it.
        """
        return self._sources

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on how the study's files were used."""
        return tuple(str(source["note"]) for source in self.sources.values() if "note" in source)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that a reader of the results has to know.

        They are about the study's files, and about numbers that its author hardly meant.
        """
        warnings = [
            str(warning)
            for source in self.sources.values()
            for warning in source.get("warnings", ())
        ]
        if self.motion.inertia is not None and self.motion.trajectory is None:
            warnings.append(_IDLE_INERTIA)
        for name in DESIGN_PARTS:
            warnings += warn_of_distributions(marked_numbers(getattr(self, name), name))
        for key, slips in self.slips.items():
            warnings += slip_notes(key, slips)
        for table in self.row_tables:
            warnings += table.warnings
        if self.people is not None and not self.people.is_from_file and self.arm.anchors is None:
            warnings += _notes_on_scaled_anchors(self)
        return tuple(warnings)

    def document(self) -> dict[str, Any]:
        """Return the study with every default written out, in SI; it reads back as the same study.

        Numbers that come from the body of a person are left out: once written they would count as
        stated, and so would the default anchors of persons from a file. Keys that a file of the
        study gives instead are left out, too.
        """
        written = part_document(self)
        for key in self.body_numbers:
            del written["arm"][key.removeprefix("arm.")]
        if self.people is not None and self.people.is_from_file:
            for name in set(ANCHORS).difference(self.stated_anchors):
                del written["arm"][name]
        if self.motion.trajectory is not None:
            # A trajectory gives the angles and directions.
            del written["motion"]["elbow_angle"]
            del written["motion"]["direction"]
        if self.joint.excursion is not None:
            # Measured travels replace the anchors.
            for name in ANCHORS:
                written["arm"].pop(name, None)
        if not states_reading(self):
            del written["setting"]["read"]
        if self.uncertainty is not None and not self.uncertainty.asks_for_draws:
            written["uncertainty"] = {
                "exact": list(self.uncertainty.exact),
                "usual": self.uncertainty.usual,
            }
        return written

    @property
    def record(self) -> dict[str, Any]:
        """Content of the study for tables and `run.json`, from which it can be read back."""
        return {"study": self.document(), "axes": list(self.axes), "sources": self.sources}

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the resolved study and the order of its axes.

        It does not depend on the file and the layout that the study came from, and neither on
        `allow_implausible`, which changes no number.
        """
        document = self.document()
        del document["allow_implausible"]
        content = {"study": document, "axes": list(self.axes)}
        text = json.dumps(content, sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(text.encode()).hexdigest()


def _drawn_as(study: Study, key: str) -> tuple[str, ...]:
    """Return the keys under which an answer draws a number: of both sides each has its own."""
    sides = tuple(of_side(key, side) for side in SIDES)
    known = () if study.correlation is None else study.correlation.keys
    has_sides = key.partition(".")[0] in _TABLES_OF_SIDES and split_side(key)[1] is None
    is_common = has_sides and key not in known and study.numbers.keys().isdisjoint(sides)
    return sides if is_common else (key,)


def is_exact(study: Study, key: str) -> bool:
    """Return True if `[uncertainty] exact` names a number, its table, or a sensor's error."""
    return study.uncertainty is not None and study.uncertainty.is_exact(key)


def states_reading(study: Study) -> bool:
    """Return True if a study says how its pretension is read."""
    return "read" in study.setting.model_fields_set


# --- Roles ----------------------------------------------------------------------------------------


def _is_given(key: str) -> bool:
    """Return True for the key of a number that a designer does not decide."""
    return key.partition(".")[0] in _GIVEN_TABLES and key != _STRAP_WIDTH


def _is_condition(table: RowTable) -> bool:
    """Return True for a table whose rows are conditions unless the study names its conditions."""
    if table.stated_role is not None:
        return table.stated_role == "condition"
    return bool(table.keys) and all(map(_is_given, table.keys))


# --- Words ----------------------------------------------------------------------------------------


def _notes_on_scaled_anchors(study: Study) -> Iterator[str]:
    """Yield a note that anchors other than the paper's are scaled to each person, if there are any.

    It goes by the values: a study that is read back from its record states the paper's, too.
    """
    of_paper = parts.Arm()
    of_rows = {key for table in study.row_tables for key in table.keys}
    stated = []
    for name in ANCHORS:
        values = getattr(study.arm, name).array
        is_of_paper = np.array_equal(values, getattr(of_paper, name).array)
        if not is_of_paper or f"arm.{name}" in of_rows:
            stated.append(f"arm.{name}")
    if stated:
        yield (
            f"{say.join_words(stated)} as stated: taken as the mean "
            'man\'s and scaled to each person (arm.anchors = "mean man" says so)'
        )


def _motion_text(study: Study) -> str:
    """Return directions and angles of a motion, or the span of a trajectory."""
    if study.trajectory is None:
        angles = _values_text("elbow_angle", study.motion.elbow_angle)
        return f"{' and '.join(study.motion.direction)}, elbow angle {angles}"
    low, high = np.degrees([study.angles.min(), study.angles.max()])
    duration = study.trajectory.time[-1]
    return f"a trajectory of {duration:.4g} s from {low:.4g} to {high:.4g} deg"


def _axis_text(study: Study, key: str) -> str:
    """Return the values of an axis; the middle of a long one is left out."""
    if key in study.numbers:
        return _values_text(keys()[key].number.name, study.numbers[key])
    if key in study.words:
        return ", ".join(study.words[key])
    if key == DRAW_AXIS:
        return say.counted(study.draws, "draw")
    if study.people is not None and key == PERSON_AXIS:
        if study.people.file:
            return f"those of {study.people.file}"
        return say.counted(study.people.count, "person")
    names = next(table.names for table in study.row_tables if table.key == key)
    noun = "case" if key == CASE_AXIS else "row"
    more = f", ... ({say.counted(len(names), noun)})" if len(names) > _MAX_VALUES else ""
    return ", ".join(names[:_MAX_VALUES]) + more


def _values_text(quantity: str, values: StudyNumber) -> str:
    """Return the values of a number in words; the middle of a long axis is left out."""
    if len(values) > _MAX_VALUES:
        first = say.quantity(quantity, values.array[0])
        last = say.quantity(quantity, values.array[-1])
        return f"{first} to {last}, {len(values):,} values"
    return ", ".join(say.quantity(quantity, value) for value in values.array)
