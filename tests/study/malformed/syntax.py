"""Texts that are not TOML or YAML, or more of it than a study needs."""

from .row import toml, yaml

TOML_SYNTAX = (
    toml(
        "a quantity without quotes",
        "[arm]\na1 = 0.1\nb1 = 160 mm\n",
        "not TOML",
        '"160 mm"',
        line=3,
    ),
    toml(
        "a dotted key and then its table",
        'spring.stiffness = "3 kN/m"\nname = "x"\n[spring]\nat = "motor"\n',
        "spring is a table here, and line 1 has a key of it with a dot",
        'write line 1 below [spring], as: stiffness = "3 kN/m"',
        line=3,
    ),
    toml(
        "a Windows path in double quotes",
        '[sheath]\npath = "C:\\Users\\me\\route.csv"\n',
        "a backslash in double quotes begins an escape",
        "single quotes, 'C:\\Users\\me\\route.csv', or with /",
        line=2,
    ),
    toml("a key twice", "[arm]\nb1 = 1\nb1 = 2\n", "b1", "not TOML", line=3),
    toml(
        "a table opened twice",
        "[arm]\nb1 = 1\n[arm]\nb2 = 1\n",
        "[arm] is written twice, first in line 1",
    ),
    toml("an open table", "[arm\nb1 = 1\n", "not TOML", "[arm", line=1),
    toml("an open string", 'name = "a\n', "not TOML", line=1),
    toml("an open list", "[load]\nmass = [1, 2\n", "not TOML"),
    toml("no value", "[arm]\nb1 =\n", "not TOML", line=2),
    toml("YAML in a TOML file", "arm:\n  b1: 150 mm\n", "not TOML", line=1),
    toml("a decimal comma without quotes", "[load]\nmass = 1,5\n", "not TOML", line=2),
    toml("a bad escape", 'name = "\\q"\n', "not TOML", line=1),
    toml("half a surrogate", 'title = "\\ud800"\n', "not TOML", line=1),
    toml("a raw escape character", '[load]\nmass = "\x1b[31m"\n', "not TOML", line=2),
    toml("the right-to-left override", 'model.slack = "\u202eelbow"\n', "model.slack", line=1),
)

YAML_SYNTAX = (
    yaml("a key twice", "arm:\n  b1: 1\n  b1: 2\n", "b1", "duplicate", line=3),
    yaml("an open list", "load:\n  mass: [1, 2\n", "not YAML"),
    yaml("a wrong indent", "arm:\n  b1: 1\n b2: 1\n", "not YAML", line=3),
    yaml("a tab", "arm:\n\tb1: 1\n", "not YAML", line=2),
    yaml("two colons", "name: a: b\n", "not YAML", line=1),
    yaml("an anchor", "arm: &base\n  b1: 0.1\n", "anchors and aliases", line=1),
    yaml(
        "a billion laughs",
        "a: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\n",
        "anchors and aliases",
        line=1,
    ),
    yaml("a merge key", "arm:\n  <<: {b1: 0.1}\n", "arm.<<", "merge keys are not read", line=2),
    yaml(
        "an object of Python", "load: !!python/object:os.system {a: 1}\n", "tag", "not read", line=1
    ),
    yaml("a tag of ours", "load:\n  mass: !kg 5\n", "!kg", "leave it out", line=2),
    yaml("two documents", "name: a\n---\nname: b\n", "document", line=2),
    yaml("a list at the top", "- a\n- b\n", "no keys", line=1),
    yaml("a date that is none", "load: {mass: 2024-13-45}\n", "load.mass", "2024-13-45", line=1),
    yaml("a raw escape character", "load: {mass: '\x1b[31m'}\n", "not YAML", "#x001b"),
    yaml("TOML in a YAML file", "[arm]\nb1 = 1\n", "not YAML", line=2),
)

BLOCKS_33_DEEP = "".join(f"{' ' * depth}a:\n" for depth in range(33)) + " " * 33 + "b: 1\n"

LIMITS = (
    toml("over 256 kB", "#" * 300_000, "larger than 256 kB"),
    toml("a list of 100000 lists", f"x = {'[' * 100_000}\n", "deeper than 32 levels", line=1),
    toml("33 inline tables", f"x = {'{ a = ' * 33}1{' }' * 33}\n", "deeper than 32 levels", line=1),
    toml("a key of 100000 parts", f"{'.'.join('a' * 100_000)} = 1\n", "more than 16 parts", line=1),
    toml(
        "17 parts with spaces",
        f"name = 'a'\n{' . '.join('a' * 17)} = 1\n",
        "more than 16 parts",
        line=2,
    ),
    toml("a long key that ends in quotes", f'{"a" * 100_000}"b" = 1\n', "not TOML"),
    toml("a brace and 250000 lines", "a {\n" + "\n" * 250_000, "not TOML"),
    yaml("over 256 kB", "#" * 300_000, "larger than 256 kB"),
    yaml("100000 flow lists", f"x: {'[' * 100_000}\n", "deeper than 32 levels", line=1),
    yaml("33 block tables", BLOCKS_33_DEEP, "32 levels"),
    yaml("100000 question marks", "? " * 100_000, "deeper than 32 levels", line=1),
)
