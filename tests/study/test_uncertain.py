"""Uncertain numbers: how a study states them, and that it computes with their middle."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tendon_cli as tendon
from tendon_cli.fits.friction import write_fragment
from tendon_cli.studies.load import load_study, study_from

TABLE = Path(__file__).parents[2] / "configs" / "friction" / "table_a1.csv"


def spring(stiffness):
    """Return a study that states the stiffness of its springs."""
    return study_from({"spring": {"stiffness": stiffness}})


@pytest.mark.parametrize(
    ("stiffness", "kind", "spread"),
    [
        ({"value": "3 kN/m", "tolerance": "10 %"}, "uniform", 300.0),
        ({"value": "3 kN/m", "tolerance": "0.1 N/mm"}, "uniform", 100.0),
        ({"value": 3000, "tolerance": "10%"}, "uniform", 300.0),
        ({"mean": "3 kN/m", "std": "50 N/m"}, "normal", 50.0),
    ],
)
def test_an_uncertain_number_has_a_middle_and_a_spread(stiffness, kind, spread):
    study = spring(stiffness)
    assert list(study.uncertain) == ["spring.stiffness"]
    distribution = study.uncertain["spring.stiffness"]
    assert distribution.kind == kind
    assert distribution.middle == 3000.0
    assert distribution.spread == spread
    assert study.spring.stiffness.single == 3000.0
    assert study.axes == ()
    assert study.hash != spring("3 kN/m").hash


@pytest.mark.parametrize(
    ("text", "table"),
    [
        ("3 kN/m +/- 50 N/m", {"mean": "3 kN/m", "std": "50 N/m"}),
        ("3 +/- 0.05 kN/m", {"mean": "3 kN/m", "std": "50 N/m"}),
        ("3 kN/m±0.05 N/mm", {"mean": "3 kN/m", "std": "50 N/m"}),
        ("2.7 N/mm to 3.3 kN/m", {"value": "3 kN/m", "tolerance": "10 %"}),
    ],
)
def test_numbers_as_people_write_them_are_the_same_distributions(text, table):
    study = spring(text)
    (distribution,) = study.uncertain.values()
    (expected,) = spring(table).uncertain.values()
    assert distribution.kind == expected.kind
    assert distribution.middle == expected.middle
    assert distribution.spread == expected.spread
    document = json.loads(json.dumps(study.document()))
    assert study_from(document).hash == study.hash
    assert spring(["2 kN/m", "3 kN/m"]).hash != study.hash


def test_an_interval_is_answered_for_as_the_list_of_its_ends():
    numbers = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    interval = {"load": {"mass": {"from": "0 kg", "to": "10 kg"}}}
    ends = {"load": {"mass": ["0 kg", "10 kg"]}}
    columns = ["pretension_from", "pretension_to"]
    windows = tendon.design(study_from(numbers | interval)).choices[columns]
    expected = tendon.design(study_from(numbers | ends)).choices[columns]
    np.testing.assert_array_equal(windows, expected)


@pytest.mark.parametrize("ratio", [{"value": 1.0, "tolerance": "0 %"}, {"mean": 1.0, "std": 0}])
def test_a_number_of_no_width_is_one_like_any_other(ratio):
    study = study_from({"spool": {"ratio": ratio}})
    assert study.uncertain == {}
    assert study.hash == study_from({}).hash


@given(st.floats(10.0, 1e6), st.decimals(0, 99, places=3), st.booleans())
def test_a_document_reads_back_as_the_same_distribution(middle, share, is_absolute):
    width = middle * float(share) / 100
    tolerance = f"{width!r} N/m" if is_absolute else f"{share} %"
    study = spring({"value": middle, "tolerance": tolerance})
    again = study_from(json.loads(json.dumps(study.document())))
    assert again.hash == study.hash
    assert again.uncertain == study.uncertain


def test_a_fitted_friction_brings_its_standard_error_but_to_a_case(tmp_path):
    (tmp_path / "f.toml").write_text("[friction]\ncoefficient = 0.073\nstandard_error = 0.002\n")
    path = tmp_path / "study.toml"
    path.write_text("[sheath.flexor]\nfriction_from = 'f.toml'\n")
    (distribution,) = load_study(path).uncertain.values()
    assert distribution.kind == "normal"
    assert distribution.middle == 0.073
    assert distribution.spread == 0.002
    assert distribution.low == 0.0
    path.write_text("[[cases]]\nname = 'a'\nsheath.friction_from = 'f.toml'\n")
    study = load_study(path)
    assert study.uncertain == {}
    assert study.cases.numbers["sheath.friction"].tolist() == [0.073]


def test_a_fitted_product_with_the_bend_is_taken_with_the_bend_beside_it(tmp_path):
    fit = tendon.fit_friction(TABLE)
    write_fragment(fit, tmp_path / "f.toml")
    path = tmp_path / "study.toml"
    path.write_text('[sheath]\nfriction_from = "f.toml"\nbend_angle = "144 deg"\n')
    friction = tendon.fit_friction(TABLE, "144 deg").friction
    assert load_study(path).sheath.friction.single == pytest.approx(friction, rel=1e-12)
    assert fit.friction_bend == pytest.approx(friction * np.radians(144.0), rel=1e-12)
    for bend in ('bend_angle = ["144 deg", "180 deg"]\n', ""):
        path.write_text(f'[sheath]\nfriction_from = "f.toml"\n{bend}')
        with pytest.raises(tendon.TendonError, match=r"a single sheath\.bend_angle"):
            load_study(path)


def test_what_a_normal_number_loses_where_it_is_impossible():
    def mass(std):
        study = study_from({"load": {"mass": {"mean": "1 kg", "std": std}}})
        return study.uncertain["load.mass"]

    wide = mass("1 kg")
    assert wide.cut_share == pytest.approx(0.158655, abs=1e-6)  # of a standard normal, below -1
    assert wide.reach == (0.0, 5.0)
    assert mass("10 g").cut_share < 1e-300
    uniform = spring({"value": 100, "tolerance": "10 %"}).uncertain["spring.stiffness"]
    assert uniform.reach == (90.0, 110.0)


def test_a_product_of_frictions_that_may_be_drawn_is_bounded_too():
    friction = {"value": 1, "tolerance": "10 %"}
    sheath = {"friction": friction, "bend_angle": "100 rad"}
    with pytest.raises(Exception, match="friction x bend_angle reaches 110"):
        study_from({"sheath": sheath, "allow_implausible": True})


@pytest.mark.parametrize(("step", "num"), [("1 deg", 91), ("0.1 deg", 901), ("90 deg", 2)])
@pytest.mark.parametrize(
    ("first", "last"), [(0, "90 deg"), ("90 deg", "0 deg"), ("-45 deg", "45 deg")]
)
def test_a_grid_of_steps_is_the_grid_of_that_many_values(step, num, first, last):
    def motion(**spacing):
        return study_from({"motion": {"elbow_angle": {"from": first, "to": last, **spacing}}})

    stepped = motion(step=step)
    counted = motion(num=num)
    assert stepped.hash == counted.hash
    assert len(stepped.motion.elbow_angle) == num
