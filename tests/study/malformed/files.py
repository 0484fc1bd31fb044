"""Files that are no text, and files that a study names in vain."""

from tendon_cli.errors import InputError

from .row import toml

FILES = (
    toml(
        "not UTF-8", b"name = 'a'\ntitle = '\xe9'\n", "not UTF-8", "save the file as UTF-8", line=2
    ),
    toml("UTF-16", "title = 'x'\n".encode("utf-16"), "not UTF-8", "save the file as UTF-8"),
    toml("a NUL byte", b"name = 'a'\0\n", "not TOML", line=1),
    toml("a picture", b"\x89PNG\r\n\x1a\n", "not UTF-8"),
    toml("a file name that is no name", "", "name", "my study", stem="my study"),
)


def extending(label, base, *says, line=None, **more):
    """Return a study of three lines that extends the file base.toml."""
    text = '[spring]\nstiffness = "5 kN/m"\n'
    return toml(
        f"a base {label}", f'extends = "base.toml"\n{text}', *says, line=line, files=base, **more
    )


BASES = (
    extending("that is missing", {}, "extends", "base.toml", "no such file", line=1),
    extending("that is no TOML", {"base.toml": "[load\n"}, "base.toml, ", "not TOML", line=1),
    extending("that is not UTF-8", {"base.toml": b"# \xe9\n"}, "base.toml, ", "not UTF-8"),
    extending("that is empty text", {"base.toml": "x"}, "base.toml, ", "not TOML", line=1),
    extending("that is a list of one key", {"base.toml": "a=" + "[" * 40}, "base.toml", "nested"),
    extending(
        "with a fault",
        {"base.toml": '\n[load]\nmass = "3 N"\n'},
        "base.toml, line 3: load.mass",
        "is a force",
    ),
    extending(
        "that names a missing file",
        {"base.toml": 'sheath.path = "r.csv"\n'},
        "base.toml, line 1: sheath.path",
        "beside base.toml",
    ),
    extending(
        "that extends the study",
        {"base.toml": 'extends = "study.toml"\n'},
        "base.toml, line 1: extends",
        "study.toml extends base.toml extends study.toml",
    ),
    extending(
        "that extends itself",
        {"base.toml": 'extends = "./base.toml"\n'},
        "base.toml, line 1: extends",
        "cannot extend itself",
    ),
    toml("a base that is a CSV", 'extends = "r.csv"\n', "this is a CSV", files={"r.csv": "x\n"}),
    toml("a base that is a device", 'extends = "/dev/zero"\n', "extends", "a device", line=1),
    toml("a base that is a folder", 'extends = "."\n', "extends", "a folder", line=1),
    toml("a base from standard input", 'extends = "-"\n', "extends", "no such file", line=1),
    toml("a base with a NUL", 'extends = "a\\u0000"\n', "extends", "a NUL", line=1),
    toml("a base with an escape", 'extends = "\\u001b[31m"\n', "extends", "no such", line=1),
    toml("a base with a long name", f'extends = "{"a" * 300}.csv"\n', "too long", line=1),
    toml("a base without a name", 'extends = ""\n', "extends", "empty text", line=1),
    toml("two bases", 'extends = ["a.toml"]\n', "extends", "is not text", line=1),
    toml("a base that is a number", "extends = 1\n", "extends", "is not text", line=1),
    toml(
        "a key of a study above its base",
        'extends = "base.toml"\n[load]\nmass = "3 N"\n',
        "line 3: load.mass",
        line=3,
        files={"base.toml": 'load.mass = "3 kg"\n'},
    ),
    toml(
        "a setting above a base",
        'extends = "base.toml"\n',
        "load.mass",
        "is a force",
        files={"base.toml": 'load.mass = "3 kg"\n'},
        settings=("load.mass=3 N",),
    ),
    toml("a base in a setting", "", "extends", "no such file", settings=("extends=nowhere.toml",)),
    toml(
        "too many bases",
        'extends = "0.toml"\n',
        "more than 16 files",
        files={f"{at}.toml": f'extends = "{at + 1}.toml"\n' for at in range(20)},
    ),
)

ROUTE = "x,y,z\n0,0,0\n0.1,0,0\n0.2,0.1,0\n"
FRICTION = "[friction]\ncoefficient = 0.07\nstandard_error = 0.001\n"


def route(label, content, *says):
    """Return a study of a malformed route."""
    text = '[sheath]\npath = "r.csv"\n'
    return toml(f"route {label}", text, *says, kind=InputError, files={"r.csv": content})


def fragment(label, content, *says):
    """Return a study of a malformed friction fragment."""
    text = '[sheath]\nfriction_from = "f.toml"\n'
    return toml(f"fragment {label}", text, *says, kind=InputError, files={"f.toml": content})


ATTACHMENTS = (
    toml("a missing route", '[sheath]\npath = "r.csv"\n', "sheath.path", "r.csv", "no file"),
    toml(
        "a missing route of one side",
        'sheath.flexor.path = "r.csv"\n',
        "sheath.flexor.path",
        "no file",
    ),
    toml("a folder for a route", '[sheath]\npath = "."\n', "sheath.path", "it is a folder"),
    toml("a route with an escape", '[sheath]\npath = "\\u001b[31m"\n', "sheath.path"),
    toml(
        "a route of 4000 letters",
        f'[sheath]\npath = "{"a" * 4000}"\n',
        "sheath.path",
        "cannot be read",
    ),
    toml(
        "a bend beside a route",
        '[sheath]\nbend_angle = "90 deg"\npath = "r.csv"\n',
        "sheath.bend_angle",
        "cannot be given with path",
        line=2,
        files={"r.csv": ROUTE},
    ),
    toml(
        "a friction beside a fragment",
        '[sheath]\nfriction = 0.1\nfriction_from = "f.toml"\n',
        "sheath.friction",
        "cannot be given with friction_from",
        line=2,
        files={"f.toml": FRICTION},
    ),
    toml(
        "a smoothing without a route",
        "sheath.path_smoothing = '1 mm'\n",
        "sheath.path_smoothing",
        "names none",
        line=1,
    ),
    toml(
        "a friction of a fragment beyond any sheath",
        '[sheath]\nfriction_from = "f.toml"\nbend_angle = "100 rad"\n',
        "friction",
        "bend_angle",
        files={"f.toml": "[friction]\ncoefficient = 9\nstandard_error = 0.1\n"},
    ),
    route("without content", "", "the file is empty"),
    route("of a header", "x,y,z\n", "no way-points"),
    route("of one point", "x,y,z\n0,0,0\n0,0,0\n", "fewer than two"),
    route("without z", "x,y\n0,0\n1,1\n", "no column z", "x, y"),
    route(
        "of an unknown unit",
        "x_furlong,y,z\n0,0,0\n1,1,1\n",
        "unknown unit",
        "furlong",
    ),
    route(
        "with a word after comments", "# a\n\nx,y,z\n0,0,0\n# b\n1,zz,0\n", 'y is "zz"', "line 6"
    ),
    route("with a short row", "x,y,z\n0,0,0\n1,2\n", "2 cells where the header has 3", "line 3"),
    route("with 1e300", "x,y,z\n0,0,0\n1e300,0,0\n", "x is 1e+300", "line 3"),
    route("with decimal commas", "x,y,z\n0;0;0\n1,5;0;0\n", "separated by comma", "line 1"),
    route("of an open quote", 'x,y,z\n0,0,0\n"1,0,0\n2,0,0\n', "not a row of CSV", "line 3"),
    route("over 16 MB", b"x,y,z\n" + b"0,0,0\n" * 2_700_000, "larger than 16 MB"),
    route("of steps of 1e-320", "x,y,z\n0,0,0\n1e-320,0,0\n2e-320,1e-320,0\n", "way-points"),
    fragment("without content", "", "not a friction fragment"),
    fragment("that is no TOML", "[friction\n", "not a friction fragment"),
    fragment("without an error", "[friction]\ncoefficient = 0.1\n", "not a friction fragment"),
    fragment(
        "with a huge error",
        "[friction]\ncoefficient = 0.1\nstandard_error = 1e9\n",
        "not between 0 and 10",
    ),
    fragment(
        "of nan", "[friction]\ncoefficient = nan\nstandard_error = 0\n", "not a friction fragment"
    ),
    fragment(
        "of a truth value", "[friction]\ncoefficient = true\nstandard_error = 0\n", "friction"
    ),
    fragment(
        "of a hexadecimal",
        f"[friction]\ncoefficient = 0x{'f' * 1000}\nstandard_error = 0\n",
        "friction",
    ),
    fragment("over 256 kB", FRICTION + "#" * 300_000, "larger"),
)
