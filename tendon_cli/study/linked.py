"""Axes along which several numbers change together: a person's arm, a draw of the uncertain numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tendon_cli.model.kinematics import Array


@dataclass(frozen=True, eq=False)
class Linked:
    """A linked axis: what it is called in a study, and what each of its values sets."""

    key: str
    """Also its column."""
    names: Sequence[str]
    """Of its values, in order."""
    numbers: Mapping[str, Array]
    """Numbers that it sets, by their dotted keys, each of shape (len(names),), SI."""
    scales: Mapping[str, Array] = field(default_factory=dict)
    """Factors on numbers that stand elsewhere: in the study, on an axis, or on another linked axis."""

    def __len__(self) -> int:
        return len(self.names)
