"""Good files that hostile ones are bred from, and pieces that such files are made of."""

import tempfile
from math import exp, pi, sin
from pathlib import Path

STUDY_TOKENS = [
    b"nan",
    b"-inf",
    b"1e400",
    b"9**9**9 m",
    b'"9**9**9 m"',
    b'"1e-400 N"',
    b"[[cases]]",
    b"[[[",
    b"]]",
    b"{",
    b"}",
    b"{{",
    b'"""',
    b"'''",
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\t",
    b"\r",
    b"# ",
    b"&a ",
    b"*a",
    b"<<: *a",
    b"!!python/object:os.system ",
    b"--- ",
    b"...",
    b"? ",
    b"- ",
    b"|",
    b">",
    b"true",
    b"null",
    b"~",
    b"2020-01-01",
    b"0x10",
    b"1_0",
    b'"1 parsec"',
    b'"-1 N"',
    b'"0 kg"',
    b"[]",
    b'["1 N", "2 N"]',
    b'{ from = "0 N", to = "1 N", num = 3 }',
    b"{ from = 0, to = 1, num = 99999999 }",
    b'{ from = 1, to = 1e300, num = 5, spacing = "log" }',
    b"a.b.c.d.e.f.g = 1",
    b"model.slack",
    b"sheath.flexor.friction",
    b"path = '/dev/zero'",
    b'friction_from = "study"',
    b"\xc2\xb5",
    b"\xe2\x80\xae",
    b"9" * 400,
    b"1" * 4301,
    b"[" * 40,
    b"a." * 20,
    b"num",
    b"direction",
    b"elbow_angle",
    b'"180 deg"',
    b"1e308",
    b"-0.0",
    b'"case"',
    b"name",
    b"\\u0000",
    b'"\\ud800"',
]
CSV_TOKENS = [
    b",",
    b";",
    b"\t",
    b'"',
    b'""',
    b"'",
    b"nan",
    b"inf",
    b"-inf",
    b"1e400",
    b"1e-320",
    b"-1",
    b"0",
    b"1,5",
    b"1.5",
    b"\r",
    b"\r\n",
    b"\n\n",
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\xff",
    b"time",
    b"direction",
    b"bend_angle_deg",
    b"bend_angle_rad",
    b"cell 1",
    b"cell_2",
    b"flexion",
    b"9" * 400,
    b"," * 300,
    b"=1+1",
    b"\xe2\x88\x92",
    b"1_0",
    b"0x10",
    b"N",
    b"[N]",
    b"1e308",
    b"-1e308",
    b"#",
    b"\xa0",
    b"TRUE",
    b"case",
]
PARQUET_TOKENS = [
    b"PAR1",
    b"\0" * 8,
    b"\xff" * 8,
    b"\x80\x80\x80\x80\x08",
    b"\xff\xff\xff\xff\x07",
    b"{}",
    b"[]",
    b"null",
    b'"',
    b"part",
    b"index",
    b"states",
    b"-1",
    b"\x15\x00",
    b"\x15\x02",
    b"\x18\x00",
    b"tendon.",
    b"unit",
    b"1e9",
    b"9" * 30,
    b"\x19\xfc",
]
TOKENS = {"toml": STUDY_TOKENS, "yaml": STUDY_TOKENS, "csv": CSV_TOKENS, "parquet": PARQUET_TOKENS}

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
SWEPT = """
[load]
mass = ["0 kg", "3 kg"]
[tendon]
pretension = [60, 120, 240]
[motion]
elbow_angle = ["0 rad", "1 rad", "2 rad"]
"""
SWEPT_WITH_CASES = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 3, spacing = "log" }
[motion]
direction = "flexion"
elbow_angle = { from = "10 deg", to = "90 deg", num = 2 }
[[cases]]
name = "first"
[[cases]]
name = "second"
sheath.flexor.friction = 0.2
"""


def seeds(kind):
    """Return the contents of good files of a kind."""
    if kind == "csv":
        return good_readings()
    if kind == "parquet":
        return good_tables()
    return good_studies(kind)


def good_studies(kind):
    """Return the starter as it is and with its examples, and a plain study twice."""
    from tendon_cli.commands.starter import starter

    text = starter(Path(f"a.{kind}")).encode()
    plain = PLAIN_TOML if kind == "toml" else PLAIN_YAML
    lines = []
    for line in text.split(b"\n"):
        is_example = b"=" in line or b": " in line
        lines.append(line.removeprefix(b"# ") if is_example else line)
    return [text, plain, plain, b"\n".join(lines)]


def good_readings():
    """Return tables of readings.

    They are readings by case, a log, readings at several angles, readings that name no case, and
    the first once more in UTF-16.
    """
    strokes = [("pull", 1.2), ("release", 0.8)]
    table = "case,cell 1,cell 2\n"
    for case, ratio in strokes:
        for force in (20, 40, 60):
            table += f"{case},{force * ratio:.3f},{force}\n"
    angles = "bend_angle_deg;cell 1;cell 2\n"
    for angle in (45, 90, 180):
        for sign in (1, -1):
            row = f"{angle};{50 * exp(sign * 0.1 * angle * pi / 180):.3f};50,0\n"
            angles += row.replace(".", ",")
    log = "time,direction,cell 1,cell 2\n"
    for step in range(120):
        force = 40 + 20 * sin(step / 6.4)
        case, ratio = strokes[step // 20 % 2]
        log += f"{step / 10},{case},{force * ratio:.4f},{force:.4f}\n"
    plain = "cell 1\tcell 2\n1.2\t1\n2.4\t2\n1\t1.2\n2\t2.4\n"
    texts = [table, table, angles, plain, plain, log]
    return [*(text.encode() for text in texts), table.encode("utf-16")]


def good_tables():
    """Return the tables of two small runs."""
    from tendon_cli import sweep

    tables = []
    for text in (SWEPT, SWEPT_WITH_CASES):
        with tempfile.TemporaryDirectory() as place:
            study = Path(place, "study.toml")
            run = Path(place, "run")
            study.write_text(text, "utf-8")
            sweep(study, run, 1)
            files = [run / "designs.parquet", run / "states.parquet"]
            tables += [file.read_bytes() for file in files]
    return tables
