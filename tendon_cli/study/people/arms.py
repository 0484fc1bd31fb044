"""The arms that people have, as numbers of a study."""

from __future__ import annotations

from collections.abc import Container

from tendon_cli.model.body import anchor_scales, forearm_com, forearm_mass, load_distance
from tendon_cli.study.linked import Linked
from tendon_cli.study.people.population import Population

OF_THE_BODY = {
    "arm.forearm_mass": forearm_mass,
    "arm.forearm_com": forearm_com,
    "arm.load_distance": load_distance,
}
"""Numbers that come from the body, unless a study states them."""


def person_axis(key: str, people: Population, stated: Container[str]) -> Linked:
    """The axis of persons; `stated` are the numbers that the study itself gives."""
    body = people.body
    numbers = {name: of(body) for name, of in OF_THE_BODY.items() if name not in stated}
    scales = {f"arm.{name}": scale for name, scale in anchor_scales(body, people.reference).items()}
    return Linked(key, people.names, numbers, scales)
