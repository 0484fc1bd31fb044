"""Sections of a study on its design: limits, goals, and draws of uncertain numbers."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, WithJsonSchema, create_model

from tendon_cli.model.forms import DesignLimit
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES, QUANTITIES
from tendon_cli.studies.fields import SingleField, fault, whole_number
from tendon_cli.studies.number import NumberField
from tendon_cli.studies.parts import Part, Words, field_default
from tendon_cli.studies.space.axis import split_side
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import described

MOST_DRAWS = 2**20
"""Largest number of draws of the uncertain numbers."""
MOST_VERIFIED = 10**6
"""Largest number of persons or draws of a fresh sample."""
_LEAST_SERVED = 1e-6
"""Smallest share that must be served: nobody is no goal."""
PLACES = ("reserve", "middle", "least")
"""Words for the place in its window of pretension that a choice is set to."""
CHOICE_RESULTS = (
    "pretension_from",
    "pretension_to",
    "windows",
    "tolerance",
    "tolerance_length",
    "served",
    "served_at",
    "pretension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
    *OF_CYCLES,
    *OF_TRAJECTORIES,
)
"""Columns of choices.parquet that a goal may name, besides the axes of the choices."""


def _field_of(limit: DesignLimit) -> tuple[Any, Any]:
    """Return the field of a limit in a study, and its default."""
    default = None if limit.default is None else f"{limit.default:g} {QUANTITIES[limit.name].unit}"
    is_reading = limit.name == "max_pretension"
    mark = NumberField(limit.name, *limit.accepts, is_reading=is_reading, uncertain=False)
    return Annotated[StudyNumber | None, mark], default


class _Limits(Part, Mapping[str, float]):
    """Limits of a design, each named as the column that it bounds.

    A name with min_ bounds from below, max_ and peak_ bound from above. A list or a grid is an
    axis: each design is judged by its own limit. As a mapping it has the limits that all designs
    share, those with a default included, with their values in SI.
    """

    def __getitem__(self, name: str) -> float:
        """Return the value of a limit in SI.

        Raises:
            KeyError: The limit is not given, or is an axis.
        """
        values = getattr(self, name) if name in type(self).model_fields else None
        if values is None or values.is_axis:
            raise KeyError(name)
        return float(values.single)

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]
        return (name for name in self.stated if not getattr(self, name).is_axis)

    @property
    def stated(self) -> tuple[str, ...]:
        """Names of the limits that are given, those that are axes included."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)


if TYPE_CHECKING:
    Limits = _Limits
else:  # a field for each limit of the model's table
    Limits = create_model(
        "Limits",
        __base__=_Limits,
        __doc__=_Limits.__doc__,
        **{name: _field_of(limit) for name, limit in LIMITS.items()},
    )


@dataclass(frozen=True)
class _PretensionOrPlace(SingleField):
    """Mark of a field that is a pretension, or a word for a place in a window."""

    def read(self, value: object) -> Any:
        """Return a word as it is, and any other text or number as one value.

        Raises:
            PydanticCustomError: The value is neither.
        """
        if isinstance(value, str) and value.isalpha() and value not in PLACES:
            hint = '"reserve", "middle", "least" or a pretension such as "38 N"'
            raise fault(f"{described(value)} is not a place in a window", hint)
        return value if value in PLACES else super().read(value)

    def _json_one(self) -> dict[str, Any]:
        return {"anyOf": [{"enum": list(PLACES)}, super()._json_one()]}


def _read_rows(value: object) -> object:
    """Return rows as words, as the command line has them; they may be whole numbers."""
    if isinstance(value, (list, tuple)):
        return [_read_rows(item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    return value


_ROW = {"anyOf": [{"type": "integer", "minimum": 0}, {"type": "string", "pattern": r"^\d+$"}]}
RowWords = Annotated[
    Words,
    BeforeValidator(_read_rows),
    WithJsonSchema({"anyOf": [*_ROW["anyOf"], {"type": "array", "items": _ROW}]}),
]
"""One row of a table or a list of them, as numbers or words."""


def _read_truth_value(value: object) -> object:
    """Return a truth value from one, or from its word, as the command line has it."""
    if isinstance(value, bool) or value in ("true", "false"):
        return value is True or value == "true"
    raise fault(f"{described(value)} is not possible, expected true or false")


Seed = Annotated[int, *whole_number(0, 2**63 - 1)]
"""Seed of random draws."""
TruthValue = Annotated[
    bool, BeforeValidator(_read_truth_value), WithJsonSchema({"type": "boolean"})
]
"""True or false, or the word for it."""


class Goals(Part):
    """Goals of `tendon design`, which chooses among the axes that are not its conditions."""

    conditions: Words | None = field_default(
        None,
        description="axes that a design must survive; default load, joint, anchor, setting, arm "
        "(not its contact_width), cases, people and uncertain numbers",
    )
    serve: Annotated[StudyNumber | None, SingleField("serve", _LEAST_SERVED, 1.0)] = None
    minimise: Words = field_default(
        (), description="columns of choices.parquet; several goals give a Pareto front"
    )
    maximise: Words = field_default(
        (), description="columns of choices.parquet; several goals give a Pareto front"
    )
    prove: RowWords = field_default(
        (), description="choices to prove besides the best, by their rows in choices.parquet"
    )
    by: Literal["sex"] | None = field_default(
        None, description="also give shares by this column of the people"
    )
    verify: Annotated[int, *whole_number(0, MOST_VERIFIED)] = field_default(
        10_000,
        description="number of fresh persons or draws that judge what was chosen; 0 for none",
    )
    pretension: Annotated[
        str | StudyNumber, _PretensionOrPlace("pretension", 0.0, 1e5, is_reading=True)
    ] = field_default(
        "reserve",
        description="place in its window at which a choice is set, or one pretension for all "
        "choices; reserve: the least and the accuracy of setting, the middle at most",
    )
    advice: TruthValue = field_default(
        default=True,
        description="name a choice that can be built and keeps what is advised for its parts "
        "before one that does not; no window changes",
    )


def _check_power_of_two(value: int) -> int:
    """Return 0 or a power of two; refuse any other number."""
    if value.bit_count() > 1:
        near = 1 << value.bit_length() - 1
        problem = f"{value:,} is not possible, expected a power of two, {MOST_DRAWS:,} at most"
        raise fault(problem, f"such as {near}")
    return value


class Uncertainty(Part):
    """Draws of the uncertain numbers, by scrambled Sobol points."""

    draws: Annotated[
        int,
        *whole_number(0, MOST_DRAWS),
        AfterValidator(_check_power_of_two),
        WithJsonSchema({"enum": [0, *(2**power for power in range(MOST_DRAWS.bit_length()))]}),
    ] = field_default(
        256,
        description="number of draws, a power of two; 0 takes the middle of every uncertain number",
    )
    seed: Seed = field_default(1, description="the same seed gives the same draws")
    usual: TruthValue = field_default(
        default=True,
        description="true has answers draw the usual deviations of numbers that state none and are "
        "not exact; false draws the study's own alone",
    )
    exact: Words = field_default(
        (),
        description="keys of numbers, or tables such as arm, that have no deviation: they are "
        "neither drawn nor fitted; tendon fit-suit also takes names of errors of sensors",
    )

    @property
    def asks_for_draws(self) -> bool:
        """True if the study says more here than which numbers have deviations."""
        about_deviations = {"exact", "usual"}
        return not self.model_fields_set or bool(self.model_fields_set - about_deviations)

    def is_exact(self, key: str) -> bool:
        """Return True if a number, its table, or an error of a sensor is named as exact."""
        paths = (f"{key}.", f"{split_side(key)[0]}.")
        return any(path.startswith(f"{name}.") for name in self.exact for path in paths)
