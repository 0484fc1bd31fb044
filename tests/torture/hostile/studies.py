"""Hostile studies."""

import json
from pathlib import Path

from hypothesis import strategies as st

from .edits import EDITS, edited

STUDY_TOKENS = [
    b"nan", b"-inf", b"1e400", b"9**9**9 m", b'"9**9**9 m"', b'"1e-400 N"', b"[[cases]]", b"[[[", b"]]", b"{", b"}",
    b"{{", b'"""', b"'''", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\t", b"\r", b"# ", b"&a ", b"*a", b"<<: *a",
    b"!!python/object:os.system ", b"--- ", b"...", b"? ", b"- ", b"|", b">", b"true", b"null", b"~", b"2020-01-01",
    b"0x10", b"1_0", b'"1 parsec"', b'"-1 N"', b'"0 kg"', b"[]", b'["1 N", "2 N"]',
    b'{ from = "0 N", to = "1 N", num = 3 }', b"{ from = 0, to = 1, num = 99999999 }",
    b'{ from = 1, to = 1e300, num = 5, spacing = "log" }', b"a.b.c.d.e.f.g = 1", b"model.slack",
    b"sheath.flexor.friction", b"path = '/dev/zero'", b'friction_from = "study"', b"\xc2\xb5", b"\xe2\x80\xae",
    b"9" * 400, b"1" * 4301, b"[" * 40, b"a." * 20, b"num", b"direction", b"elbow_angle", b'"180 deg"', b"1e308",
    b"-0.0", b'"case"', b"name", b"\\u0000", b'"\\ud800"',
]  # fmt: skip
PLAIN_TOML = b"""name = "a"
[load]
mass = ["0 kg", "3 kg"]
[sheath.flexor]
friction = 0.1
[[cases]]
name = "x"
arm.b1 = "160 mm"
"""
PLAIN_YAML = b"""name: a
load:
  mass: [0 kg, 3 kg]
cases:
  - name: x
    arm: {b1: 160 mm}
motion:
  elbow_angle: {from: 0 deg, to: 90 deg, num: 4}
"""


def study_trees():
    """Documents of any shape, of which most keys are keys of a study."""
    from tendon_cli.studies.study import keys

    names = sorted(
        {part for key in keys() for part in key.split(".")} | {"cases", "name", "from", "to", "num", "flexor"}
    )
    name = st.one_of(st.sampled_from(names), st.sampled_from(names), st.text(max_size=4))
    quantity = st.builds(
        "{} {}".format,
        st.one_of(st.integers(-10, 1000), st.floats(), st.sampled_from(["1e999", "9**9", "0x1", ".5"])),
        st.sampled_from(["mm", "m", "N", "kN/m", "GPa", "kg", "deg", "rad", "N m", "", "mm mm", "µm"]),
    )
    leaf = st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), quantity, quantity,
        st.fixed_dictionaries({"from": quantity, "to": quantity, "num": st.integers(-1, 9)}),
        st.sampled_from(["flexion", "extension", "unilateral", "bilateral", "initial", "states", "log"]),
    )  # fmt: skip
    tree = st.recursive(
        leaf,
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(name, inner, max_size=5)),
        max_leaves=12,
    )
    table = st.dictionaries(name, st.one_of(leaf, leaf, tree), max_size=6)
    roots = sorted({key.partition(".")[0] for key in keys()} | {"cases", "motion", "model", "output", "name"})
    return st.dictionaries(st.sampled_from(roots), st.one_of(table, table, tree), max_size=5)


def toml(value, *, top=True):
    """A tree as TOML, or as near to it as it can be said."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(inner, top=False)}" for key, inner in value.items()]
        return "\n".join(pairs) if top else "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(inner, top=False) for inner in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def good_studies():
    """Studies to start from, each with its ending; the plain ones twice."""
    from tendon_cli.studies.starter import starter

    seeds = [(suffix, starter(Path("a" + suffix)).encode()) for suffix in (".toml", ".yaml")]
    uncommented = [
        (suffix, b"\n".join(line.removeprefix(b"# ") if b"=" in line or b": " in line else line for line in lines))
        for suffix, lines in ((suffix, text.split(b"\n")) for suffix, text in seeds)
    ]
    plain = [(".toml", PLAIN_TOML), (".yaml", PLAIN_YAML)]
    return seeds + plain + plain + uncommented


def study_files():
    """Mutations of the starters and random trees, as TOML and YAML."""
    mutated = st.builds(
        lambda source, edits: (source[0], edited(source[1], edits, STUDY_TOKENS)),
        st.sampled_from(good_studies()),
        EDITS,
    )
    trees = st.builds(
        lambda tree, suffix: (
            suffix,
            (toml(tree) if suffix == ".toml" else json.dumps(tree)).encode("utf-8", "replace"),
        ),
        study_trees(),
        st.sampled_from([".toml", ".yaml"]),
    )
    return st.one_of(mutated, trees)
