"""What users get: the output of many commands and the hash of every file they write, for one package against another.

Run in an empty folder with the configs beside it; prints one JSON object. Pictures count as being there or not.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import math
import re
import sys
from pathlib import Path

from tendon_cli import cli

RICH = """
name = "rich"
[sheath]
friction = [0.0, 0.07, 0.2]
[sheath.extensor]
bend_angle = "150 deg"
[tendon]
pretension = { from = "40 N", to = "260 N", num = 12 }
[spring]
stiffness = { from = "1 kN/m", to = "30 kN/m", num = 3, spacing = "log" }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
[motion]
elbow_angle = { from = "-30 deg", to = "170 deg", num = 21 }
[[cases]]
name = "short"
arm.b1 = "140 mm"
[[cases]]
name = "long"
arm.b1 = "170 mm"
model.reference = "initial"
"""
BOTH = """
name = "both"
[arm]
upper_arm_angle = "-40 deg"
[tendon.flexor]
pretension = "80 N"
[tendon.extensor]
pretension = "120 N"
[spool]
ratio = [0.6, 1.0]
[model]
slack = "bilateral"
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
"""
ASKED = """
name = "asked"
[spring]
stiffness = "5 kN/m"
[spool]
ratio = [0.6, 0.8]
[load]
mass = ["0 kg", "5 kg"]
[sheath]
friction = { value = 0.07, tolerance = "10 %" }
[people]
count = 4
[motion]
speed = "60 deg/s"
elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
[limits]
peak_motor_torque = "14 N m"
max_tension = "450 N"
max_friction_loss = "40 J"
[design]
minimise = ["pretension"]
"""
TIGHT = """
name = "tight"
[arm]
upper_arm_angle = "-20 deg"
[spring]
stiffness = ["2 kN/m", "6 kN/m"]
[sheath]
friction = { mean = 0.074, std = 0.004 }
[spool]
ratio = [0.6, 1.0]
[load]
mass = ["1 kg", "8 kg"]
[people]
file = "people.csv"
[motion]
speed = "90 deg/s"
elbow_angle = { from = "0 deg", to = "110 deg", num = 12 }
[limits]
max_tension = "300 N"
min_elbow_stiffness = "2 N m/rad"
max_spring_extension = "60 mm"
peak_motor_power = "9 W"
[uncertainty]
draws = 16
"""
PEOPLE = """name,sex,weight (kg),stature (cm),biceps_circumference_mm,weighting
Ada,female,62.5,168,281,1
Bo,male,90,181.5,,2
Cleo,female,,171,,1
"""
ROUTE = "x [mm],y [mm],z [mm]\n" + "\n".join(
    f"{100 * math.cos(turn / 20):.2f},{100 * math.sin(turn / 20):.2f},{turn:.1f}" for turn in range(40)
)
READINGS = "cell_1,cell_2\n" + "\n".join(
    f"{force * (1.31 if row % 2 else 0.79) + 0.03:.4f},{force:.4f}"
    for row, force in enumerate(0.8 + 0.05 * step for step in range(24))
)
"""Made up: two directions in turn, unequal gains, a zero offset."""
STATES = [
    [f"load.mass={load}", f"motion.elbow_angle={angle}", f"motion.direction={way}", f"model.slack={slack}"]
    for load, angle, way, slack in (
        ("0 kg", "75 deg", "flexion", "unilateral"),
        ("5 kg", "75 deg", "flexion", "bilateral"),
        ("10 kg", "90 deg", "extension", "unilateral"),
        ("0 kg", "0 deg", "extension", "unilateral"),
        ("3 kg", "170 deg", "flexion", "unilateral"),
    )
]
QUICK = ("--quiet", "--no-figures", "--allow-no-equilibrium", "--jobs", "1")
FEWER = ("--no-figures", "--set", 'tendon.pretension={ from = "20 N", to = "260 N", num = 7 }')
COMMANDS = [
    *(("state", "rich.toml", *json_, *(word for setting in state for word in ("--set", setting)))
      for state in STATES for json_ in ((), ("--json",))),
    ("sweep", "rich.toml", *QUICK, "--out", "rich"),
    ("sweep", "both.toml", "--json", "--no-figures", "--out", "both"),
    ("sweep", "configs/quickstart.toml", *FEWER, "--out", "quick"),
    ("sweep", "configs/quickstart.toml", *FEWER, "--out", "quick"),
    ("sweep", "configs/quickstart.toml", *FEWER, "--set", "spring.stiffness=4 kN/m", "--out", "quick2"),
    ("sweep", "both.toml", "--out", "both", "--set", "spool.ratio=0.9"),
    ("sweep", "rich.toml", "--dry-run"),
    ("sweep", "both.toml", "--set", "arm.a1=1 kg", "--set", "arm.b3=1"),
    ("plot", "both", "--quantity", "motor_torque", "--out", "both.png"),
    ("fit-friction", "configs/friction/table_a1.csv", "--bend-angle", "144 deg +/- 2 deg", "--out", "mu.toml"),
    ("fit-friction", "configs/friction/raw_log.csv", "--bend-angle", "90 deg", "--json"),
    ("fit-friction", "configs/friction/several_angles.csv", "--json"),
    ("fit-friction", "made.csv", "--bend-angle", "170 deg"),
    ("fit-friction", "made.csv", "--bend-angle", "170 deg", "--json"),
    ("state", "asked.toml", "--reversal"),
    ("sweep", "asked.toml", *QUICK, "--out", "asked"),
    ("design", "asked.toml", "--no-figures", "--out", "answer"),
    ("design", "configs/quickstart.toml", "--no-figures", "--out", "answer2"),
    ("show", "rich", "--sort", "-max_tension", "--where", "load_mass = 3 kg"),
    ("show", "answer"),
    ("export", "rich", "rich.csv"),
    ("report", "both", "--out", "both.html"),
    ("report", "answer2", "--out", "answer2.html"),
    ("check", "asked"),
    ("check", "quick", "--worst", "3", "--markdown"),
    ("check", "both", "--baseline", "asked", "--json"),
    ("check", "quick", "--baseline", "quick2", "--except", "spring.stiffness", "--except", "name", "--json"),
    ("check", "answer", "--json"),
    ("design", "tight.toml", "--no-figures", "--out", "answer3"),
    ("check", "answer3"),
    ("state", "tight.toml", "--person", "mean-woman"),
    ("fit-friction", "made.csv", "--route", "route.csv", "--json"),
    *(("init", "--template", name, f"{name}.toml") for name in ("design", "people", "motor", "friction")),
    *(("design", f"{name}.toml", "--no-figures", "--out", f"of-{name}") for name in ("people", "motor")),
    ("paper", "--out", "paper", "--json"),
    ("init", "mine.toml"),
    ("completion", "bash", "--line", "tendon sweep --set spr"),
    ("schema",),
]  # fmt: skip
_TIMES = re.compile(
    r"\d+(\.\d+)? ?(ms|s|min|MB/s|GB|MB|kB)\b|\"seconds\": [\d.]+|\"checksum\": \"\w+\"|>seconds</td><td[^>]*>[\d.]+"
)
"""Times and sizes, and the checksum of a record, in which its time counts."""


def answers() -> dict[str, str]:
    """What every command says and leaves behind."""
    Path("rich.toml").write_text(RICH)
    Path("both.toml").write_text(BOTH)
    Path("asked.toml").write_text(ASKED)
    Path("made.csv").write_text(READINGS)
    Path("tight.toml").write_text(TIGHT)
    Path("people.csv").write_text(PEOPLE)
    Path("route.csv").write_text(ROUTE)
    found = {}
    for number, words in enumerate(COMMANDS):
        out, err = io.StringIO(), io.StringIO()
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                cli.main(list(words))
        except SystemExit as end:
            said = f"{end.code}\n{out.getvalue()}\n{err.getvalue()}"
        except BaseException as error:  # noqa: BLE001 - a mutant may do anything
            said = repr(error)
        found[f"{number} {' '.join(words)}"] = _TIMES.sub("TIME", said)
    for file in sorted(path for path in Path().rglob("*") if path.is_file() and "configs" not in path.parts):
        content = b"" if file.suffix == ".png" else file.read_bytes()
        if file.suffix in (".json", ".html") and file.name != "ledger.json":
            content = _TIMES.sub("TIME", content.decode()).encode()
        found[str(file)] = hashlib.sha256(content).hexdigest()
    return found


if __name__ == "__main__":
    result = answers()
    sys.__stdout__.write(json.dumps(result))
