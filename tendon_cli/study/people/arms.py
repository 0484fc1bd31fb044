"""The arms that people have, as numbers of a study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from tendon_cli.model.body import anchor_scales, forearm_com, forearm_mass, load_distance
from tendon_cli.model.kinematics import Array
from tendon_cli.study.linked import Linked

if TYPE_CHECKING:
    from tendon_cli.study.people.population import Population

OF_THE_BODY = {
    "arm.forearm_mass": forearm_mass,
    "arm.forearm_com": forearm_com,
    "arm.load_distance": load_distance,
}
"""Numbers that come from the body, unless a study states them."""


def person_axis(key: str, people: Population, of_the_body: Iterable[str], drawn: Mapping[str, Array]) -> Linked:
    """The axis of persons; `of_the_body` are those of `OF_THE_BODY` that the study does not state itself.

    `drawn` are uncertain numbers of which each person has one value.
    """
    body = people.body
    numbers = {**drawn, **{name: OF_THE_BODY[name](body) for name in of_the_body}}
    scales = {f"arm.{name}": scale for name, scale in anchor_scales(body, people.reference).items()}
    return Linked(key, people.names, numbers, scales)
