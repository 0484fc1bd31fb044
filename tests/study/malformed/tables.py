"""Keys, tables, words, cases and settings that no study can have."""

from tendon_cli.errors import StudyError, UsageError

from .row import toml, yaml

TABLES = (
    toml("an unknown key", "nam = 'x'\n", "nam", "unknown key", 'did you mean "name"?', line=1),
    toml(
        "an unknown table",
        "[springs]\nstiffness = 3\n",
        "springs",
        "unknown key",
        'did you mean "spring"?',
        line=1,
    ),
    toml(
        "a key in the wrong table",
        "[arm]\nfriction = 0.1\n",
        "arm.friction",
        '"sheath.friction"',
        line=2,
    ),
    toml("a number of a table at the top", "b1 = 0.1\n", "b1", 'did you mean "arm.b1"?', line=1),
    toml(
        "a side that is not",
        "[tendon.flexer]\nlength = 2\n",
        "tendon.flexer",
        'did you mean "flexor"?',
        line=1,
    ),
    toml(
        "a key under a number", "[arm.b1]\nvalue = 1\n", "arm.b1", "in an uncertain number", line=1
    ),
    toml(
        "a number for the units of keys",
        "arm.b1.mm = 150\n",
        "arm.b1",
        'unknown "mm" in a grid',
        line=1,
    ),
    toml("a key that is empty", '"" = 1\n', "unknown key"),
    toml("a key with an escape", '"\\u001b[31mred" = 1\n', "red", "unknown key"),
    toml("a key of 100000 letters", f"{'a' * 100_000} = 1\n", "aaaaaaaa", "unknown key"),
    toml(
        "an unknown key with a long value",
        f"colour = '{'x' * 200_000}'\n",
        "colour",
        "unknown key",
        line=1,
    ),
    toml("a number for a table", "arm = 3\n", "arm", "expected a table", line=1),
    toml("a list of tables for a table", "[[arm]]\nb1 = 1\n", "arm", "expected a table"),
    toml("a table for the title", "[title]\nx = 1\n", "title", "not text", line=1),
    yaml("a table without content", "arm:\n", "arm", "has no value", line=1),
    yaml("a key that is a number", "arm: {1: 2}\n", "arm.1", line=1),
    yaml("a key that is a list", "? [a, b]\n: 2\n", "key", line=1),
)

WORDS = (
    toml("a name with a slash", 'name = "a/b"\n', "name", "a/b", "letters, digits", line=1),
    toml("a name of two dots", 'name = ".."\n', "name", "..", "not a name", line=1),
    toml("a name of 65 letters", f'name = "{"a" * 65}"\n', "name", "64 characters", line=1),
    toml("a name with an escape", 'name = "\\u001b[2J"\n', "name", "letters, digits", line=1),
    toml(
        "a direction that is not",
        "motion.direction = 'flexoin'\n",
        "motion.direction",
        '"flexion"',
        line=1,
    ),
    toml(
        "a direction twice",
        "motion.direction = ['flexion', 'flexion']\n",
        "motion.direction",
        "twice",
        line=1,
    ),
    toml(
        "a slack that is not",
        "model.slack = 'Bilateral'\n",
        "model.slack",
        'did you mean "bilateral"?',
        line=1,
    ),
    yaml("a name that is a date", "name: 2024-01-01\n", "name", "is not text", line=1),
    yaml("half a surrogate for a title", 'title: "\\ud800"\n', "title", line=1),
)

CASES = (
    toml("a case without a name", "[[cases]]\narm.b1 = 0.1\n", "cases.0.name", "missing", line=1),
    toml(
        "a case named twice",
        "[[cases]]\nname = 'a'\n[[cases]]\nname = 'a'\n",
        "cases.1.name",
        "two rows",
        line=4,
    ),
    toml(
        "a case with a list",
        "[[cases]]\nname = 'a'\narm.b1 = [0.1]\n",
        "cases.0.arm.b1",
        "a list",
        line=3,
    ),
    toml(
        "a case with a grid",
        "[[cases]]\nname = 'a'\n[cases.arm]\nb1 = { from = 0.1, to = 0.2, num = 2 }\n",
        "cases.0.arm.b1",
        "one value",
        line=4,
    ),
    toml(
        "a case with a curve",
        "[[cases]]\nname = 'a'\nload.torque = 'x.csv'\n",
        "cases.0.load.torque",
        "same for all",
    ),
    toml(
        "a case with a reading",
        "[[cases]]\nname = 'a'\nsetting.read = 'x'\n",
        "setting.read",
        "same for all rows",
    ),
    toml(
        "a case with a motion",
        "[[cases]]\nname = 'a'\nmotion.speed = 1\n",
        "cases.0.motion",
        "a study for each",
    ),
    toml(
        "a case of an axis of words",
        "spring.at = ['motor']\n[[cases]]\nname = 'a'\nspring.at = 'joint'\n",
        "is an axis",
    ),
    toml(
        "a spring nowhere",
        "spring.at = ['joint', 'hip']\n",
        "spring.at",
        '"joint" or "motor"',
        line=1,
    ),
    toml(
        "a case with cases",
        "[[cases]]\nname = 'a'\n[[cases.cases]]\nname = 'b'\n",
        "cases.0.cases",
        "unknown key",
    ),
    toml(
        "a case of an axis",
        "[load]\nmass = [1, 2]\n[[cases]]\nname = 'a'\nload.mass = 3\n",
        "cases.0.load.mass",
        "is an axis",
        line=5,
    ),
    toml(
        "a second case at fault",
        "[[cases]]\nname = 'a'\n[[cases]]\nnam = 'b'\n",
        "cases.1.nam",
        '"name"',
        line=3,
    ),
    toml("one table of cases", "[cases]\nname = 'a'\n", "cases", "[[cases]]"),
    yaml(
        "a case without a name",
        "cases:\n  - arm: {b1: 0.1}\n",
        "cases.0.name",
        "missing",
        line=2,
    ),
)


def setting(label, text, *says, kind=UsageError, study=""):
    """Return a malformed setting of the command line."""
    return toml(f"set {label}", study, *says, kind=kind, settings=(text,))


SETTINGS = (
    setting("without equals sign", "arm.b1", "arm.b1", "KEY=VALUE"),
    setting("without a key", "=3", "KEY=VALUE"),
    setting("a key of 100000 parts", ".".join("a" * 100_000) + "=3", "KEY=VALUE"),
    setting("an open list", "load.mass=[1, 2", "load.mass", "not TOML"),
    setting("a list of 300 kB", "load.mass=[" + "1," * 150_000 + "]", "load.mass", "256000"),
    setting("words in a list", "load.mass=[3 kg]", "load.mass", "not TOML"),
    setting(
        "a number below a number", "arm.b1.x=3", "arm.b1.x", "not a table", study="arm.b1 = 0.1\n"
    ),
    setting("a key with an escape", "\x1b[31m={", "set"),
    setting("a line after the value", "load.mass=[1, 2]\nx = 3", "load.mass"),
    setting("an unknown table", "amr.b1=3 mm", "amr", "unknown key", '"arm"', kind=StudyError),
)
