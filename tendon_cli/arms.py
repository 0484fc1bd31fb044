"""Arms with their sources, each a table that a study takes: `{"arm": tendon.arms.mean_woman}`.

>>> import tendon_cli as tendon
>>> round(tendon.arms.mean_woman["forearm_mass"], 3), tendon.arms.paper["b1"]
(1.491, '150 mm')
>>> tendon.study({"arm": tendon.arms.mean_woman}).arm.b1.single < 0.15
True
"""

from __future__ import annotations

from typing import Any

_NAMES = ("mean_man", "mean_woman", "paper")

_PAPER = (
    "Yadav et al., Modeling and parametric optimization of 3D tendon-sheath actuator system "
    "for upper limb soft exosuit"
)
_SURVEY = (
    "ANSUR II, the 2012 survey of US Army personnel (Gordon et al., NATICK/TR-15/007); "
    "forearm mass and its centre by Winter 2009, Table 4.1; anchors and elbow radius those of "
    "the paper, scaled to this body"
)


class NamedArm(dict[str, Any]):
    """The table `[arm]` of a study, with the name and the source of its numbers."""

    def __init__(self, name: str, numbers: dict[str, Any], source: str) -> None:
        super().__init__(numbers)
        self.name = name
        self.source = source

    def __repr__(self) -> str:
        from tendon_cli import say

        texts = []
        for key, value in self.items():
            number = say.number(value) if isinstance(value, float) else str(value)
            texts.append(f"{key} = {number}")
        return f"{self.name}: {', '.join(texts)}\n  source: {self.source}"


def __getattr__(name: str) -> NamedArm:
    """Return the arm of this name, computed when it is first used; numbers without unit are SI."""
    if name not in _NAMES:
        raise AttributeError(f"there is no arm {name!r}, expected one of {', '.join(_NAMES)}")
    if name == "paper":
        from tendon_cli.studies.parts import Arm

        fields = Arm.model_fields.items()
        stated = {key: field.default for key, field in fields if field.default is not None}
        return NamedArm("the paper's arm", stated, _PAPER)
    from tendon_cli import say
    from tendon_cli.studies.people.person import person_study
    from tendon_cli.studies.study import Study

    arm = person_study(Study(), name.replace("_", "-")).study.arm
    numbers = {}
    for key in type(arm).model_fields:
        values = getattr(arm, key)
        if values is not None:
            numbers[key] = values.single
    return NamedArm(f"the survey's {say.spaced(name)}", numbers, _SURVEY)
