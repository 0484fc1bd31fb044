"""No command replaces a file of the user; what tendon wrote may be replaced, the rest on demand."""

import shutil
from pathlib import Path

import pytest

import tendon_cli as tendon_library
from tendon_cli.errors import UsageError

STUDY = """
name = "mine"
[motion]
speed = "60 deg/s"
elbow_angle = ["90 deg", "60 deg", "20 deg"]
"""
PEOPLE = """\
name,sex,stature (cm),weight (kg)
Ada,f,165,60
Ben,m,181,82
"""
PNG_OF_THE_USER = (
    b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\10\2\0\0\0\x90wS\xde"
    b"\0\0\0\0IDAT tendon study mine " + 64 * b"0"
)
FOREIGN = {
    ".png": PNG_OF_THE_USER,
    ".svg": b"<svg><title>tendon study mine " + 64 * b"0" + b"</title></svg>",
    ".pdf": b"%PDF-1.4\n% a talk about the program tendon\n",
    ".csv": PEOPLE.encode(),
    ".html": b"<html>a page about tendon</html>",
    ".toml": b"# friction of my sheath, by `tendon fit-friction`\n",
}
"""Files of the user, some of which speak of tendon."""
WRITERS = {
    "export": ("export", "run", "out.csv"),
    "plot": ("plot", "run", "--out", "out.png"),
    "plot arm svg": ("plot", "--arm", "study.toml", "--out", "out.svg"),
    "plot between pdf": ("plot", "answer", "--between", "--out", "out.pdf"),
    "state": ("state", "study.toml", "--plot", "out.png"),
    "report": ("report", "run", "--out", "out.html"),
    "fit-friction figure": ("fit-friction", "log.csv", "--plot", "out.svg"),
    "fit-friction fragment": ("fit-friction", "log.csv", "--out", "out.toml"),
    "fit-friction strokes": ("fit-friction", "log.csv", "--strokes", "out.csv"),
}


pytestmark = pytest.mark.usefixtures("blank_figures")


@pytest.fixture(scope="module")
def made(tmp_path_factory, configs):
    """Return a folder with a study, its run, its answer and readings."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "study.toml").write_text(STUDY)
    (folder / "people.csv").write_text(PEOPLE)
    shutil.copy(configs / "friction" / "table_a1.csv", folder / "log.csv")
    tendon_library.sweep(folder / "study.toml", folder / "run")
    tendon_library.design(folder / "study.toml", folder / "answer")
    return folder


@pytest.fixture
def place(made, workplace):
    """Change into a copy of the folder and return it."""
    shutil.copytree(made, workplace, dirs_exist_ok=True)
    return workplace


@pytest.mark.parametrize("writer", WRITERS)
def test_a_file_of_the_user_is_replaced_only_on_demand(tendon, place, writer):
    words = WRITERS[writer]
    target = place / next(word for word in words if word.startswith("out."))
    theirs = FOREIGN[target.suffix]
    target.write_bytes(theirs)
    before = sorted(place.iterdir())

    refused = tendon(*words)
    assert refused.exit == 2
    assert "tendon did not write it" in refused.err
    assert "--overwrite" in refused.err
    assert target.read_bytes() == theirs
    assert sorted(place.iterdir()) == before

    assert tendon(*words, "--overwrite").exit in {0, 4}
    ours = target.read_bytes()
    assert ours != theirs
    # What tendon wrote is replaced without a word.
    assert tendon(*words).exit in {0, 4}
    assert target.read_bytes() == ours


@pytest.mark.parametrize("writer", [name for name in WRITERS if "plot" not in name])
def test_an_empty_file_a_link_that_leads_nowhere_and_a_folder_are_of_the_user(
    tendon, place, writer
):
    words = WRITERS[writer]
    target = place / next(word for word in words if word.startswith("out."))
    target.write_bytes(b"")
    assert tendon(*words).exit == 2
    assert target.read_bytes() == b""
    target.unlink()
    target.symlink_to("nowhere")
    assert tendon(*words).exit == 2
    assert target.is_symlink()
    target.unlink()
    target.mkdir()
    for more in ((), ("--overwrite",)):
        assert tendon(*words, *more).exit == 5
    assert list(target.iterdir()) == []


def test_no_page_is_written_if_one_of_them_would_replace_a_file(tendon, place):
    """The arm of a study has a second figure for its route."""
    points = [(0.01 * step, 0.02 * (step % 3), 0.0) for step in range(20)]
    lines = ["x (m),y (m),z (m)", *(f"{x},{y},{z}" for x, y, z in points)]
    (place / "route.csv").write_text("\n".join(lines) + "\n")
    words = ("plot", "--arm", "study.toml", "--set", "sheath.path=route.csv", "--out", "out.png")
    route = place / "out-route.png"
    route.write_bytes(PNG_OF_THE_USER)
    assert tendon(*words).exit == 2
    assert not (place / "out.png").exists()
    assert route.read_bytes() == PNG_OF_THE_USER
    assert tendon(*words, "--overwrite").exit == 0


def test_an_export_is_replaced_by_one_of_another_table_or_form(tendon, place):
    for table in ("states", "designs"):
        for form in ((), ("--locale", "de"), ("--units", "study")):
            assert tendon("export", "run", "out.csv", "--table", table, *form).exit == 0
            assert tendon("export", "run", "out.csv", "--table", "designs").exit == 0
            assert tendon("export", "answer", "out.csv").exit == 0


def test_a_csv_that_the_study_reads_is_never_taken_for_an_export(tendon, place):
    """A table of persons to which somebody joined results looks like an export."""
    lines = PEOPLE.splitlines()
    joined = ['"name","sex","stature (cm)","weight (kg)","margin (N)"']
    joined += [f"{line},12.5" for line in lines[1:]]
    persons = "\n".join(joined) + "\n"
    (place / "study.toml").write_text(STUDY + '[people]\nfile = "people.csv"\n')
    (place / "people.csv").write_text(persons)
    (place / "out.csv").write_text(persons.replace("Ada", "Eva"))
    swept = tendon("sweep", "study.toml", "--out", "of-joined", "--no-figures")
    assert swept.exit == 0, swept.err
    refused = tendon("export", "of-joined", "people.csv")
    assert refused.exit == 2
    assert "exists already, and the study reads it" in refused.err
    assert (place / "people.csv").read_text() == persons
    assert tendon("export", "of-joined", "people.csv", "--overwrite").exit == 0
    # A file with that header which the study does not read counts as an export.
    assert tendon("export", "of-joined", "out.csv").exit == 0


def test_no_command_writes_over_what_its_own_study_reads(tendon, place):
    """Not even on demand: the study would be lost with it."""
    rows = "# our own list\nname,spring.stiffness (kN/m)\nS5,5\nS8,8\n"
    (place / "springs.csv").write_text(rows)
    (place / "base.toml").write_text(STUDY)
    study = 'extends = "base.toml"\n[[table]]\nname = "spring"\nfile = "springs.csv"\n'
    (place / "parts.toml").write_text(study)
    (place / "link.csv").symlink_to("springs.csv")
    commands = [
        *(
            ("export", "parts.toml", name, "--table", "spring")
            for name in ("springs.csv", "link.csv")
        ),
        *(("plot", "parts.toml", "--arm", "--out", name) for name in ("parts.toml", "base.toml")),
    ]
    for words in commands:
        for more in ((), ("--overwrite",)):
            refused = tendon(*words, *more)
            assert refused.exit == 2, (words, more)
    assert (place / "springs.csv").read_text() == rows
    assert (place / "base.toml").read_text() == STUDY
    assert (place / "parts.toml").read_text() == study


def test_a_study_is_never_written_over(tendon, place):
    before = (place / "study.toml").read_bytes()
    assert tendon("init", "study.toml").exit == 2
    assert tendon("init", "new.toml").exit == 0
    assert tendon("init", "new.toml").exit == 2
    assert (place / "study.toml").read_bytes() == before


LIBRARY = {
    "run": lambda out, **how: tendon_library.open("run").plot(out=out, **how),
    "plot": lambda out, **how: tendon_library.plot(tendon_library.open("answer"), out=out, **how),
    "study": lambda out, **how: tendon_library.study("study.toml").plot(out=out, **how),
    "state": lambda out, **how: tendon_library.state("study.toml", plot=out, **how),
    "fit": lambda out, **how: tendon_library.fit_friction("log.csv").plot(out=out, **how),
    "report": lambda out, **how: tendon_library.report("run", out, **how),
}


@pytest.mark.parametrize("function", LIBRARY)
def test_the_library_keeps_the_same_rule(place, function):
    write = LIBRARY[function]
    target = Path("out.html" if function == "report" else "out.png")
    target.write_bytes(FOREIGN[target.suffix])
    with pytest.raises(UsageError, match="tendon did not write it"):
        write(target)
    assert target.read_bytes() == FOREIGN[target.suffix]
    write(target, overwrite=True)
    assert target.read_bytes() != FOREIGN[target.suffix]
