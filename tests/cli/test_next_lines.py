"""Lines that begin with "next:" are commands that work as typed."""

import shlex

import pytest

from tendon_cli.commands.starter import examples

DRAWS_USUAL = True  # a fit takes usual deviations for granted
COMPUTED = ("sweep", "design")


def typed(tendon, line):
    """Type the commands of a line, and return how the last one ended.

    What would compute is only looked at: `--dry-run` reads the study and its files.
    """
    ended = None
    for command in line.split(" && "):
        program, verb, *words = shlex.split(command)
        assert program == "tendon"
        dry = ["--dry-run"] if verb in COMPUTED else []
        ended = tendon(verb, *words, *dry)
        assert ended.exit == 0, (command, ended.err)
    return ended


def next_line(text):
    """Return the command behind "next:"; empty if a text has none."""
    return text.partition("next: ")[2].strip()


def type_what_init_says(tendon, name, *target):
    """Copy an example, and type what comes next."""
    ran = tendon("init", "--from", name, *target)
    assert ran.exit == 0, ran.err
    line = next_line(ran.out)
    if not line:
        assert '[[table]] with file = "' in ran.out
        return
    typed(tendon, line)


@pytest.mark.parametrize("name", [*examples()])
def test_what_init_says_next_works_as_typed(tendon, name):
    type_what_init_says(tendon, name)


@pytest.mark.parametrize("name", ["paper/fig08.toml", "table_a1.csv"])
def test_what_init_says_next_works_for_a_copy_elsewhere(tendon, workplace, name):
    (workplace / "a folder").mkdir()
    type_what_init_says(tendon, name, f"a folder/copy.{name.rpartition('.')[2]}")


def test_what_fit_suit_wrote_and_what_comes_next_is_said(tendon, workplace):
    folder = workplace / "my suit"
    folder.mkdir()
    study = "my suit/suit.toml"
    log = "my suit/suit_log.csv"
    tendon("init", "--from", "suit/suit.toml", study)
    tendon("init", "--from", "suit_log.csv", log)
    ran = tendon("fit-suit", study, log, "--out", "fit.toml")
    assert ran.exit == 0
    assert "fit.toml written" in ran.err
    ended = typed(tendon, next_line(ran.err))
    assert "load.mass 3" in ended.out
    (folder / "other.csv").write_bytes((workplace / log).read_bytes())
    other = tendon("fit-suit", study, "my suit/other.csv", "--out", "fit.toml")
    assert "fit.toml replaced; before, it held the numbers of suit_log.csv" in other.err
    (workplace / "mine.toml").write_text('fitted_from = "fit.toml"\n')
    swept = tendon("sweep", "mine.toml", "--no-figures")
    (warning,) = [line for line in swept.out.splitlines() if "middle value" in line]
    assert len(warning) < 200
    assert "arm.a1, arm.b1, arm.a2 and 17 more" in warning


def test_what_comes_next_copies_nothing_again_and_leaves_the_loads_of_a_table_alone(
    tendon, workplace
):
    tendon("init", "--from", "suit/suit.toml")
    line = next_line(tendon("init", "--from", "suit_log.csv").out)
    assert "init" not in line
    study = workplace / "suit.toml"
    rows = '{ name = "empty", "load.mass" = "0 kg" }, { name = "full", "load.mass" = "4 kg" }'
    study.write_text(f'{study.read_text()}\n[[table]]\nname = "task"\nrows = [{rows}]\n')
    fitted, _, _ = line.partition(" && ")
    ran = typed(tendon, fitted)
    assert "load.mass=" not in next_line(ran.err)
    assert "task 2" in typed(tendon, next_line(ran.err)).out
