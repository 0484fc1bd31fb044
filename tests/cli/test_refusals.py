"""Commands refuse alike: with one message or one JSON object, an exit code, and nothing written."""

import io
import math
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

import tendon_cli
from tests.sampled import check_all

FILES = {
    "study.toml": '[load]\nmass = ["0 kg", "3 kg"]\n[motion]\nelbow_angle = ["10 deg", "80 deg"]\n',
    "persons.toml": '[[cases]]\nname = "small"\n[[cases]]\nname = "tall"\n',
    "limited.toml": '[load]\nmass = ["0 kg", "5 kg"]\n[cases]\n',
    "route.csv": "x,y\n1,2\n",
    "straight.csv": "x,y,z\n" + "".join(f"{x},0,0\n" for x in range(9)),
    "junk.csv": "a,b\n1,x\n2,y\n",
    "nobody.csv": "weight (kg)\n",
    "wrong.csv": "weight (m)\n1\n",
    "file": "",
    "thesis/chapter.txt": "years of work",
    "empty/.keep": "",
}
LONG = "{ from = 1, to = 2, num = 10000000 }"
LONG_STIFFNESS = LONG.replace("= 1,", "= 1000,").replace("= 2,", "= 2000,")
TOO_LARGE = (
    f"sweep study.toml --set 'tendon.pretension={LONG}'"
    f" --set 'spring.stiffness={LONG_STIFFNESS}' --set 'spool.ratio={LONG}'"
)
PAST_REACH = "state study.toml --set 'motion.elbow_angle=170 deg' --reversal --plot motor.png"
FIT = "fit-friction table_a1.csv"
REFUSED = [
    # Words of the command line
    ("swoop", 2, "usage", "swoop"),
    ("sweep", 2, "usage", "STUDY"),
    ("sweep study.toml --frobnicate", 2, "usage", "No such option: --frobnicate"),
    ("sweep study.toml --overwrit", 2, "usage", "did you mean --overwrite"),
    ("sweep study.toml --resume --overwrite", 2, "usage", "conflict"),
    ("show run --csv --json", 2, "usage", "conflict"),
    ("check run --markdown --json", 2, "usage", "conflict"),
    ("sweep study.toml --jobs 0", 2, "usage", '"0" is not possible, expected a whole number, 1 or'),
    ("design study.toml --jobs two", 2, "usage", '"two" is not possible, expected a whole number'),
    ("check run --worst 0", 2, "usage", '"0" is not possible, expected a whole number, 1 or more'),
    ("show run --head -1", 2, "usage", '"-1" is not possible, expected a whole number, 0 or more'),
    ("state study.toml --draw 1.5", 2, "usage", '"1.5" is not possible, expected a whole number'),
    ("compare run run --choice -1", 2, "usage", '"-1" is not possible, expected a whole number'),
    (
        "export run --to mujoco a.xml --choice x",
        2,
        "usage",
        '"x" is not possible, expected a whole',
    ),
    ("check run --baseline run --tolerance x", 2, "usage", '"x" is not possible, expected a share'),
    ("check run --baseline run --tolerance -1", 2, "usage", "expected a share of a column's scale"),
    ("check run --tolerance 1e-3", 2, "usage", "--baseline"),
    ("show run --table desings", 2, "usage", 'did you mean "designs"?'),
    ("plot --arm persons.toml --case smal", 2, "usage", 'did you mean "small"?'),
    ("state persons.toml --case Tall", 2, "usage", 'did you mean "tall"?'),
    ("init new.toml --for desing", 2, None, 'did you mean "design"?'),
    ("init new.yaml --for sensitivity", 2, None, "templates: sweep, design"),
    ("init --from univrsal", 2, None, "universal"),
    ("init --from ../../setup.py", 2, None, "--list"),
    ("init --from universal --for motor", 2, None, "conflict"),
    ("init study.toml", 2, None, "study.toml"),
    ("init no/such/folder/study.toml", 5, None, "no/such/folder/study.toml"),
    # Studies
    ("sweep none.toml", 2, "study", "none.toml"),
    ("sweep study.toml --set arm.b1", 2, "usage", "KEY=VALUE"),
    ("sweep study.toml --set arm.bb=1", 2, "study", "b1"),
    ("sweep study.toml --set sheath.path=none.csv", 2, "study", "none.csv"),
    ("sweep study.toml --set sheath.path=route.csv", 3, "input", "route.csv"),
    (TOO_LARGE, 2, "size", ""),
    ("state study.toml --plot motor.png", 2, "usage", "no speed"),
    ("state study.toml --reversal --plot motor.bmp", 2, "usage", "png"),
    (PAST_REACH, 2, "usage", "no equilibrium"),
    ("plot persons.toml", 2, "usage", "is a study, expected a table or the folder of a run"),
    ("show study.toml", 2, "usage", "is a study"),
    # Folders
    ("sweep study.toml --no-figures --out file/inside", 5, "output", "Not a directory"),
    ("sweep study.toml --no-figures --out thesis", 7, "folder", "thesis"),
    ("sweep study.toml --no-figures --out study.toml", 7, "folder", "study.toml"),
    ("check nowhere", 3, "input", "nowhere: no such folder"),
    ("report nowhere", 3, "input", "nowhere: no such folder"),
    ("check run/designs.parquet", 3, "input", "a table in Parquet, expected the folder of a run"),
    ("plot empty", 3, "input", ""),
    ("show empty", 3, "input", "no table"),
    ("show nothing", 3, "input", "no such"),
    ("plot run --out nowhere/figure.png", 5, "output", "nowhere"),
    ("export run missing/all.csv", 5, "output", "cannot be written"),
    # Tables
    ("show run --columns load_mas", 2, "usage", 'did you mean "load_mass"'),
    ("show run --columns design,design", 2, "usage", "twice"),
    ("show run --where 'load_mas = 5 kg'", 2, "usage", 'did you mean "load_mass"'),
    ("plot run --where 'load_mass = 4 kg'", 2, "usage", "3 kg"),
    ("show run --where 'load_mass = 5 N'", 2, "usage", "load_mass = 5 N"),
    ("show run --where x", 2, "usage", "is not a filter"),
    ("show run --sort nothing", 2, "usage", "no column"),
    ("show run/designs.parquet --table states", 2, "usage", 'is one table, not "states"'),
    ("export run run/designs.parquet", 2, "usage", ".csv"),
    ("export run x.csv --locale nowhere", 2, "usage", "nowhere"),
    ("export run x.csv --units nowhere", 2, "usage", "nowhere"),
    ("show missing.csv", 3, "input", "missing.csv"),
    ("show junk.csv", 3, "input", "no column is a dimension"),
    ("show nobody.csv", 3, "input", "no persons"),
    ("show wrong.csv", 3, "input", 'weight: "m" is a length'),
    # Readings
    ("fit-friction junk.csv --bend-angle '144 deg'", 3, "input", "junk.csv"),
    (f"{FIT} --route straight.csv", 3, "input", ""),
    (f"{FIT} --route table_a1.csv", 3, "input", ""),
    (f"{FIT} --route turn.csv --bend-angle '180 deg'", 2, "usage", "--route"),
    (f"{FIT} --route turn.csv --plot turn.csv", 2, "usage", "would be overwritten"),
    (f"{FIT} --bend-angle '180 deg' --path-smoothing '1 mm'", 2, "usage", "no route"),
    (f"{FIT} --bend-angle '144 deg' --out same.svg --plot same.svg", 2, "usage", "the same file"),
    (f"{FIT} --route turn.csv --path-smoothing '1 kg'", 2, "usage", ""),
]


@pytest.fixture(scope="module")
def examples(tmp_path_factory, configs):
    """Return a folder with studies, routes, readings, a run, and files that are none of these."""
    folder = tmp_path_factory.mktemp("made")
    for name, content in FILES.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(content, encoding="utf-8")
    turn = np.linspace(0.0, math.pi, 51)
    points = 100.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    np.savetxt(folder / "turn.csv", points, delimiter=",", header="x_mm,y_mm,z_mm", comments="")
    shutil.copy(configs / "friction/table_a1.csv", folder)
    tendon_cli.sweep(folder / "study.toml", folder / "run")
    return folder


pytestmark = pytest.mark.usefixtures("blank_figures")


def contents():
    """Return the bytes of every file of the working directory by path, None for a folder."""
    return {path: path.read_bytes() if path.is_file() else None for path in Path().rglob("*")}


KINDS_OF_FILES = {
    "people.csv": "a CSV",
    "figure.png": "a figure",
    "figure.svg": "a figure",
    "page.html": "a page",
    "run.json": "JSON",
    "notes.txt": None,
    "study.toml": "a study",
    "run.parquet": "a table",
}
"""Kinds of files by their names, None for one that is not known."""
READERS = {
    "plot {}": "expected a table or the folder of a run",
    "show {}": "expected a table or the folder of a run",
    "export {} rows.csv": "expected a table or the folder of a run",
    "check {}": "expected the folder of a run",
    "check run --baseline {}": "expected the folder of a run",
    "report {}": "expected the folder of a run",
    "compare {} run": "expected the folder of a run",
    "plot --between {}": "expected the folder of a run",
    "sweep {} --dry-run": "expected a study",
    "state {}": "expected a study",
    "plot --arm {}": "expected a study",
    "fit-friction {}": "expected a CSV",
}
"""Words for the kind of file that each command expects."""
READ = {("show {}", "a CSV"), ("export {} rows.csv", "a CSV"), ("fit-friction {}", "a CSV")}
"""Commands that take files of a kind."""
READ |= {(line, "a table") for line in ("plot {}", "show {}", "export {} rows.csv")}
READ |= {(line, "a study") for line, expected in READERS.items() if expected == "expected a study"}


def test_a_file_of_another_kind_is_called_what_it_is(tendon, workplace, examples):
    shutil.copytree(examples, workplace, dirs_exist_ok=True)
    for file in KINDS_OF_FILES:
        if file != "study.toml":
            Path(file).write_bytes(b"name,weight (kg)\nAda,70\n")

    def check(line, expected, file, kind):
        ran = tendon(*shlex.split(line.format(file)))
        assert ran.exit in (2, 3)
        assert "damaged" not in ran.err
        if kind is not None:
            assert kind in ran.err
            assert expected in ran.err

    rows = [
        (line, expected, file, kind)
        for line, expected in READERS.items()
        for file, kind in KINDS_OF_FILES.items()
        if (line, kind) not in READ
    ]
    check_all(check, rows)


def test_a_file_of_a_run_in_place_of_its_folder_leads_to_the_folder(tendon, workplace, examples):
    shutil.copytree(examples, workplace, dirs_exist_ok=True)
    for line in ("show {}", "plot {}", "check {}", "report {}"):
        assert "name its folder: run" in tendon(*line.format("run/run.json").split()).err


def test_what_cannot_be_done_is_one_message_and_nothing_is_written(tendon, workplace, examples):
    shutil.copytree(examples, workplace, dirs_exist_ok=True)
    before = contents()

    def check(line, code, kind, message):
        words = shlex.split(line)
        has_json = "--json" in words
        if not has_json:
            ran = tendon(*words)
            assert (ran.exit, ran.out) == (code, ""), ran.err
            assert message in ran.err
            assert "Traceback" not in ran.err
            assert ran.err.startswith("tendon: error: ")
            assert ran.err.count("tendon: error: ") == 1
            words.append("--json")
        if kind is not None:
            ran = tendon(*words)
            error = ran.json["error"]
            assert list(ran.json) == ["error"]
            assert list(error) == ["exit", "kind", "message", "where", "hint"]
            assert (ran.exit, ran.err) == (code, "")
            assert (error["exit"], error["kind"]) == (code, kind)
            assert error["message"]
        assert contents() == before

    check_all(check, REFUSED)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "standard input is empty"),
        ("[load\n", "not TOML"),
        ("load: [\n", "not YAML"),
        ("x" * 300_000, "larger than 256 kB"),
    ],
)
def test_what_is_no_study_on_standard_input_is_refused(tendon, monkeypatch, text, expected):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    ran = tendon("sweep", "-")
    assert ran.exit == 2
    assert expected in ran.err
    assert ran.err.startswith("tendon: error: standard input")
