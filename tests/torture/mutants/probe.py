"""Print what users get: the output of many commands and the hash of every file they write.

It serves to compare one package with another. Run in an empty folder with the configs in it; prints
one JSON object. Pictures count as being there or not.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import re
import shlex
import sys
from pathlib import Path

from tendon_cli import cli

ROUTE = "x [mm],y [mm],z [mm]\n"
for n in range(40):
    ROUTE += f"{100 - n},{n * n / 16},{n}\n"

# Readings are made up: two directions in turn, unequal gains, a zero offset.
READINGS = "cell_1,cell_2\n"
for n in range(24):
    force = 0.8 + n / 20
    gain = 1.31 if n % 2 else 0.79
    READINGS += f"{force * gain + 0.03:.4f},{force:.4f}\n"

FILES = {
    "rich.toml": """
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
model.slack = "bilateral"
""",
    "tight.toml": """
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
""",
    "people.csv": "name,sex,weight (kg),stature (cm),biceps_circumference_mm,weighting\n"
    "Ada,female,62.5,168,281,1\nBo,male,90,181.5,,2\nCleo,female,,171,,1\n",
    "route.csv": ROUTE,
    "made.csv": READINGS,
}


def state_command(form: str, load: int, angle: int, direction: str, force: int, case: str) -> str:
    """Return a command that computes one state of the rich study."""
    return (
        f"state rich.toml {form} --set load.mass='{load} kg' "
        f"--set motion.elbow_angle='{angle} deg' --set motion.direction={direction} "
        "--set sheath.friction=0.1 --set spring.stiffness='5 kN/m' "
        f"--set tendon.pretension='{force} N' --case {case}"
    )


POINTS = [
    (0, 75, "flexion", 90, "short"),
    (5, 75, "flexion", 90, "long"),
    (10, 90, "extension", 140, "short"),
    (0, 0, "extension", 60, "short"),
    (3, 170, "flexion", 90, "long"),
]
"""Load in kg, elbow angle in degrees, direction, pretension in N and case of a state."""
STATES = [state_command(form, *point) for point in POINTS for form in ("", "--json")]
FEWER = """--no-figures --set 'tendon.pretension={ from = "20 N", to = "260 N", num = 7 }'"""
COMMANDS = [
    *STATES,
    *f"""
sweep rich.toml --quiet --no-figures --allow-no-equilibrium --jobs 1 --out rich
sweep configs/quickstart.toml {FEWER} --out quick
sweep configs/quickstart.toml {FEWER} --out quick
sweep configs/quickstart.toml {FEWER} --set 'spring.stiffness=4 kN/m' --out quick2
sweep configs/quickstart.toml --out quick --set spool.ratio=0.9
sweep rich.toml --dry-run
sweep rich.toml --set 'arm.a1=1 kg' --set arm.b3=1
plot quick --quantity motor_torque --out quick.png
fit-friction configs/friction/table_a1.csv --bend-angle '144 deg +/- 2 deg' --out mu.toml
fit-friction configs/friction/raw_log.csv --bend-angle '90 deg' --json
fit-friction configs/friction/several_angles.csv --json
fit-friction made.csv --bend-angle '170 deg'
fit-friction made.csv --route route.csv --json
design configs/design/for_everyone.toml --set people.count=4 --no-figures --out everyone
design configs/quickstart.toml --no-figures --out answer
design tight.toml --no-figures --out tight
state tight.toml --person mean-woman --reversal
show rich --sort -max_tension --where 'load_mass = 3 kg'
show answer
export rich rich.csv
report quick --out quick.html
report answer --out answer.html
check quick --worst 3 --markdown
check quick --baseline quick2 --except spring.stiffness --except name --json
check answer --json
check tight
init --template people people.toml
init --template motor motor.toml
design motor.toml --no-figures --out motor
paper --out paper --json
init mine.toml
completion bash --line 'tendon sweep --set spr'
schema
""".strip().splitlines(),
]
TIMES = re.compile(
    r"\d+(\.\d+)? ?(ms|s|min|MB/s|GB|MB|kB)\b"
    r"|\"seconds\": [\d.]+"
    r"|\"checksum\": \"\w+\""
    r"|>seconds</td><td[^>]*>[\d.]+"
)
"""Times and sizes, and the checksum of a record, in which its time counts."""


def answers() -> dict[str, str]:
    """Return what every command prints, and the hash of every file that the commands leave."""
    for name, text in FILES.items():
        Path(name).write_text(text)
    given = {}
    for number, line in enumerate(COMMANDS):
        given[f"{number} {line}"] = TIMES.sub("TIME", printed_by(line))
    files = [path for path in Path().rglob("*") if path.is_file() and "configs" not in path.parts]
    for file in sorted(files):
        content = b"" if file.suffix == ".png" else file.read_bytes()
        if file.suffix in (".json", ".html") and file.name != "ledger.json":
            content = TIMES.sub("TIME", content.decode()).encode()
        given[str(file)] = hashlib.sha256(content).hexdigest()
    return given


def printed_by(line: str) -> str:
    """Return exit code, stdout and stderr of a command; an error that it does not catch instead."""
    out = io.StringIO()
    err = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            cli.main(shlex.split(line))
    except SystemExit as end:
        return f"{end.code}\n{out.getvalue()}\n{err.getvalue()}"
    except BaseException as error:  # noqa: BLE001 - a mutant may do anything
        return repr(error)
    return f"no exit\n{out.getvalue()}\n{err.getvalue()}"


if __name__ == "__main__":
    result = answers()
    sys.__stdout__.write(json.dumps(result))
