"""A whole study, and its keys: what each number is called in a file, in a table and in the model."""

from __future__ import annotations

import hashlib
import json
from functools import cached_property
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import PrivateAttr

from tendon_cli.display import Displayed, face
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.space.axis import CASE_AXIS, DRAW_AXIS, PERSON_AXIS
from tendon_cli.space.space import ANCHORS
from tendon_cli.studies import parts
from tendon_cli.studies.contents import (
    DESIGN_PARTS,
    Key,
    Title,
    case_tables,
    part_document,
    keys,
    marked_numbers,
    warn_of_numbers,
)
from tendon_cli.studies.design_section import Goals, Limits, Uncertainty
from tendon_cli.studies.fields import DeferredTables
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.parts import Part, usual
from tendon_cli.studies.people.people_section import People
from tendon_cli.studies.values import Uncertain, Values

__all__ = ["Key", "Study", "keys"]

_GIVEN, _STRAP = ("load", "joint", "anchor", "setting", "arm"), "arm.contact_width"
"""Tables of what a designer does not decide, and the number of these that one does."""


class Study(Displayed, Part):
    """A parameter study: every combination of its axes, in the order of the document, is one design."""

    name: parts.Name = usual(
        "study", description="name of the run folder; without it, the stem of the file's name"
    )
    title: Title = usual("", description="for figures")
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
    cases: Annotated[tuple[Part, ...], DeferredTables(case_tables)] = usual(
        (), description="one axis of linked values, such as persons"
    )

    limits: Limits = Limits()
    design: Goals = Goals()
    people: People | None = None
    uncertainty: Uncertainty | None = None

    figure: tuple[FigureSpec, ...] = usual(
        (),
        exclude=True,
        description="figures drawn of the run; they change neither its tables nor its hash",
    )

    _axes: tuple[str, ...] | None = PrivateAttr(None)
    _sources: dict[str, dict[str, Any]] = PrivateAttr(default_factory=dict)

    @property
    def text(self) -> str:
        """Name, axes, limits and warnings, in a few lines."""
        return str(face().study_text(self))

    def vary(self, **settings: Any) -> Study:
        """The same study with other values: `study.vary(**{"load.mass": "3 kg"})`; raises StudyError, UsageError."""
        varied: Study = face().varied(self, settings)
        return varied

    def replaced(self, parts: dict[str, Any]) -> Study:
        """The same study with some of its tables replaced, and nothing remembered of the old ones."""
        study = self.model_copy(update=parts)
        for remembered in ("numbers", "hash", "trajectory"):
            study.__dict__.pop(remembered, None)
        return study

    def ordered(self, axes: tuple[str, ...], sources: dict[str, dict[str, Any]]) -> Study:
        """The same study with its design axes in the document's order, and the files that gave some of its numbers."""
        study = self.model_copy()
        object.__setattr__(study, "__pydantic_private__", {"_axes": axes, "_sources": sources})
        return study

    @cached_property
    def numbers(self) -> dict[str, Values]:
        """Every number of the study by its dotted key, those of one side (`tendon.flexor.length`) only where given."""
        return {
            key: values
            for part in DESIGN_PARTS
            for key, _, values in marked_numbers(getattr(self, part), part)
        }

    @cached_property
    def trajectory(self) -> Trajectory | None:
        """The motion in time, smoothed, if the study has one."""
        if self.motion.trajectory is None:
            return None
        from tendon_cli.studies.measured_motion import (
            trajectory_of,
        )  # only such studies pay for its import

        return trajectory_of(self.motion)

    @property
    def angles(self) -> npt.NDArray[np.float64]:
        """All elbow angles that states are taken at, rad, in the order of the rows."""
        return self.motion.elbow_angle.array if self.trajectory is None else self.trajectory.angle

    @property
    def flexion(self) -> npt.NDArray[np.bool_]:
        """Whether friction is that of flexion: of each direction (D, 1), or of each sample of a trajectory (1, K)."""
        if self.trajectory is not None:
            return self.trajectory.flexion[np.newaxis]
        return np.array([direction == "flexion" for direction in self.motion.direction]).reshape(
            -1, 1
        )

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """Words that vary, by dotted key: where the springs sit."""
        springs = {"spring.at": self.spring, "spring.flexor.at": self.spring.flexor}
        springs["spring.extensor.at"] = self.spring.extensor
        return {
            key: at
            for key, each in springs.items()
            if isinstance(at := getattr(each, "at", None), tuple)
        }

    @property
    def of_the_body(self) -> tuple[str, ...]:
        """Numbers that come from the body of each person, as the study has people and does not state them."""
        if self.people is None:
            return ()
        from tendon_cli.studies.people.population import (
            OF_THE_BODY,
        )  # a study without people does without it

        stated = {f"arm.{name}" for name in self.arm.model_fields_set}
        return tuple(key for key in OF_THE_BODY if key not in stated)

    @property
    def crossed(self) -> bool:
        """Whether every person meets every draw of the uncertain numbers: as stated, else with fewer persons."""
        asked = self.uncertainty
        if self.people is None or asked is None:
            return False
        return self.people.persons < asked.draws if asked.cross is None else asked.cross

    @property
    def draws(self) -> int:
        """How many draws of the uncertain numbers are an axis; none where each person gets one."""
        asked = self.uncertainty
        return (
            asked.draws
            if asked is not None and self.uncertain and (self.people is None or self.crossed)
            else 0
        )

    @property
    def axes(self) -> tuple[str, ...]:
        """Keys of the design axes, slowest first; `case`, `person` and `draw` stand for several numbers each."""
        varied = (*(key for key, values in self.numbers.items() if values.is_axis), *self.words)
        ordered = (
            varied if self._axes is None else tuple(key for key in self._axes if key in varied)
        )
        named = {CASE_AXIS: self.cases, PERSON_AXIS: self.people, DRAW_AXIS: self.draws}
        return (*(key for key, is_axis in named.items() if is_axis), *ordered)

    @property
    def uncertain(self) -> dict[str, Uncertain]:
        """Numbers that are known up to a distribution, by dotted key."""
        return {
            key: values.uncertain
            for key, values in self.numbers.items()
            if values.uncertain is not None
        }

    @property
    def notes(self) -> tuple[str, ...]:
        """What was made of its files."""
        return tuple(str(source["note"]) for source in self.sources.values() if "note" in source)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of its results has to know: of its files, and of numbers that it most likely does not mean."""
        of_files = [
            str(warning)
            for source in self.sources.values()
            for warning in source.get("warnings", ())
        ]
        tables = [(name, getattr(self, name)) for name in (*DESIGN_PARTS, "motion", "limits")]
        tables += [(f"cases.{at}", case) for at, case in enumerate(self.cases)]
        return (*of_files, *warn_of_numbers(item for name, table in tables for item in marked_numbers(table, name)))

    @property
    def conditions(self) -> tuple[str, ...]:
        """The axes that a design must survive, slowest first; the others are choices.

        Without `[design] conditions` cases, persons, draws, and what a designer does not decide: load, joint, anchors,
        setting and arm, but for the width of the strap. Persons, draws and intervals are never choices.
        """
        asked = self.design.conditions
        if asked is None:
            asked = (
                CASE_AXIS,
                *(key for key in self.axes if key.partition(".")[0] in _GIVEN and key != _STRAP),
            )
        return tuple(
            key for key in self.axes if key in (*asked, PERSON_AXIS, DRAW_AXIS, *self.intervals)
        )

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Numbers of which every value between two ends is meant: these, in SI, by dotted key."""
        return {key: values.extremes for key, values in self.numbers.items() if values.is_interval}

    @property
    def serve(self) -> float:
        """The share of people, draws or conditions that is enough: 1, or 0.95 where there are people or draws."""
        if self.design.serve is not None:
            return self.design.serve.single
        return 0.95 if {PERSON_AXIS, DRAW_AXIS} & set(self.axes) else 1.0

    @property
    def sources(self) -> dict[str, dict[str, Any]]:
        """Files that gave numbers of this study, by the key they gave: name, hash, and what was read from them."""
        return self._sources

    def document(self) -> dict[str, Any]:
        """The study with every default written out, in SI; reads back as the same study.

        Numbers that come from the body of a person are left out: once written they would count as stated.
        """
        written = part_document(self)
        for key in self.of_the_body:
            del written["arm"][key.removeprefix("arm.")]
        if (
            self.motion.trajectory is not None
        ):  # which says what angles, directions and a speed would
            del written["motion"]["elbow_angle"], written["motion"]["direction"]
        if self.joint.excursion is not None:  # which says what the anchors would
            written["arm"] = {
                name: value for name, value in written["arm"].items() if name not in ANCHORS
            }
        return written

    @property
    def record(self) -> dict[str, Any]:
        """What tables and `run.json` keep of a study."""
        return {"study": self.document(), "axes": list(self.axes), "sources": self.sources}

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the resolved study and the order of its axes, whatever file and layout it came from."""
        content = {"study": self.document(), "axes": list(self.axes)}
        return hashlib.sha256(
            json.dumps(content, sort_keys=True, ensure_ascii=True).encode()
        ).hexdigest()
