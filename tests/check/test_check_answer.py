"""The gate of answers: closed where the choice named first fails or has moved, else open."""

import dataclasses
import json
import re

import pytest

import tendon_cli as tendon
from tendon_cli.checks.check import check
from tendon_cli.checks.check_answer import check_answer
from tendon_cli.checks.check_text import annotation
from tendon_cli.errors import InputError, UsageError

SUIT = {
    "name": "suit",
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}


@pytest.fixture(scope="session")
def gates(tmp_path_factory):
    """Return folders of answers for a suit, for one with other springs, and for one that fails."""
    folder = tmp_path_factory.mktemp("gates")
    studies = {
        "suit": SUIT,
        "stiffer": SUIT | {"spring": {"stiffness": "5.1 kN/m"}},
        "fails": SUIT | {"spool": {"ratio": 1.0}, "load": {"mass": ["0 kg", "10 kg"]}},
    }
    for name, study in studies.items():
        tendon.design(study, folder / name)
    return {name: folder / name for name in studies}


def record_of(folder):
    return json.loads((folder / "design.json").read_text())


def test_an_answer_whose_choice_does_passes(gates):
    assert check(gates["suit"]).holds
    assert check(gates["suit"]).record["best"] == record_of(gates["suit"])["best"]
    failed = check(gates["fails"])
    assert not failed.holds
    assert failed.record["conflicts"]


def test_a_choice_that_the_fresh_sample_refutes_fails(answered):
    answer = tendon.open(answered["v1"])
    assert check_answer(answer, 10).holds == answer.best["feasible"]
    for is_enough in (True, False):
        best = answer.best | {"feasible": is_enough}
        judged = dataclasses.replace(answer, record=answer.record | {"best": best})
        assert check_answer(judged, 10).holds == is_enough


def test_the_gate_closes_where_a_number_moved_by_more_than_the_tolerance(gates):
    apart = ["spring.stiffness"]
    before = record_of(gates["suit"])["best"]
    now = record_of(gates["stiffer"])["best"]
    names = ("pretension_from", "pretension_to", "pretension", "set_flexor_tension")
    shares = {name: abs(now[name] - before[name]) / max(now[name], before[name]) for name in names}
    checked = check(gates["stiffer"], gates["suit"], apart=apart)
    assert not checked.holds
    found = {change["name"]: change["change"] for change in checked.record["changes"]}
    for name, share in shares.items():
        assert found[name] == pytest.approx(share)
    largest = max(found.values())
    assert check(gates["stiffer"], gates["suit"], apart=apart, tolerance=largest).holds
    just_below = check(gates["stiffer"], gates["suit"], apart=apart, tolerance=0.999 * largest)
    assert len(just_below.record["changes"]) >= 1


def test_an_edit_of_the_study_closes_the_gate_until_its_key_is_named(gates):
    checked = check(gates["stiffer"], gates["suit"], tolerance=1e9)
    assert not checked.holds
    assert checked.record["edits"] == ["spring.stiffness"]
    assert "spring.stiffness was 5 kN/m, now 5.1 kN/m (--except spring.stiffness" in checked.text
    assert check(gates["stiffer"], gates["suit"], tolerance=1e9, apart=["spring"]).holds
    with pytest.raises(UsageError, match="no key"):
        check(gates["stiffer"], gates["suit"], apart=["spring.stifness"])


def test_a_window_that_is_lost_is_a_change_at_any_tolerance(gates):
    apart = ["spool.ratio", "load.mass"]
    checked = check(gates["fails"], gates["suit"], apart=apart, tolerance=1e9)
    assert not checked.holds
    assert "keeps the limits for as many as asked: no, was yes" in checked.text
    assert "window from: -, was " in checked.text
    back = check(gates["suit"], gates["fails"], apart=apart, tolerance=1e9)
    assert "keeps the limits for as many as asked: yes, was no" in back.text


def test_a_run_is_no_baseline_of_an_answer(gates, plain):
    with pytest.raises(InputError, match="expected an answer as baseline"):
        check(gates["suit"], plain)
    with pytest.raises(InputError, match="expected a sweep as baseline"):
        check(plain, gates["suit"])


def test_the_command_exits_with_0_or_4_and_annotates(tendon, gates):
    suit = str(gates["suit"])
    stiffer = str(gates["stiffer"])
    assert tendon("check", suit).exit == 0
    for name, code in (("suit", 0), ("fails", 4)):
        done = tendon("check", gates[name], "--json")
        assert done.exit == code
        for entry in ("best", "conflicts"):
            assert done.json[entry] == record_of(gates[name])[entry]
    words = ("check", stiffer, "--baseline", suit, "--except", "spring.stiffness")
    failed = tendon(*words, "--annotate", "--json")
    assert failed.exit == 4
    assert failed.json["holds"] is False
    assert failed.err.startswith("::error title=tendon check - changed::")
    assert failed.err.count("\n") == 1
    assert tendon(*words, "--tolerance", "0.5", "--annotate").err == ""


def test_an_annotation_is_one_line_in_the_form_that_github_reads():
    line = annotation("a: 3 % of\r\n  b\n" * 30, "changed")
    assert "\n" not in line
    assert "\r" not in line
    assert "3 %25 of%0D%0A  b" in line


def test_a_file_of_people_that_changed_is_named_without_its_content(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    people = tmp_path / "people.csv"
    for name, stature in (("before", 168), ("now", 181)):
        people.write_text(f"name,stature (cm)\nAda,{stature}\n")
        tendon.sweep({"people": {"file": "people.csv"}}, name)
    by_hash = r"people\.file was people\.csv \(\w{8}\), now people\.csv \(\w{8}\)"
    assert re.search(by_hash, check("now", "before").text)
    with pytest.raises(tendon.TendonError, match=by_hash):
        tendon.sweep({"people": {"file": "people.csv"}}, "before")
    compared = tendon.compare("before", "now")
    assert [found["key"] for found in compared.record["differences"]] == ["people.file"]
