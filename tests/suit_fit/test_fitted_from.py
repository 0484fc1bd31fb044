"""A study that takes the numbers of a fitted suit, and draws them as the fit knows them."""

import tomllib

import numpy as np
import pytest

import tendon_cli as tendon_library
from tendon_cli.errors import StudyError
from tendon_cli.fits.suit.suit_result import suit_fragment
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.values import draw_numbers

DESIGN = """\
fitted_from = "fit.toml"
[spool]
ratio = 0.6
[joint]
stiffness = "1.1 N m/rad"
rest_angle = "73 deg"
[design]
verify = 200
"""


@pytest.fixture
def study(fit, tmp_path):
    """Study that names the file of the fit."""
    (tmp_path / "fit.toml").write_text(suit_fragment(fit))
    (tmp_path / "design.toml").write_text(DESIGN)
    return tendon_library.study(tmp_path / "design.toml")


def test_answers_of_a_fitted_suit_differ_in_what_they_state(study, tmp_path):
    first, second = (
        tendon_library.design(study.vary(**{"spool.ratio": ratio}), tmp_path / f"{ratio}")
        for ratio in (0.6, 0.62)
    )
    assert tendon_library.compare(first, first).record["is_equal"]
    found = tendon_library.compare(first, second).record
    assert [difference["key"] for difference in found["differences"]] == ["spool.ratio"]
    assert found["paired"]
    assert not tendon_library.check(second, first, apart=["spool.ratio"]).holds


def covariance_of(draws, keys):
    return np.cov([draws[key] for key in keys])


@pytest.mark.parametrize("sampler", ["sobol", "random", "even"])
def test_draws_have_the_covariance_of_the_fit(fit, study, sampler):
    keys = ["sheath.friction", "tendon.pretension", "anchor.stiffness", "spring.stiffness"]
    draws = draw_numbers(study.uncertain, 8192, 1, study.correlation, sampler=sampler)
    drawn = np.corrcoef([draws[key] for key in keys])
    places = [fit.estimate.model.places[key] for key in keys]
    wanted = fit.estimate.covariance[np.ix_(places, places)]
    deviation = np.sqrt(np.diag(wanted))
    assert np.allclose(drawn, wanted / np.outer(deviation, deviation), atol=0.05)
    for key in keys:
        assert np.mean(draws[key]) == pytest.approx(fit.numbers[key].value, rel=0.03)
        assert np.std(draws[key]) == pytest.approx(fit.numbers[key].std, rel=0.1)


def test_the_file_has_the_variances_and_covariances_of_its_numbers(fit):
    content = tomllib.loads(suit_fragment(fit))
    keys = content["covariance"]["keys"]
    deviations = np.array([fit.numbers[key].std for key in keys])
    matrix = np.array(content["covariance"]["matrix"])
    np.testing.assert_allclose(np.sqrt(np.diag(matrix)), deviations, rtol=1e-9)
    places = [fit.estimate.model.places[key] for key in keys]
    scores = fit.estimate.covariance[np.ix_(places, places)]
    spread = np.sqrt(np.diag(scores))
    np.testing.assert_allclose(
        matrix / np.outer(deviations, deviations), scores / np.outer(spread, spread), atol=1e-9
    )


def test_the_record_of_a_study_draws_the_same(study):
    again = recorded_study(study.record)
    assert again.hash == study.hash
    assert again.correlation == study.correlation


def test_an_axis_of_the_study_stays(fit, tmp_path):
    (tmp_path / "fit.toml").write_text(suit_fragment(fit))
    text = DESIGN + '[spring]\nstiffness = ["4 kN/m", "6 kN/m"]\n'
    (tmp_path / "design.toml").write_text(text)
    study = tendon_library.study(tmp_path / "design.toml")
    assert study.axes == ("spring.stiffness",)
    assert any("spring.stiffness" in warning for warning in study.warnings)


def test_a_state_shows_fitted_and_stated(fit, study):
    page = tendon_library.state(study)
    lines = {line.formula: line.values for line in page.lines}
    fitted, stated = lines["tendon.pretension"]
    assert fitted == pytest.approx(fit.numbers["tendon.pretension"].value, rel=1e-6)
    assert stated == 100.0


def test_another_file_is_refused(tmp_path):
    (tmp_path / "fit.toml").write_text("[friction]\ncoefficient = 0.1\n")
    (tmp_path / "design.toml").write_text(DESIGN)
    with pytest.raises(tendon_library.InputError, match="not the numbers of a fitted suit"):
        tendon_library.study(tmp_path / "design.toml")


def test_the_command_writes_and_design_reads(tendon, logs, workplace):
    study = workplace / "study.toml"
    study.write_text(
        '[sheath]\nfriction = "0.03 to 0.25"\n[tendon]\npretension = "60 N to 300 N"\n'
        '[spring]\nstiffness = "5 kN/m"\n[anchor]\nstiffness = "5 kN/m to 30 kN/m"\n'
        '[joint]\nstiffness = "1.1 N m/rad +/- 0.5 N m/rad"\nrest_angle = "73 deg"\n'
        "[spool]\nratio = 0.6\n"
    )
    names = []
    for place, log in enumerate(logs):
        names.append(f"log{place}.csv")
        log.to_csv(names[-1], index=False)
    fit = ("fit-suit", "study.toml", *names)
    done = tendon(*fit, "--out", "fit.toml", "--plot", "fit.png", "--json")
    assert done.exit == 0
    assert done.json["numbers"]["sheath.friction"]["value"] == pytest.approx(0.09, rel=0.05)
    assert (workplace / "fit.png").read_bytes().startswith(b"\x89PNG")
    study.write_text(DESIGN)
    shown = tendon("state", "study.toml")
    assert shown.exit == 0
    assert "Fitted to the suit's logs" in shown.out
    (workplace / "mine.toml").write_text("mine")
    refused = tendon(*fit, "--out", "mine.toml")
    assert refused.exit == 2


def test_anchors_fitted_beside_a_file_of_persons_need_a_word_that_says_whose_they_are(
    fit, tmp_path
):
    """Anchors that were fitted on the wearer hold for her as they are."""
    fragment = tmp_path / "fit.toml"
    fragment.write_text(suit_fragment(fit))
    (tmp_path / "me.csv").write_text("name,sex,stature (cm)\nEve,female,152\n")
    file = tmp_path / "design.toml"
    persons = DESIGN + '[people]\nfile = "me.csv"\n'
    file.write_text(persons)
    with pytest.raises(StudyError, match=r"arm\.anchors: is needed because this study states arm"):
        tendon_library.study(file)

    fitted = fit.numbers["arm.b1"].value
    stated = {}
    for whose in ("measured", "mean man"):
        file.write_text(f'{persons}[arm]\nanchors = "{whose}"\n')
        space = space_of(tendon_library.study(file))
        stated[whose] = np.mean(space.number("arm.b1").within(space.whole))
    assert stated["measured"] == pytest.approx(fitted, rel=0.02)  # as the mean of draws
    assert stated["mean man"] < 0.95 * fitted


def test_measured_anchors_need_a_fit_that_has_some(tmp_path):
    (tmp_path / "fit.toml").write_text(
        '[numbers]\n"sheath.friction" = { value = 0.08, std = 0.002 }\n'
        '[covariance]\nkeys = ["sheath.friction"]\nmatrix = [[4e-6]]\n'
    )
    (tmp_path / "me.csv").write_text("name,sex,stature (cm)\nEve,female,152\n")
    file = tmp_path / "design.toml"
    file.write_text(DESIGN + '[people]\nfile = "me.csv"\n[arm]\nanchors = "measured"\n')
    with pytest.raises(StudyError, match=r"this study states none"):
        tendon_library.study(file)
    file.write_text(DESIGN + '[people]\nfile = "me.csv"\n')
    tendon_library.study(file)
