"""A page of earlier results is told as such, by whoever looks at the folder; one that is of them is not."""

import pytest

STUDY = '[spring]\nstiffness = ["3 kN/m", "5 kN/m"]\n[spool]\nratio = 0.6\n'


@pytest.fixture
def study(workplace):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")


@pytest.mark.parametrize("command", ["sweep", "design"])
def test_a_page_of_earlier_results_is_told(tendon, study, command):
    words = (command, "study.toml", "--out", "run", "--no-figures")
    assert tendon(*words).exit == 0
    assert tendon("report", "run").exit == 0
    assert "report.html" not in tendon(*words).err
    assert "report.html" not in tendon(*words, "--overwrite").err  # the same results
    assert "report.html" not in tendon("check", "run").err
    other = (*words, "--set", "sheath.friction=0.08", "--overwrite")
    told = "run/report.html is of earlier results; `tendon report run` writes it anew"
    assert told in tendon(*other).err
    assert told in tendon("check", "run").err
    assert "report.html" not in tendon(*words, "--set", "sheath.friction=0.08", "--quiet").err
    assert tendon("report", "run").exit == 0
    assert "report.html" not in tendon(*words, "--set", "sheath.friction=0.08").err


def test_drawing_figures_makes_no_page_stale(tendon, workplace):
    (workplace / "study.toml").write_text('[tendon]\npretension = ["90 N", "130 N"]\n[spool]\nratio = [1.0, 0.6]\n')
    assert tendon("sweep", "study.toml", "--out", "run", "--no-figures").exit == 0
    assert tendon("report", "run").exit == 0
    ran = tendon("sweep", "study.toml", "--out", "run")
    assert (ran.exit, "report.html" in ran.err) == (0, False)
    assert (workplace / "run/slack_map.png").exists()


@pytest.mark.parametrize("content", ["", "<html>mine</html>", '<meta name="tendon-origin" content="x">'])
def test_a_page_of_another_is_left_alone(tendon, study, workplace, content):
    assert tendon("sweep", "study.toml", "--out", "run", "--no-figures").exit == 0
    (workplace / "run/report.html").write_text(content, encoding="utf-8")
    assert "report.html" not in tendon("check", "run").err
