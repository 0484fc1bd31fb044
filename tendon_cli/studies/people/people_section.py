"""`[people]` of a study: whose arms it is about."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

from tendon_cli.errors import Fault
from tendon_cli.studies.design_section import Seed
from tendon_cli.studies.fields import SingleField, whole_number
from tendon_cli.studies.file_content import FileContent, FileField
from tendon_cli.studies.parts import Part, field_default
from tendon_cli.studies.values import OF_FRESH_BODIES, OF_THE_STUDY, Stream, StudyNumber

if TYPE_CHECKING:
    from tendon_cli.studies.people.population import Population
    from tendon_cli.studies.people.survey import Survey

BODIES = 256
"""Number of bodies that persons of a file have together, at least, if some measure is missing."""
MAX_COUNT = 10**6
"""Largest number of persons drawn."""
_STATISTICS = FileField("instead of source: a TOML file of means, deviations and correlations")
_FILE = FileField("a CSV of real persons, with units in its headers", takes_columns=True)


class People(Part):
    """People who wear the suit: persons drawn from a survey, or real ones from a file.

    The study's anchors and elbow radius are the survey's mean man's, and are scaled to each person,
    unless `arm.anchors` says that they were measured on the wearer.
    """

    source: Literal["ansur2"] = field_default(
        "ansur2", description="the survey that persons are drawn from"
    )
    statistics: Annotated[str | FileContent | None, _STATISTICS] = None
    file: Annotated[str | FileContent | None, _FILE] = None
    sex: Literal["male", "female", "both"] = field_default(
        "both", description="sex of the persons drawn, or of those for whom the file states none"
    )
    women: Annotated[StudyNumber | None, SingleField("women", 0.0, 1.0)] = field_default(
        None, description='share of women if sex is "both"; default that of the survey, 0.327'
    )
    count: Annotated[int, *whole_number(1, MAX_COUNT)] = field_default(
        1000, description="number of persons drawn"
    )
    seed: Seed = field_default(1, description="the same seed draws the same persons")

    @cached_property
    def population(self) -> "Population":
        """The persons. Raises InputError if their file cannot be used."""
        return self.bodies()

    @cached_property
    def survey(self) -> "Survey":
        """Survey that persons are drawn from or completed by; the study's anchors fit its mean man.

        Raises InputError if its file cannot be used.
        """
        # Studies without people do without this import.
        from tendon_cli.studies.people.survey import ansur2, read_survey

        if not isinstance(self.statistics, FileContent):
            return ansur2()
        return read_survey(self.statistics.content, "people.statistics")

    @property
    def is_from_file(self) -> bool:
        """True if the persons are those of a file, whether it is read yet or not."""
        return self.file is not None

    @property
    def persons(self) -> int:
        """Number of persons, or of bodies drawn for them; 0 while their file is not read yet."""
        if self.file is None:
            return self.count
        return len(self.population) if isinstance(self.file, FileContent) else 0

    def fresh(self, count: int, stream: Stream = OF_FRESH_BODIES) -> "Population":
        """Return a fresh sample of about so many bodies, none of which is among the study's own.

        Persons of a survey are drawn anew. Those of a file are the same: for each of them, what
        was not measured is drawn anew.
        """
        return self.bodies(count, stream)

    @property
    def nominal(self) -> "Population":
        """The persons, each once, with the expected value of what was not measured."""
        return self.bodies(0)

    def bodies(
        self,
        count: int = BODIES,
        stream: Stream = OF_THE_STUDY,
        where: str = "people",
        *,
        accepts_slips: bool = True,
    ) -> "Population":
        """Return the persons of the survey or the file.

        Args:
            count: Number of persons of a fresh sample, or of bodies that are drawn for those of a
                file; 0 for expected bodies.
            stream: Stream of the draws.
            where: Name of the file in errors.
            accepts_slips: As `read_persons` takes it.
        """
        from tendon_cli.studies.people.population import draw, read_population

        women = self.women.single if self.women is not None else None
        if not isinstance(self.file, FileContent):
            persons = self.count if stream == OF_THE_STUDY else count
            return draw(self.survey, self.sex, persons, self.seed, women, stream)
        return read_population(
            self.file.content,
            where,
            self.survey,
            self.sex,
            women,
            count,
            self.seed,
            stream,
            accepts_slips=accepts_slips,
        )

    def contradictions(self) -> Iterator[Fault]:
        """Yield a fault for each key that contradicts another, or lacks one."""
        given = self.model_fields_set
        if isinstance(self.file, str):
            for key in ("source", "count"):
                if key in given:
                    yield Fault(
                        f"people.{key}", "cannot be given with file", "leave one of them out"
                    )
        if isinstance(self.statistics, str) and "source" in given:
            problem = "cannot be given with statistics, which persons are drawn from"
            yield Fault("people.source", problem, "leave one of them out")
        if self.women is not None and self.sex != "both":
            problem = f'is a share among both sexes, but sex is "{self.sex}"'
            yield Fault("people.women", problem, 'sex = "both"')
