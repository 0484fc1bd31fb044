"""A page of earlier results is named as such by the next run; one that is of them is not."""

import pytest

STUDY = """
[tendon]
pretension = ["90 N", "130 N"]
[spool]
ratio = [0.6, 0.5]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
"""


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("command", ["sweep", "design"])
def test_a_page_of_earlier_results_is_named(tendon, workplace, command):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    message = "report.html shows earlier results; `tendon report run` writes a new one"
    words = (command, "study.toml", "--out", "run")
    assert tendon(*words, "--no-figures").exit == 0
    page = workplace / "run/report.html"
    with_friction = (*words, "--no-figures", "--set", "sheath.friction=0.08", "--overwrite")
    page.write_text("<html>mine</html>", encoding="utf-8")
    assert "report.html" not in tendon(*with_friction).err  # of somebody else
    page.unlink()
    assert tendon(*words, "--no-figures", "--overwrite").exit == 0
    assert tendon("report", "run").exit == 0
    assert "report.html" not in tendon(*words).err  # figures are drawn, the results are the same
    assert "report.html" not in tendon(*words, "--no-figures", "--overwrite").err
    assert message in tendon(*with_friction).err
    assert "report.html" not in tendon(*with_friction, "--quiet").err
    assert tendon("report", "run").exit == 0
    assert "report.html" not in tendon(*with_friction).err
