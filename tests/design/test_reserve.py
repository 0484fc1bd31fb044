"""The pretension of a choice: the least that serves, and a reserve for how well it can be set."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import StudyError
from tendon_cli.studies.accuracy import Accuracy
from tests.answers import answered
from tests.sampled import quick_and_torture

from .studies import NO_UPPER_END

SUIT = {
    "load": {"mass": ["0 kg", "10 kg"]},
    "spring": {"stiffness": ["3 kN/m", "5 kN/m", "8 kN/m"]},
    "spool": {"ratio": [0.6, 0.5]},
}
PEOPLE = {"people": {"count": 6}, **SUIT}
OPEN = {**SUIT, "joint": NO_UPPER_END}
GAUGES = ["pretension", "flexor at joint", "extensor at joint", "flexor at motor"]


def choices_of(content, **setting):
    """Return the choices of a study with some keys of its setting."""
    return answered({**content, "setting": setting}).choices


CONTENTS = {"loads": SUIT, "people": PEOPLE, "open": OPEN}
FEW = [
    ("loads", "pretension"),
    ("loads", "extensor at joint"),
    ("people", "flexor at motor"),
    ("open", "flexor at joint"),
]
REST = [(name, read) for name in CONTENTS for read in GAUGES if (name, read) not in FEW]


@pytest.mark.parametrize(("name", "read"), quick_and_torture(FEW, REST))
def test_the_reserve_is_the_accuracy_but_never_beyond_the_middle(name, read):
    content = CONTENTS[name]
    choices = choices_of(content, read=read, accuracy="4 N")
    low = choices["pretension_from"]
    assert choices["pretension_to"].isna().any() == (content is OPEN)
    middle = 0.5 * (low + choices["pretension_to"].fillna(np.inf))
    expected = np.minimum(low + 4.0, middle)[choices["feasible"]]
    np.testing.assert_allclose(choices["pretension"][choices["feasible"]], expected, rtol=1e-12)


@pytest.mark.parametrize("read", quick_and_torture(GAUGES[1::2], GAUGES[::2]))
def test_a_length_is_as_good_as_the_tension_that_it_adds_to_each_choice(read):
    choices = choices_of(SUIT, read=read, accuracy="1.5 mm")
    row = choices.iloc[-1]
    reserve = row["pretension"] - row["pretension_from"]
    # The window is as wide in newtons as it is long in millimetres.
    half = 0.5 * (row["pretension_to"] - row["pretension_from"])
    assert reserve / half == pytest.approx(1.5e-3 / row["tolerance_length"], rel=1e-9)
    as_tension = choices_of(SUIT, read=read, accuracy=f"{float(reserve)!r} N")
    same = ["pretension", "max_tension"]
    np.testing.assert_allclose(
        as_tension[same].iloc[-1].astype(float), row[same].astype(float), rtol=1e-12
    )


def test_an_accuracy_of_nothing_is_the_least_and_a_poor_one_the_middle():
    least = tendon.design({**SUIT, "design": {"pretension": "least"}}).choices["pretension"]
    middle = tendon.design({**SUIT, "design": {"pretension": "middle"}}).choices["pretension"]
    np.testing.assert_array_equal(choices_of(SUIT, accuracy=0)["pretension"], least)
    np.testing.assert_array_equal(choices_of(SUIT, accuracy="10 cm")["pretension"], middle)
    usual = tendon.design(SUIT).choices["pretension"]
    assert ((least < usual) & (usual <= middle)).all()


def test_with_people_a_length_is_worth_the_tension_of_the_mean_man():
    alone = choices_of(SUIT, accuracy="2 mm")
    people = choices_of(PEOPLE, accuracy="2 mm")
    wide = people["tolerance_length"] > 2e-3
    assert wide.sum() >= 2

    def per_length(choices):
        width = choices["pretension_to"] - choices["pretension_from"]
        return 0.5 * width / choices["tolerance_length"]

    np.testing.assert_allclose(per_length(people)[wide], per_length(alone)[wide], rtol=1e-9)
    reserve = people["pretension"] - people["pretension_from"]
    np.testing.assert_allclose(reserve[wide], 2e-3 * per_length(alone)[wide], rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2 mm", Accuracy(0.002, None)),
        ("0.2 cm", Accuracy(0.002, None)),
        ("5 N", Accuracy(None, 5.0)),
        ("0 N", Accuracy(None, 0.0)),
        (0, Accuracy(0.0, None)),
    ],
)
def test_the_unit_says_what_the_accuracy_is_of(text, expected):
    study = tendon.study({"setting": {"accuracy": text}})
    assert study.setting.accuracy == expected
    assert tendon.study(study.document()).setting.accuracy == expected


@pytest.mark.parametrize("text", ["2", 2, True, "2 kg", "-1 mm", "1 m", "two mm", ["2 mm"], None])
def test_an_accuracy_that_is_neither_a_length_nor_a_tension_is_refused(text):
    with pytest.raises(StudyError) as told:
        tendon.study({"setting": {"accuracy": text}})
    assert "setting.accuracy" in str(told.value)
