"""Every pair of results can be compared: equal to itself, and turned round only signs change."""

import json
from itertools import pairwise

import numpy as np
import pytest

import tendon_cli as tendon
from tests.answers import answered, merged

SUIT = {
    "name": "suit",
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}
SAMPLE = {
    "name": "sample",
    "sample": "sobol",
    "count": 8,
    "seed": 1,
    "role": "draw",
    "between": {"sheath.friction": "0.05 to 0.12", "arm.b1": "118 mm to 122 mm"},
}
ROWS = [
    {"name": "P1", "arm.b1": "118 mm"},
    {"name": "P2", "arm.b1": "122 mm", "sheath.friction": 0.09},
]
OF_EACH_KIND = {
    "exact": {},
    "choices for cases": {
        "spring": {"stiffness": ["4 kN/m", "5 kN/m"]},
        "cases": [{"name": "Ada", "arm": {"b1": "118 mm"}}, {"name": "Ben"}],
    },
    "no window": {"load": {"mass": ["0 kg", "30 kg"]}},
    "draws": {"sheath": {"friction": "0.07 +/- 0.01"}, "design": {"verify": 100}},
    "unjudged draws": {"sheath": {"friction": "0.07 +/- 0.01"}, "design": {"verify": 0}},
    "persons": {"people": {"count": 12, "seed": 1}, "design": {"verify": 100, "serve": 0.8}},
    "sample": {"table": [SAMPLE]},
    "drawn rows": {"table": [{"name": "prototype", "role": "draw", "rows": ROWS}]},
    "catalogue with limits": {
        "table": [{"name": "kit", "role": "choice", "rows": ROWS}],
        "limits": {"max_tension": ["250 N", "300 N"]},
    },
}
WITH_A_LARGER_SPOOL = ("exact", "draws", "persons", "in time")
"""Kinds of which there is a second study, with a larger spool."""
OPPOSITE = {"better": "worse", "worse": "better", "no difference": "no difference", None: None}


@pytest.fixture(scope="module")
def motion(tmp_path_factory):
    """Return the table of a motion in time, whose file is in a folder of the session."""
    time = np.arange(0.0, 4.0, 0.02)
    angle = 45.0 - 30.0 * np.cos(2.0 * np.pi * 0.5 * time)
    file = tmp_path_factory.mktemp("motion") / "motion.csv"
    np.savetxt(
        file, np.stack([time, angle], 1), "%.5f", ",", header="time (s),angle (deg)", comments=""
    )
    return {"trajectory": str(file), "cutoff": "4 Hz"}


@pytest.fixture(scope="module")
def studies(motion):
    """Return a study of each kind, and of some a second one."""
    kinds = {kind: merged(SUIT, content) for kind, content in OF_EACH_KIND.items()}
    kinds["in time"] = {**SUIT, "motion": motion}
    of_each = {
        kind: [merged(content, {"spool": {"ratio": 0.6}})] for kind, content in kinds.items()
    }
    for kind in WITH_A_LARGER_SPOOL:
        of_each[kind].append(merged(kinds[kind], {"spool": {"ratio": 0.62}}))
    return of_each


@pytest.fixture(scope="module")
def results(studies, tmp_path_factory):
    """Return answers and runs of each kind, in folders."""
    folder = tmp_path_factory.mktemp("runs")
    pairs = {}
    for kind, both in studies.items():
        pairs[f"answers, {kind}"] = [answered(study) for study in both]
        pairs[f"runs, {kind}"] = [
            tendon.sweep(study, folder / f"{kind} {place}", figures=False)
            for place, study in enumerate(both)
        ]
    return pairs


def test_a_result_is_equal_to_itself(results):
    odd = []
    for kind, (result, *_) in results.items():
        compared = tendon.compare(result, result)
        checked = tendon.check(result, result, tolerance=0.0)
        is_equal = compared.record["is_equal"] and "B: equal." in compared.text
        is_equal &= "they are the same study" in compared.text
        if not is_equal or not checked.holds or checked.record["changes"]:
            odd.append(kind)
    assert odd == []


def turned(number):
    """Return a quantity of a comparison as the comparison the other way round has it."""
    interval = number["interval"]
    return {
        **number,
        "a": number["b"],
        "b": number["a"],
        "verdict": OPPOSITE[number["verdict"]],
        "interval": interval and [-interval[1], -interval[0]],
        "spans": number["spans"][::-1],
    }


def test_the_order_of_two_results_changes_signs_alone(results):
    odd = []
    across = {
        f"{kind}, against {other}": (results[kind][0], results[other][0])
        for of_all in ("answers", "runs")
        for kind, other in pairwise(kind for kind in results if kind.startswith(of_all))
    }
    for kind, (first, second) in (pairs_of(results) | across).items():
        there = tendon.compare(first, second).record
        back = tendon.compare(second, first).record
        assert not there["is_equal"], kind
        units = [(number["unit"] or "").split(" or ") for number in there["quantities"]]
        assert all(len(both) == len({*both}) for both in units), kind
        mirrored = [turned(number) for number in back["quantities"]]
        for number, other in zip(there["quantities"], mirrored, strict=True):
            if json.dumps(number) != json.dumps(other) and not is_near(number, other):
                odd.append((kind, number["name"]))
        for name, other in (("gained", "lost"), ("why_gained", "why_lost")):
            if there[name] != back[other] or there[other] != back[name]:
                odd.append((kind, name))
        differs = [(one["key"], one["a"], one["b"]) for one in there["differences"]]
        assert differs == [(one["key"], one["b"], one["a"]) for one in back["differences"]]
    assert odd == []


def pairs_of(results):
    """Return the pairs of one kind."""
    return {kind: both for kind, both in results.items() if len(both) == 2}


def is_near(number, other):
    """Return True if two quantities differ by the rounding of an interval alone."""
    same = {name: value for name, value in number.items() if name != "interval"}
    is_same = all(other[name] == value for name, value in same.items())
    return is_same and number["interval"] == pytest.approx(other["interval"])


def test_a_gate_closes_where_a_comparison_sees_a_change(results):
    odd = []
    for kind, (first, second) in pairs_of(results).items():
        checked = tendon.check(second, first, apart=["spool.ratio"])
        if checked.holds or not checked.record["changes"]:
            odd.append(kind)
    assert odd == []


def test_a_suit_that_fewer_members_judge_is_paired_with_them(monkeypatch):
    """Along a motion a sample is thinned, so that it takes no longer than another one."""
    monkeypatch.setattr("tendon_cli.engine.windows.verification._FEWEST_MEMBERS", 8)
    drawn = merged(SUIT, OF_EACH_KIND["draws"])
    slower = merged(drawn, {"motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 9}}})
    answers = [answered(study) for study in (drawn, slower)]
    monkeypatch.setattr("tendon_cli.engine.windows.verification._MOST_STATES", 1200)
    compared = tendon.compare(*answers).record
    assert compared["paired"]
    assert compared["lost"]["of"] < 100


def test_spelling_is_no_difference():
    grid = merged(SUIT, {"spring": {"stiffness": {"from": "4 kN/m", "to": "5 kN/m", "num": 3}}})
    listed = merged(SUIT, {"spring": {"stiffness": [4000, 4500, 5000]}})
    assert tendon.compare(answered(grid), answered(listed)).record["differences"] == []


def test_digits_are_shown_until_two_texts_differ():
    near = merged(SUIT, {"spring": {"stiffness": "5.0001 kN/m"}})
    (found,) = tendon.compare(answered(SUIT), answered(near)).pairs[0].differences
    assert found.shown == ("5 kN/m", "5.0001 kN/m")


def test_rows_are_compared_by_what_they_set(tmp_path):
    """A sample and a file of its rows are one study; another row is told by its table and key."""
    drawn = answered(merged(SUIT, {"table": [SAMPLE]}))
    (table,) = drawn.study.row_tables
    for name, factor in (("same", 1.0), ("other", 1.001)):
        rows = [
            {
                "name": row,
                **{key: float(values[at]) * factor for key, values in table.numbers.items()},
            }
            for at, row in enumerate(table.names)
        ]
        content = {"name": "sample", "role": "draw", "rows": rows}
        answer = tendon.design(merged(SUIT, {"table": [content]}), tmp_path / name, figures=False)
        keys = [found["key"] for found in tendon.compare(drawn, answer).record["differences"]]
        expected = (
            [] if name == "same" else [f"table.sample.{key}" for key in sorted(table.numbers)]
        )
        assert keys == expected
        assert tendon.check(answer, drawn, apart=keys).holds == (name == "same")


def test_a_study_that_extends_another_differs_in_what_it_states(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base.toml").write_text('[spring]\nstiffness = "5 kN/m"\n[spool]\nratio = 0.6\n')
    (tmp_path / "more.toml").write_text('extends = "base.toml"\n[spool]\nratio = 0.62\n')
    first, second = (tendon.design(f"{name}.toml", name) for name in ("base", "more"))
    found = tendon.compare(first, second).record["differences"]
    assert [one["key"] for one in found] == ["spool.ratio"]
