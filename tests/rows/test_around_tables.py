"""Sums, names, cells, pages and results around tables keep their promises."""

import json
import threading

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError, StudyError
from tendon_cli.files import write_csv_rows
from tendon_cli.say import JointName, name_joint
from tendon_cli.studies.row_reading import known_columns

MOTION = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}}
DRAWS_USUAL = True
EXACT = {"uncertainty": {"usual": False}, "design": {"verify": 0, "advice": False}}


def springs(*rows):
    """Return a table of springs, each of a name, a stiffness and a price."""
    stated = [
        {"name": name, "spring.stiffness": stiffness, "price (EUR)": price}
        for name, stiffness, price in rows
    ]
    return {"name": "part", "rows": stated}


def study_of(*tables, **changes):
    """Return a study with tables, without usual deviations."""
    return {"table": list(tables), "load": {"mass": ["0 kg", "2 kg"]}, "motion": MOTION} | (
        EXACT | changes
    )


SPOOLS = {
    "name": "spool_",
    "rows": [
        {"name": "a", "spool.ratio": 0.6, "price (EUR)": 5},
        {"name": "b", "spool.ratio": 0.7, "price (EUR)": 6},
    ],
}


@pytest.mark.parametrize("unknown", ["on request", "1,200", None, ""])
def test_a_sum_over_a_part_of_unknown_price_is_null_and_last_and_named(unknown):
    parts = springs(("S5", "5 kN/m", 90), ("S8", "8 kN/m", unknown))
    goals = {"design": EXACT["design"] | {"minimise": ["price"]}}
    answer = tendon.design(study_of(parts, SPOOLS, **goals))
    choices = answer.choices
    price = choices["price"].astype(float)
    is_known = choices["part"] == "S5"
    own = choices["spool_"].map({"a": 5.0, "b": 6.0}).astype(float)
    np.testing.assert_array_equal(price[is_known], 2 * 90.0 + own[is_known])  # a pair
    assert price[~is_known].isna().all()
    assert answer.best["part"] == "S5"
    if unknown:
        assert f'S8 ("{unknown}")' in " ".join(answer.record["notes"])


def test_a_column_of_words_alone_has_no_sum():
    parts = springs(("S5", "5 kN/m", "A"), ("S8", "8 kN/m", "B"))
    run = tendon.sweep(study_of(parts))
    assert "price" not in run.designs
    assert run.designs["part_price"].tolist() == ["A", "A", "B", "B"]


@pytest.mark.parametrize("column", ["spring.stiffness (kN/m)", "price (EUR)"])
def test_a_cell_beyond_every_number_is_out_of_range(tmp_path, column):
    cells = {"name": "S5", "spring.stiffness (kN/m)": "5", "price (EUR)": "9"} | {column: "1e999"}
    (tmp_path / "parts.csv").write_text(",".join(cells) + "\n" + ",".join(cells.values()) + "\n")
    study = study_of({"name": "part", "file": str(tmp_path / "parts.csv")})
    with pytest.raises(InputError, match=r"1e999.* out of range"):
        tendon.study(study)


def test_the_order_of_the_keys_of_a_sample_does_not_choose_its_rows():
    between = {"spring.stiffness": "1 kN/m to 8 kN/m", "spool.ratio": "0.4 to 1.0"}
    tables = []
    for items in (between.items(), reversed(between.items())):
        sample = {"name": "s", "sample": "sobol", "count": 4, "between": dict(items)}
        designs = tendon.sweep(study_of(sample)).designs
        tables.append(designs[["spring_stiffness", "spool_ratio"]])
    pd.testing.assert_frame_equal(*tables)


def test_rows_may_be_numbers_of_numpy():
    kinds = (float, np.float64, np.float32, np.int64)
    runs = [
        tendon.sweep(study_of(springs(("a", kind(3000), kind(3)), ("b", kind(5000), kind(4)))))
        for kind in kinds
    ]
    for run in runs[1:]:
        pd.testing.assert_frame_equal(run.designs, runs[0].designs)


# --- Names ----------------------------------------------------------------------------------------


NAMES = {
    "choice": ("condition", "choices", "run", "index", "price"),
    "condition": ("conditions", "states", "persons", "level_0", "to"),
    "draw": ("draws", "designs", "people", "unfinished", "key", "x"),
}
"""Names that a table might share with a file, a column or an axis, by its role."""


@pytest.mark.parametrize("role", NAMES)
def test_a_table_of_any_name_is_refused_or_its_results_are_read_again(tmp_path, role):
    other = {
        "name": "another",
        "role": "choice" if role == "draw" else "draw",
        "rows": [{"name": "a", "spool.ratio": 0.6}, {"name": "b", "spool.ratio": 0.7}],
    }
    wrong = {}
    for name in NAMES[role]:
        table = springs(("a", "3 kN/m", 1), ("b", "5 kN/m", 2)) | {"name": name, "role": role}
        study = study_of(table, other, allow_implausible=True)
        try:
            answer = tendon.design(study, tmp_path / name)
        except StudyError:
            assert name in known_columns() or name == "price"
            continue
        again = tendon.open(tmp_path / name)
        tables = {file: again.table(file.removesuffix(".parquet")) for file in again.table_files}
        names = [table.column_names for table in tables.values()]
        is_right = again.text == answer.text and all(len(set(one)) == len(one) for one in names)
        is_right &= any(name in one for one in names)
        answer.to_xarray()
        if not is_right:
            wrong[name] = names
    assert wrong == {}


def test_every_result_of_drawn_rows_can_be_used_again(tmp_path):
    made = springs(("a", "3 kN/m", 1), ("b", "3.3 kN/m", 2)) | {"role": "draw"}
    study = study_of(made, spool={"ratio": [0.6, 0.7]})
    folder = tmp_path / "answer"
    answer = tendon.design(study, folder, figures=True)
    assert tendon.open(folder).text == answer.text
    assert tendon.check(folder, baseline=folder).holds
    assert tendon.compare(folder, folder).text
    assert tendon.report(folder).exists()
    assert answer.export("parameters", tmp_path / "parameters.csv").exists()
    assert tendon.design(study, folder, overwrite=True).text == answer.text


OWN = ("Elbow S5", "elbow inc", "an elbow & more", "Elbow")


@pytest.mark.parametrize("own", OWN)
def test_words_of_a_study_are_not_named_after_its_joint(own):
    joint = JointName.of("ankle", [own, "nothing about it"])
    text = name_joint(f"{own}: an elbow, the Elbow_angle, elbows and {own}", joint)
    assert text.startswith(f"{own}: ")
    assert text.endswith(own)
    if own.casefold() != "elbow":
        assert "an ankle" in text


def test_parts_keep_their_names_in_every_text_of_another_joint(tmp_path):
    parts = springs(("Elbow S5", "5 kN/m", 1), ("Ankle S8", "8 kN/m", 2))
    study = study_of(parts, joint={"name": "ankle"})
    answer = tendon.design(study, tmp_path / "answer")
    run = tendon.sweep(study, tmp_path / "run")
    texts = [answer.text, tendon.check(answer).text, tendon.check(run).text]
    texts += [tendon.report(result).read_text("utf-8") for result in (answer, run)]
    assert "Ankle S5" not in "".join(texts)
    assert all("Elbow S5" in text for text in texts[2:])


# --- Files and pages ------------------------------------------------------------------------------


def test_no_spreadsheet_runs_a_cell_that_tendon_writes(tmp_path):
    cells = ["=cmd|x", "+1", "@x", "-a", "-1.5e-3", "plain", 3]
    with (tmp_path / "a.csv").open("w") as file:
        write_csv_rows(file, [cells])
    written = (tmp_path / "a.csv").read_text().strip().split(",")
    assert written == ["'=cmd|x", "'+1", "'@x", "'-a", "-1.5e-3", "plain", "3"]
    answer = tendon.design(study_of(springs(("=cmd|x", "5 kN/m", "@x"))), tmp_path / "answer")
    text = answer.export("parameters", tmp_path / "b.csv").read_text("utf-8")
    assert ",=cmd" not in text
    assert ",@x" not in text


def test_a_page_of_very_many_rows_stays_small_has_the_best_and_says_what_it_leaves_out(tmp_path):
    between = {"spring.stiffness": "1 kN/m to 8 kN/m", "spool.ratio": "0.4 to 1.0"}
    sample = {"name": "s", "sample": "sobol", "count": 20_000, "between": between}
    answer = tendon.design(study_of(sample, motion={"elbow_angle": "45 deg"}), tmp_path / "answer")
    page = tendon.report(answer)
    assert page.stat().st_size < 5_000_000
    text = page.read_text("utf-8")
    assert "of 20000 values of s" in text
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])
    assert answer.best["s"] in data["axes"][0]["words"]


def test_a_page_knows_every_column_that_rows_carry(tmp_path):
    parts = springs(("a", "3 kN/m", 1.1), ("b", "5 kN/m", "on request"))
    run = tendon.sweep(study_of(parts, SPOOLS), tmp_path / "run")
    answer = tendon.design(study_of(parts, SPOOLS), tmp_path / "answer")
    for result in (run, answer):
        text = tendon.report(result).read_text("utf-8")
        data = json.loads(text.split('id="data">')[1].split("</script>")[0])
        columns = {column.get("name") for column in data["table"]["columns"]}
        assert {"price", "part_price", "spool__price"} <= columns


def test_a_spring_that_stands_nowhere_leaves_a_run_its_own(tmp_path):
    """The room for a spring is null beside an excursion, and not infinite."""
    angles = ["-10 deg", "40 deg", "90 deg", "130 deg"]
    travels = ["0 mm", "40 mm", "80 mm", "110 mm"]
    excursion = {"angle": angles, "flexor": travels, "extensor": travels}
    study = study_of(
        joint={"excursion": excursion},
        spring={"free_length": "70 mm +/- 2 mm"},
        uncertainty={"draws": 4, "usual": False},
    )
    run = tendon.sweep(study, tmp_path / "run")
    assert run.designs["min_spring_room"].isna().all()
    assert tendon.report(run).exists()


def test_a_declared_figure_has_the_columns_of_tables(tmp_path):
    figure = {"name": "f", "quantity": ["max_tension"], "x": "load.mass", "colour": "part"}
    parts = springs(("a", "3 kN/m", 1), ("b", "5 kN/m", 2))
    run = tendon.sweep(study_of(parts, figure=[figure]), tmp_path / "run", figures=True)
    assert (run.folder / "f.png").exists()


def test_threads_draw_at_once(tmp_path):
    run = tendon.sweep(study_of(springs(("a", "3 kN/m", 1), ("b", "5 kN/m", 2))), tmp_path / "run")
    failed = []

    def draw(number):
        try:
            for again in range(2):
                run.plot(out=tmp_path / f"{number}-{again}.png")
        except Exception as error:  # noqa: BLE001 - whatever it is
            failed.append(error)

    threads = [threading.Thread(target=draw, args=(number,)) for number in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
    pictures = {(tmp_path / f"{number}-1.png").read_bytes() for number in range(3)}
    assert len(pictures) == 1


def test_drawn_rows_may_set_limits(tmp_path):
    """Usual errors are told of a suit that keeps the limits of all rows."""
    rows = [{"name": name, "limits.max_tension": f"{name} N"} for name in ("400", "500")]
    study = {
        "spool": {"ratio": 0.4},
        "anchor": {"stiffness": "2 kN/m"},
        "motion": MOTION,
        "design": {"verify": 0, "advice": False},
        "table": [{"name": "rope", "role": "draw", "rows": rows}],
    }
    record = tendon.design(tendon.study(study), tmp_path / "answer").record
    assert {row["key"] for row in record["sensitivities"]} >= {"spool.ratio"}
    assert not tendon.open(tmp_path / "answer").is_negative
