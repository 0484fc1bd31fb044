"""`[people]` of a study: whose arms it is about."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

import base64
import zlib
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator

from tendon_cli.errors import Fault
from tendon_cli.studies.design_section import Seed
from tendon_cli.studies.fields import SingleField, fault, whole_number
from tendon_cli.studies.parts import FileName, Part, field_default
from tendon_cli.studies.values import OF_FRESH_BODIES, StudyNumber

if TYPE_CHECKING:
    from tendon_cli.studies.people.population import Population
    from tendon_cli.studies.people.survey import Survey

MAX_COUNT = 10**6
"""Largest number of persons drawn."""
MOST_COMPLETIONS = 4096
"""Largest number of bodies drawn for one person."""
MAX_BYTES = 500_000_000
"""Largest size of a file of people, bytes."""


FILE_OF_CONTENT = {
    "people.content": "people.file",
    "people.statistics_content": "people.statistics",
}
"""Keys that name a file, by the keys that hold its packed content in a resolved study."""


def packed(content: bytes) -> str:
    """Return a file's content as text that a study can hold."""
    return base64.b85encode(zlib.compress(content, 6)).decode("ascii")


def unpacked(text: str) -> bytes:
    """Return the content that `packed` was given.

    Raises:
        PydanticCustomError: The text is anything else, or unpacks to more than `MAX_BYTES`.
    """
    try:
        inflate = zlib.decompressobj()
        content = inflate.decompress(base64.b85decode(text), MAX_BYTES + 1)
    except (ValueError, zlib.error):
        raise fault("not the packed content of a file of people") from None
    if len(content) > MAX_BYTES or not inflate.eof:
        raise fault("is too large for a file of people, or was cut short")
    return content


def _check_packed(text: str) -> str:
    """Return the text of a packed file. Raises PydanticCustomError if it is not one."""
    unpacked(text)
    return text


class People(Part):
    """People who wear the suit: persons drawn from a survey, or real ones from a file.

    The study's anchors and elbow radius are the survey's mean man's, and are scaled to each person,
    unless `arm.anchors` says that they were measured on the wearer.
    """

    source: Literal["ansur2"] = field_default(
        "ansur2", description="the survey that persons are drawn from"
    )
    statistics: FileName | None = field_default(
        None,
        description="instead of source: a TOML file of means, deviations and correlations",
    )
    statistics_content: Annotated[str, AfterValidator(_check_packed)] | None = field_default(
        None, description="packed content of that file, as records keep it"
    )
    file: FileName | None = field_default(
        None, description="a CSV of real persons, with units in its headers"
    )
    content: Annotated[str, AfterValidator(_check_packed)] | None = field_default(
        None, description="packed content of that file, as records keep it"
    )
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
    completions: Annotated[int, *whole_number(1, MOST_COMPLETIONS)] | None = field_default(
        None,
        description="with a file: number of draws for each person of the dimensions that were not "
        "measured, given those that were",
    )

    @cached_property
    def population(self) -> "Population":
        """The persons. Raises InputError if their file cannot be used."""
        return self.read("people")

    @cached_property
    def survey(self) -> "Survey":
        """Survey that persons are drawn from or completed by; the study's anchors fit its mean man.

        Raises InputError if its file cannot be used.
        """
        # Studies without people do without this import.
        from tendon_cli.studies.people.survey import ansur2, read_survey

        if self.statistics_content is None:
            return ansur2()
        return read_survey(unpacked(self.statistics_content), "people.statistics")

    @property
    def is_from_file(self) -> bool:
        """True if the persons are those of a file, whether it is read yet or not."""
        return self.file is not None or self.content is not None

    @property
    def persons(self) -> int:
        """Number of persons; 0 while their file is not read yet."""
        if self.file is not None:
            return 0
        if self.content is not None:
            return len(self.population)
        return self.count

    def read(self, where: str, *, accepts_slips: bool = True) -> "Population":
        """Return the persons.

        Args:
            where: Name of their file in errors.
            accepts_slips: As `read_persons` takes it.
        """
        from tendon_cli.studies.people.population import draw, read_population

        women = self.women.single if self.women is not None else None
        if self.content is None:
            return draw(self.survey, self.sex, self.count, self.seed, women)
        content = unpacked(self.content)
        return read_population(
            content,
            where,
            self.survey,
            self.sex,
            women,
            self.completions,
            self.seed,
            accepts_slips=accepts_slips,
        )

    def fresh(self, count: int) -> "Population":
        """Return a fresh sample of about so many bodies, none of which is among the study's own.

        Persons of a survey are drawn anew. Those of a file are the same: for each of them, what
        was not measured is drawn anew if the study draws it.
        """
        from tendon_cli.studies.people.population import draw, read_population

        women = self.women.single if self.women is not None else None
        if self.content is None:
            return draw(self.survey, self.sex, count, self.seed, women, OF_FRESH_BODIES)
        completions = None
        if self.completions is not None:
            completions = max(1, count // len(self.population.persons))
        return read_population(
            unpacked(self.content),
            "people",
            self.survey,
            self.sex,
            women,
            completions,
            self.seed,
            OF_FRESH_BODIES,
        )

    @property
    def nominal(self) -> "Population":
        """The persons, each once, with the expected value of what was not measured."""
        if self.completions is None:
            return self.population
        return self.changed(completions=None).read("people")

    def with_file(self, key: str, content: bytes) -> "People":
        """Return the same table with the content of `file` or `statistics` in place of its name."""
        content_key = {"file": "content", "statistics": "statistics_content"}[key]
        return self.changed(**{content_key: packed(content), key: None})

    def contradictions(self) -> Iterator[Fault]:
        """Yield a fault for each key that contradicts another, or lacks one."""
        given = self.model_fields_set
        if self.file is not None:
            with_file = {"seed"} if self.completions else set()
            for key in ("source", "count", "seed", "content"):
                if key in given and key not in with_file:
                    yield Fault(
                        f"people.{key}", "cannot be given with file", "leave one of them out"
                    )
        elif self.completions is not None and self.content is None:
            problem = "draws the measures that a file of people lacks, but this study names no file"
            yield Fault("people.completions", problem, 'file = "people.csv"')
        if self.statistics is not None:
            for key in ("source", "statistics_content"):
                if key in given:
                    problem = "cannot be given with statistics, which persons are drawn from"
                    yield Fault(f"people.{key}", problem, "leave one of them out")
        if self.women is not None and self.sex != "both":
            problem = f'is a share among both sexes, but sex is "{self.sex}"'
            yield Fault("people.women", problem, 'sex = "both"')
