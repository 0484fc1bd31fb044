"""`tendon design` from the command line: exit codes, output, and folders whole or not at all."""

import json
import signal

import pytest

from tendon_cli import kernel
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers import record as record_module
from tendon_cli.answers.choices import Choices
from tendon_cli.engine.windows import candidates

from .studies import CATALOGUE, LOADS, RANGES


@pytest.fixture
def study(workplace):
    """Return a function that writes a study and returns the name of its file."""

    def write(text):
        (workplace / "suit.toml").write_text(text, encoding="utf-8")
        return "suit.toml"

    return write


def test_an_answer_is_written_to_its_folder_and_exits_with_0_or_4(tendon, study, workplace):
    done = tendon("design", study(CATALOGUE), "--no-figures")
    assert done.exit == 0
    assert "springs of 5 kN/m with a spool ratio of 0.6 work for all 4 loads" in done.out
    assert "--why prints the whole answer" in done.out
    whole = tendon("design", study(CATALOGUE), "--no-figures", "--overwrite", "--why")
    record = json.loads((workplace / "results/suit-design/design.json").read_text("utf-8"))
    assert whole.out.startswith(record["text"])
    assert not done.out.startswith(record["text"])
    folder = workplace / "results" / "suit-design"
    files = {".lock", "choices.parquet", "conditions.parquet", "design.json"}
    assert {file.name for file in folder.iterdir()} == files
    assert [item.name for item in folder.parent.iterdir()] == ["suit-design"]
    done = tendon("design", study(LOADS), "--no-figures", "--json", "--overwrite")
    assert done.exit == 4
    assert done.json["best"] is None
    assert done.json["fixes"]
    assert done.json["conflicts"][0]["limits"] == ["extensor slack", "min_elbow_stiffness"]


def test_a_signal_while_an_answer_is_worked_out_ends_with_its_code(
    tendon, study, workplace, monkeypatch
):
    def interrupt(_, choices):
        signal.raise_signal(signal.SIGINT)
        return choices.select([0])

    file = study(RANGES + '[design]\nmaximise = ["tolerance"]\nminimise = ["max_tension"]\n')
    with monkeypatch.context() as patch:
        patch.setattr(candidates, "compromise", interrupt)
        patch.setattr(record_module, "sensitivities", lambda *_: pytest.fail("it went on"))
        done = tendon("design", file, "--no-figures", "--json")
    error = done.json["error"]
    assert done.exit == 130
    assert error["exit"] == 130
    assert error["kind"] == "stopped"
    assert "--resume" in error["hint"]
    assert not (workplace / "results/suit-design/design.json").exists()
    assert tendon("design", file, "--no-figures", "--resume", "--json").json["resumed_parts"] == 1


ONE_SUIT = '[spring]\nstiffness = "5 kN/m"\n[spool]\nratio = 0.6\n[load]\nmass = "3 kg"\n'
PEOPLE = ONE_SUIT + "[people]\ncount = 8\n"
DRAWS = ONE_SUIT + "[sheath]\nfriction = { mean = 0.07, std = 0.005 }\n[uncertainty]\ndraws = 8\n"
PARTS = [f"choices.parquet/part-0000{number}.parquet" for number in (0, 5)]
TO_REPAIR = [
    (RANGES, [*PARTS, "conditions.parquet"]),
    (CATALOGUE, ["choices.parquet"]),
    (PEOPLE, ["persons.parquet"]),
    (DRAWS, ["draws.parquet"]),
]


@pytest.mark.parametrize(
    ("text", "names"), TO_REPAIR, ids=["ranges", "catalogue", "people", "draws"]
)
def test_a_damaged_answer_is_repaired_to_the_same_bytes(
    tendon, study, workplace, monkeypatch, hashes_in, text, names
):
    monkeypatch.setattr(choices_module, "CHOICES_PER_PART", 9)
    file = study(f'{text}[design]\nmaximise = ["tolerance"]\nminimise = ["max_tension"]\n')
    words = ("design", file, "--no-figures", "--out", "out")
    assert tendon(*words).exit in (0, 4)  # 4: a fresh sample may refute what few persons chose
    before = hashes_in(workplace / "out")
    for name in names:
        (workplace / "out" / name).write_bytes(b"x")
        assert tendon(*words).exit == 7
        assert tendon(*words, "--resume", "--json").json["repaired"] == [name]
        assert hashes_in(workplace / "out") == before
    assert "up to date" in tendon(*words).out


RECORDS = {"sweep": "run.json", "design": "design.json"}


def test_an_answer_and_a_run_do_not_take_each_others_folder(tendon, study, workplace):
    file = study(CATALOGUE)
    for first, second in (("sweep", "design"), ("design", "sweep")):
        assert tendon(first, file, "--no-figures", "--out", first).exit in (0, 4)
        done = tendon(second, file, "--no-figures", "--out", first)
        assert done.exit == 7
        assert f"`tendon {first}` wrote it" in done.err
        assert tendon(second, file, "--no-figures", "--out", first, "--overwrite").exit == 0
        assert not (workplace / first / RECORDS[first]).exists()


@pytest.mark.usefixtures("blank_figures")
def test_missing_figures_are_drawn_and_nothing_is_solved(tendon, study, workplace, monkeypatch):
    file = study(CATALOGUE)
    before = tendon("design", file, "--no-figures", "--out", "out", "--json").json
    monkeypatch.setattr(Choices, "fill", lambda *_: pytest.fail("it is solved again"))
    monkeypatch.setattr(choices_module, "choose", lambda *_: pytest.fail("it is worked out again"))
    monkeypatch.setattr(kernel, "fold_window", lambda *_: pytest.fail("a window is solved"))
    drawn = tendon("design", file, "--out", "out", "--json").json
    assert drawn["figures"]
    assert all((workplace / "out" / name).exists() for name in drawn["figures"])
    assert tendon("report", "out", "--out", "page.html").exit == 0
    assert "The states of one choice" in (workplace / "page.html").read_text()
    assert tendon("design", file, "--dry-run").exit == 0
    changed = {name for name in drawn if drawn[name] != before.get(name)}
    assert changed <= {"figures", "figure_seconds", "checksum"}


BOX = """
spring = { stiffness = "5 kN/m" }
spool = { ratio = 0.6 }
sheath = { friction = { from = 0.05, to = 0.07 } }
"""


def test_a_dry_run_foresees_the_cells_that_a_proof_shows(tendon, study, monkeypatch):
    monkeypatch.setattr("tendon_cli.proof.subdivision.MOST_CELLS", 8 * 400)
    foreseen = tendon("design", study(BOX), "--dry-run", "--json").json
    assert foreseen["most_cells"] == 400
    assert foreseen["most_seconds"] > 0.0
    ran = tendon("design", study(BOX), "--no-figures")
    lines = [line for line in ran.err.splitlines() if "proof" in line]
    assert lines
    assert all(line.endswith(" of at most 400 cells") for line in lines)
    assert "proof" not in tendon("design", study(BOX), "--quiet", "--overwrite").err


def test_a_dry_run_shows_the_question_and_writes_nothing(tendon, study, workplace):
    done = tendon("design", study(CATALOGUE), "--dry-run", "--json")
    assert done.exit == 0
    assert done.json["choices"] == {"spring.stiffness": 3, "spool.ratio": 3}
    assert done.json["windows"] == 36
    assert not (workplace / "results").exists()
