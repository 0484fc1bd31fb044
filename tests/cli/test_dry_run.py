"""`--dry-run` says what a sweep will be, and writes nothing."""

import pytest

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
STUDIES = {"map": MAP, "designs": DESIGNS_ONLY, "persons": PERSONS, "null": NULL_IN_THE_MIDDLE}


@pytest.mark.parametrize("part", [None, 10_000])
@pytest.mark.parametrize("name", STUDIES)
def test_rows_are_exact_and_bytes_within_a_fifth(tendon, write_study, small_parts, name, part):
    if part:
        small_parts(part)
    write_study(STUDIES[name])
    words = ("sweep", "study.toml", "--no-figures", "--json", "--allow-no-equilibrium")
    dry_run = tendon(*words, "--dry-run")
    assert (dry_run.exit, dry_run.err) == (0, "")
    expected = dry_run.json
    run = tendon(*words).json
    rows = {}
    size = 0
    for entry in run["files"]:
        table = entry["path"].split(".")[0]
        rows[table] = rows.get(table, 0) + entry["rows"]
        size += entry["size"]
    assert expected["rows"] == rows
    for key in ("designs", "states", "parts"):
        assert expected[key] == run[key], key
    assert expected["bytes"] == pytest.approx(size, rel=0.2)


def test_the_page_has_axes_with_units_counts_bytes_time_and_memory(tendon, workplace, write_study):
    write_study(MAP)
    ran = tendon("sweep", "study.toml", "--dry-run")
    assert (ran.exit, ran.err) == (0, "")
    words = [
        "60 N to 240 N",
        "0.5 to 1.2",
        "0 kg to 10 kg",
        "0 deg to 90 deg",
        "900",
        "163,800",
        "MB",
        " s",
        "memory",
    ]
    assert [word for word in words if word not in ran.out] == []
    assert [item.name for item in workplace.iterdir()] == ["study.toml"]


def change_times(folder):
    """Return the time of the last change of everything in a folder, ns."""
    return {item: item.stat().st_mtime_ns for item in folder.rglob("*")}


def test_a_dry_run_touches_nothing_of_an_existing_run(tendon, workplace, write_study):
    write_study(PERSONS)
    tendon("sweep", "study.toml", "--no-figures")
    before = change_times(workplace)
    assert tendon("sweep", "study.toml", "--dry-run", "--overwrite").exit == 0
    assert tendon("sweep", "study.toml", "--dry-run", "--set", "tendon.length=3 m").exit == 0
    assert change_times(workplace) == before


HUGE = """
[tendon]
pretension = { from = 1, to = 2, num = 1000000 }
[load]
mass = [1, 2, 3]
"""


def test_a_dry_run_of_a_hundred_terabytes_is_answered(tendon, write_study):
    write_study(HUGE)
    ratios = ("--set", "spool.ratio={ from = 1, to = 2, num = 10000 }")
    ran = tendon("sweep", "study.toml", "--dry-run", "--json", *ratios)
    assert ran.exit == 0
    assert ran.json["designs"] == 3 * 10**10
    assert ran.json["bytes"] > 5e13
    assert ran.json["peak_memory"] < 2e9
