"""`--dry-run` says what a sweep will be, and writes nothing."""

import pytest

GRID = "{{ from = {low}, to = {high}, num = {num} }}"
MAP = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 25 }
[spool]
ratio = { from = 0.5, to = 1.2, num = 12 }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
"""
DESIGNS_ONLY = """
[spring]
stiffness = { from = "1 kN/m", to = "9 kN/m", num = 200, spacing = "log" }
[arm]
b1 = ["140 mm", "150 mm"]
[load]
mass = { from = 0, to = 9, num = 40 }
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 5 }
[output]
tables = ["designs"]
"""
ONE_DESIGN = '[motion]\nelbow_angle = { from = "0 deg", to = "175 deg", num = 40001 }\n'
PERSONS = """
[[cases]]
name = "small"
arm = { b1 = "140 mm", forearm_mass = "1.1 kg" }
[[cases]]
name = "tall"
sheath = { extensor = { friction = 0.1 } }
[load]
mass = { from = 0, to = 9, num = 60 }
[model]
slack = "bilateral"
"""
NULL_IN_THE_MIDDLE = """
[[cases]]
name = "first"
[[cases]]
name = "a flexor behind the joint"
arm = { a1 = "0 mm", a2 = "0 mm" }
[[cases]]
name = "last"
arm = { b1 = "160 mm" }
[tendon]
pretension = { from = "60 N", to = "240 N", num = 25 }
[load]
mass = { from = 0, to = 9, num = 12 }
[motion]
elbow_angle = { from = "-20 deg", to = "-1 deg", num = 50 }
"""
STUDIES = {"map": MAP, "designs": DESIGNS_ONLY, "one design": ONE_DESIGN, "persons": PERSONS}
UNLIKE = {"null in the middle": NULL_IN_THE_MIDDLE}
IN_PARTS = [*((name, part) for name in STUDIES for part in (None, 3000)), *((name, 10_000) for name in UNLIKE)]


def written(workplace):
    return sorted(str(item.relative_to(workplace)) for item in workplace.rglob("*"))


def predicted_and_swept(tendon, workplace, text):
    (workplace / "study.toml").write_text(text, encoding="utf-8")
    words = ("sweep", "study.toml", "--no-figures", "--json", "--allow-no-equilibrium")
    before = tendon(*words, "--dry-run")
    assert (before.exit, before.err) == (0, "")
    assert written(workplace) == ["study.toml"]
    return before.json, tendon(*words).json


@pytest.mark.parametrize(("name", "part"), IN_PARTS)
def test_rows_are_exact_and_bytes_within_a_fifth(tendon, workplace, small_parts, name, part):
    if part:
        small_parts(part)
    found, run = predicted_and_swept(tendon, workplace, (STUDIES | UNLIKE)[name])
    rows = {}
    for entry in run["files"]:
        table = entry["path"].split(".")[0]
        rows[table] = rows.get(table, 0) + entry["rows"]
    assert found["rows"] == rows
    assert (found["designs"], found["states"], found["parts"]) == (run["designs"], run["states"], run["parts"])
    size = sum(entry["size"] for entry in run["files"])
    assert abs(found["bytes"] / size - 1.0) <= 0.2


def test_the_page_has_axes_with_units_counts_bytes_time_and_memory(tendon, workplace):
    (workplace / "study.toml").write_text(MAP, encoding="utf-8")
    ran = tendon("sweep", "study.toml", "--dry-run")
    assert (ran.exit, ran.err) == (0, "")
    words = ["60 N to 240 N", "0.5 to 1.2", "0 kg to 10 kg", "0 deg to 90 deg", "900", "163,800", "MB", " s", "memory"]
    assert [word for word in words if word not in ran.out] == []
    assert written(workplace) == ["study.toml"]


def test_a_dry_run_touches_nothing_of_a_run_that_stands_there(tendon, workplace):
    (workplace / "study.toml").write_text(PERSONS, encoding="utf-8")
    tendon("sweep", "study.toml", "--no-figures")
    before = {item: item.stat().st_mtime_ns for item in workplace.rglob("*")}
    assert tendon("sweep", "study.toml", "--dry-run", "--overwrite").exit == 0
    assert tendon("sweep", "study.toml", "--dry-run", "--set", "tendon.length=3 m").exit == 0
    assert {item: item.stat().st_mtime_ns for item in workplace.rglob("*")} == before


def test_a_dry_run_of_a_hundred_terabytes_is_answered(tendon, workplace):
    grid = GRID.format(low='"1 N"', high='"2 N"', num=10**6)
    (workplace / "study.toml").write_text(
        f"[tendon]\npretension = {grid}\n[load]\nmass = [1, 2, 3]\n", encoding="utf-8"
    )
    ratios = ("--set", "spool.ratio={ from = 1, to = 2, num = 10000 }")
    found = tendon("sweep", "study.toml", "--dry-run", "--json", *ratios)
    assert (found.exit, found.json["designs"]) == (0, 3 * 10**10)
    assert found.json["bytes"] > 5e13
    assert found.json["peak_memory"] < 2e9
