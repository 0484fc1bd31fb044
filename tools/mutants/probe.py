"""Print what users get: the output of many commands, every file and the data of every figure.

It serves to compare one package with another, each in an empty folder with the configs in it:
`python probe.py TRUTH` keeps what users get in the folder TRUTH, and `python probe.py TRUTH
--compare` prints the name of the first thing that differs from that. With `--trace` the lines that
each command runs are kept as well; with `--commands` only some are run, and what the others wrote
is taken from TRUTH. Of pictures the texts, lines, points and colours count: their layout is judged
by eye.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import re
import shlex
import shutil
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np

PACKAGE = "tendon_cli/"
CALLS_TRACED = 20
"""Calls of a function that are traced in each command; more would take minutes."""

ROUTE = "x [mm],y [mm],z [mm]\n"
for n in range(40):
    ROUTE += f"{100 - n},{n * n / 16},{n}\n"

# Readings are made up: two directions in turn, unequal gains, a zero offset.
READINGS = "cell_1,cell_2\n"
for n in range(24):
    force = 0.8 + n / 20
    gain = 1.31 if n % 2 else 0.79
    READINGS += f"{force * gain + 0.03:.4f},{force:.4f}\n"

REACH = "time (s),angle (deg)\n"
for n in range(81):
    REACH += f"{n / 40:.3f},{50 - 30 * np.cos(np.pi * n / 40):.4f}\n"

LIFT = "time (s),angle (deg),torque (N m)\n"
for n in range(61):
    turn = np.pi * n / 15
    LIFT += f"{n / 20:.3f},{45 - 25 * np.cos(turn):.4f},{2 * np.sin(2 * turn):.4f}\n"

LOG = "".join(
    (Path(__file__).parents[2] / "configs/suit/suit_log.csv")
    .read_text(encoding="utf-8")
    .splitlines(keepends=True)[::6]
)

TORQUE = "angle (deg),torque (N m)\n"
TRAVEL = "angle (rad),flexor (mm),extensor (mm)\n"
for angle in np.linspace(-0.1, 2.0, 60):
    flexor = 35 * angle - 44 * np.cos(0.9 * angle)
    extensor = 28 * angle + 6 * np.sin(1.3 * angle - 0.4)
    TORQUE += f"{np.degrees(angle):.4f},{4 * np.sin(angle) - angle:.5f}\n"
    TRAVEL += f"{angle:.6f},{flexor:.5f},{extensor:.5f}\n"

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
elbow_angle = { from = "-10 deg", to = "120 deg", num = 14 }
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
ratio = 0.6
[load]
mass = ["1 kg", "8 kg"]
[people]
file = "people.csv"
[motion]
speed = "90 deg/s"
elbow_angle = { from = "0 deg", to = "110 deg", num = 6 }
[limits]
max_tension = "300 N"
min_elbow_stiffness = "2 N m/rad"
max_spring_extension = "60 mm"
peak_motor_power = "9 W"
[uncertainty]
draws = 4
""",
    "people.csv": "name,sex,weight (kg),stature (cm),biceps_circumference_mm,weighting\n"
    "Ada,female,62.5,168,281,1\nBo,male,90,181.5,,2\nCleo,female,,171,,1\n",
    "route.csv": ROUTE,
    "made.csv": READINGS,
    "reach.csv": REACH,
    "torque.csv": TORQUE,
    "travel.csv": TRAVEL,
    "worn.toml": """
name = "worn"
[people]
file = "worn.csv"
[arm]
anchors = "mean man"
[sheath]
path = "route.csv"
path_smoothing = "0.5 mm"
friction_from = "mu.toml"
[spring]
stiffness = ["3 kN/m", "8 kN/m"]
[spool]
ratio = { from = 0.5, to = 1.0, num = 3 }
[load]
mass = ["0 kg", "5 kg"]
[motion]
trajectory = "reach.csv"
[limits]
max_tension = "400 N"
""",
    "worn.csv": "name,weight (kg),stature (cm)\nDan,70,175\nEve,58,164\n",
    "ankle.toml": """
name = "ankle"
[joint]
name = "ankle"
excursion = "travel.csv"
torque = "torque.csv"
[arm]
forearm_mass = 0
[sheath]
friction = [0.05, 0.12]
bend_angle = { angle = ["0 rad", "1.9 rad"], bend = ["2.4 rad", "3.73 rad"] }
[tendon]
length = "1.4 m"
pretension = { from = "60 N", to = "220 N", num = 9 }
[spring]
flexor.stiffness = "6 kN/m"
extensor.stiffness = "9 kN/m"
[spool]
ratio = 0.55
[motion]
elbow_angle = { from = "0 rad", to = "1.9 rad", num = 20 }
[[figure]]
name = "tensions"
quantity = ["flexor_tension_distal", "extensor_tension_distal"]
where = ["friction = 0.12"]
""",
    "lift.csv": LIFT,
    "moving.toml": """
name = "moving"
[spring]
stiffness = ["3 kN/m", "6 kN/m"]
[spool]
ratio = 0.6
[load]
mass = ["0 kg", "4 kg"]
[motion]
trajectory = "lift.csv"
inertia = "0.08 kg m2"
cutoff = "4 Hz"
[limits]
max_tension = "420 N"
peak_motor_power = "40 W"
peak_motor_torque = "14 N m"
""",
    "springs.csv": "name,spring.stiffness (kN/m),limits.max_spring_extension (mm),"
    "price (EUR),maker\n"
    "S2,2,150,9,Alder\nS4,4,90,14,Birch\nS6,6,60,17,Alder\n",
    "parts.toml": """
name = "parts"
[[table]]
name = "spring"
file = "springs.csv"
[[table]]
name = "motor"
rows = [
  { name = "M8", "spool.flexor_radius" = "28 mm", "limits.peak_motor_torque" = "8 N m" },
  { name = "M9", "spool.flexor_radius" = "30 mm", "limits.peak_motor_torque" = "9 N m" },
]
[spool]
ratio = 0.6
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 10 }
[design]
minimise = ["price"]
maximise = ["tolerance_length"]
""",
    "sampled.toml": """
name = "sampled"
[[table]]
name = "sample"
sample = "sobol"
count = 8
between = { "spring.stiffness" = "2 kN/m to 8 kN/m", "sheath.friction" = "0.07 +/- 0.02" }
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 5 }
""",
    "limited.toml": """
name = "limited"
[spring]
stiffness = ["4 kN/m", "6 kN/m"]
[spool]
ratio = 0.6
[load]
mass = ["0 kg", "5 kg"]
[anchor]
stiffness = "30 kN/m"
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
[limits]
peak_motor_torque = ["6 N m", "7 N m", "9 N m"]
min_flexor_tension = "5 N"
""",
    "first.toml": """
name = "first"
[spring]
stiffness = "4 kN/m"
[spool]
ratio = 0.6
[load]
mass = ["0 kg", "5 kg"]
[sheath]
friction = "0.07 +/- 0.01"
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 5 }
[people]
count = 6
seed = 1
[uncertainty]
draws = 4
[design]
verify = 60
serve = 0.8
""",
    "second.toml": """
extends = "first.toml"
[spool]
ratio = 0.64
[limits]
max_tension = "310 N"
""",
    "log.csv": LOG,
    "fitted.toml": """
name = "fitted"
fitted_from = "fit.toml"
[arm]
elbow_radius = "45 mm"
[spool]
ratio = 0.5522
[load]
mass = ["0 kg", "2 kg"]
[motion]
elbow_angle = { from = "10 deg", to = "80 deg", num = 6 }
""",
    "boxed.toml": """
name = "boxed"
[spring]
stiffness = { from = "3 kN/m", to = "6 kN/m", num = 3 }
[spool]
ratio = 0.6
[load]
mass = { from = "0 kg", to = "3 kg" }
""",
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
FEWER = """--set 'tendon.pretension={ from = "20 N", to = "260 N", num = 7 }'"""
SOFTER = FEWER + " --set 'spring.stiffness=4 kN/m'"
SESSION = ">>>"
"""Begins an expression of a Python session."""
COMMANDS = [
    *STATES,
    *f"""
state rich.toml --reversal --plot motor_of_a_state.svg
state tight.toml --person mean-woman --reversal
state tight.toml --person Cleo --draw 3
state tight.toml --draw 1 --json
fit-friction configs/friction/table_a1.csv --bend-angle '144 deg +/- 2 deg' --out mu.toml
state worn.toml --person Eve
state ankle.toml --json
sweep rich.toml --dry-run
design tight.toml --dry-run
sweep rich.toml --set 'arm.a1=1 kg' --set arm.b3=1
show people.csv
export people.csv read.csv
init --for people people.toml
init --for motor motor.toml
init mine.toml
plot rich.toml --arm --angle '20 deg' --angle '90 deg' --case long --out arm.png
sweep rich.toml --quiet --no-figures --allow-no-equilibrium --jobs 1 --out rich
sweep ankle.toml --out ankle
show ankle --json
show rich --sort -max_tension --where 'load_mass = 3 kg'
show rich --table states --where 'pretension > 200 N' --columns design,load_mass,status --csv
export rich rich.csv
export rich rich_of.csv --table states --where 'case = long' --locale de --units study
check rich --worst 4
plot rich --out rich.png
plot rich -y motor_torque --x elbow_angle --colour load_mass --where 'case = long' --out curves.svg
plot rich -y peak_motor_torque -x pretension --panels case --colour load_mass --out points.png
{SESSION} tendon.open('rich').designs.to_csv()
{SESSION} tendon.open('rich').table('states').schema.to_string()
{SESSION} tendon.open('rich').to_xarray().max().to_dict()
{SESSION} tendon.sweep('worn.toml').designs.to_csv()
{SESSION} tendon.estimate('tight.toml').rows
design boxed.toml --no-figures --out boxed
design motor.toml --out motor
design tight.toml --no-figures --out tight
design worn.toml --out worn
design configs/design/for_everyone.toml --set people.count=4 --out everyone
design configs/quickstart.toml --no-figures --out answer
{SESSION} tendon.open('answer').choices.to_csv()
{SESSION} tendon.open('worn')._repr_html_().partition('<img')[0]
{SESSION} tendon.states('ankle.toml', [0.5, 1.0])
show answer
show everyone --table persons
export tight persons.csv --table persons --units study
check answer --json
check tight
plot answer --out answer.svg
plot motor --between --out between.png
report answer --out answer.html
report everyone --out everyone.html
fit-friction configs/friction/raw_log.csv --bend-angle '90 deg' --plot log.png --json
fit-friction configs/friction/several_angles.csv --json
fit-friction made.csv --bend-angle '170 deg'
fit-friction made.csv --route route.csv --json
sweep configs/quickstart.toml {FEWER} --out quick
sweep configs/quickstart.toml {FEWER} --out quick
sweep configs/quickstart.toml --no-figures {SOFTER} --out quick2
sweep configs/quickstart.toml --out quick --set spool.ratio=0.9
plot quick --quantity motor_torque --out quick.png
report quick --out quick.html
check quick --worst 3 --markdown
check quick --baseline quick2 --except spring.stiffness --except name --json
init --schema
design moving.toml --why --out moving
plot moving --between --out moving.svg
export moving moving.csv --to controller
design parts.toml --why --out parts
state parts.toml --row spring=S4 --row motor=M9
export parts parts.csv --units study
design limited.toml --why --out limited
plot limited -x limits.peak_motor_torque --out trade_off.svg
export limited arm.xml --to mujoco
export limited torques.csv --to controller
export limited numbers.csv --to parameters --choice 1
design first.toml --no-figures --out first
design second.toml --why --no-figures --out second
compare first second
compare first second --json
compare first second --markdown
compare limited parts --html answers.html
check second --baseline first --except spool.ratio --except limits.max_tension --except name
check limited --baseline limited --markdown
compare quick quick2
compare quick quick2 --json --html runs.html
sweep sampled.toml --no-figures --out sampled
fit-suit configs/suit/suit.toml log.csv --out fit.toml --plot fit.svg
fit-suit configs/suit/suit.toml log.csv --json
design fitted.toml --no-figures --out fitted
""".strip().splitlines(),
]
TIMES = re.compile(
    r"\d+(\.\d+)? ?(ms|s|min|MB/s|GB|MB|kB)\b"
    r"|\"(figure_)?seconds\": [\d.]+"
    r"|\"checksum\": \"\w+\""
    r"|>(figure_)?seconds</td><td[^>]*>[\d.]+"
    r"|base64,[\w+/=]+"
)
"""Times, sizes, pictures in pages, and the checksum of a record, in which its time counts."""
PICTURES = (".png", ".svg", ".pdf")

Answers = Iterator[tuple[str, str]]
"""Names of what users get, and its text or hash."""


def answers_of(number: int, known: dict[Path, tuple[int, int]]) -> Answers:
    """Yield the output of a command, the data of its figures, and the hash of its files.

    Args:
        number: Number of the command.
        known: Times and sizes of the files of earlier commands, which is brought up to date.
    """
    line = COMMANDS[number]
    with figures_kept() as figures:
        printed = printed_by(line)
    yield f"{number} {line}", TIMES.sub("TIME", printed)
    if figures:
        yield f"{number} figures of {line}", json.dumps(figures)
    for file in new_files(known):
        content = b"" if file.suffix in PICTURES else file.read_bytes()
        if file.suffix in (".json", ".html"):
            content = TIMES.sub("TIME", content.decode()).encode()
        yield f"{number} {file}", hashlib.sha256(content).hexdigest()


def new_files(known: dict[Path, tuple[int, int]]) -> list[Path]:
    """Return the files that are new or have changed, and bring `known` up to date."""
    found = []
    for file in sorted(Path().rglob("*")):
        if "configs" in file.parts or not file.is_file():
            continue
        facts = file.stat()
        state = (facts.st_mtime_ns, facts.st_size)
        if known.get(file) != state:
            known[file] = state
            found.append(file)
    return found


def printed_by(line: str) -> str:
    """Return exit code, stdout and stderr of a command; an error that it does not catch instead."""
    out = io.StringIO()
    err = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            if line.startswith(SESSION):
                print(shown_by(line.removeprefix(SESSION).strip()))
            else:
                from tendon_cli.commands import cli

                cli.main(shlex.split(line))
    except SystemExit as end:
        return f"{end.code}\n{out.getvalue()}\n{err.getvalue()}"
    except BaseException as error:  # noqa: BLE001 - a mutant may do anything
        return repr(error)
    return f"no exit\n{out.getvalue()}\n{err.getvalue()}"


def shown_by(expression: str) -> Any:
    """Return the value of an expression of a Python session."""
    import tendon_cli as tendon

    return eval(expression, {"tendon": tendon})  # noqa: S307 - written above


# --- Figures --------------------------------------------------------------------------------------


@contextlib.contextmanager
def figures_kept() -> Iterator[list[Any]]:
    """Keep the data of every figure that is drawn in the meantime."""
    from matplotlib.figure import Figure

    draw = Figure.draw
    drawn: dict[int, tuple[Figure, Any]] = {}

    def keep(figure: Figure, renderer: Any) -> None:
        draw(figure, renderer)
        drawn[id(figure)] = (figure, data_of(figure))

    kept: list[Any] = []
    Figure.draw = keep  # type: ignore[method-assign]
    try:
        yield kept
    finally:
        Figure.draw = draw  # type: ignore[method-assign]
        kept += [data for _, data in drawn.values()]


def data_of(figure: Any) -> dict[str, Any]:
    """Return texts, lines, points, areas and colours of a figure, without where they stand."""
    from matplotlib.axis import Axis
    from matplotlib.collections import Collection
    from matplotlib.image import AxesImage
    from matplotlib.lines import Line2D
    from matplotlib.text import Text

    tick_parts = set()
    for axis in figure.findobj(Axis):
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            tick_parts |= {id(part) for part in tick.findobj()}
    parts = [part for part in figure.findobj() if id(part) not in tick_parts]
    lines = [part for part in parts if isinstance(part, Line2D)]
    collections = [part for part in parts if isinstance(part, Collection)]
    images = [part for part in parts if isinstance(part, AxesImage)]
    texts = [part.get_text() for part in parts if isinstance(part, Text)]
    return {
        "texts": [text for text in texts if text],
        "lines": [[rounded(line.get_xydata()), str(line.get_color())] for line in lines],
        "styles": [[str(line.get_linestyle()), str(line.get_marker())] for line in lines],
        "points": [rounded(part.get_offsets()) for part in collections],
        "paths": [[rounded(path.vertices) for path in part.get_paths()] for part in collections],
        "values": [rounded(part.get_array()) for part in (*collections, *images)],
        "colours": [rounded(part.get_facecolor()) for part in collections],
    }


def rounded(values: Any) -> list[Any]:
    """Return numbers with nine digits; empty for None."""
    if values is None:
        return []
    array = np.ma.filled(np.ma.asarray(values, float), np.nan)
    return [f"{value:.9g}" for value in np.ravel(array)]


# --- Comparing ------------------------------------------------------------------------------------


def keep_truth(truth: Path, wanted: set[int]) -> None:
    """Keep the answers of commands, the files that each leaves, and its time, in a folder."""
    known: dict[Path, tuple[int, int]] = {}
    answers: dict[str, str] = {}
    seconds: dict[int, float] = {}
    new_files(known)
    for number in range(len(COMMANDS)):
        if number not in wanted:
            continue
        before = dict(known)
        started = time.process_time()
        answers |= dict(answers_of(number, known))
        seconds[number] = time.process_time() - started
        for file, state in known.items():
            if before.get(file) != state:
                target = truth / str(number) / file
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, target)
    (truth / "answers.json").write_text(json.dumps(answers))
    (truth / "seconds.json").write_text(json.dumps(seconds))


def first_difference(truth: Path, wanted: set[int], lines: dict[str, set[int]]) -> str:
    """Return the name of the first answer that differs from the truth; empty if all agree.

    Args:
        truth: Folder of the truth.
        wanted: Numbers of the commands that are run.
        lines: Lines that are being traced by file; those of each command are kept in the folder.
    """
    answers = json.loads((truth / "answers.json").read_text())
    known: dict[Path, tuple[int, int]] = {}
    new_files(known)
    by_command: dict[int, dict[str, list[int]]] = {}
    for number in range(len(COMMANDS)):
        if number not in wanted:
            if (truth / str(number)).exists():
                shutil.copytree(truth / str(number), ".", dirs_exist_ok=True)
                new_files(known)
            continue
        expected = {name for name in answers if name.partition(" ")[0] == str(number)}
        for name, text in answers_of(number, known):
            if answers.get(name) != text:
                return name
            expected.discard(name)
        if expected:
            return min(expected)
        by_command[number] = {file: sorted(numbers) for file, numbers in lines.items()}
        lines.clear()
    if any(by_command.values()):
        (truth / "lines.json").write_text(json.dumps(by_command))
    return ""


@contextlib.contextmanager
def traced() -> Iterator[dict[str, set[int]]]:
    """Collect the lines of the package that are run in the meantime, by file."""
    lines: dict[str, set[int]] = {}
    calls: Counter[CodeType] = Counter()

    def of_code(frame: FrameType, event: str, _: Any) -> Any:
        file = frame.f_code.co_filename
        if PACKAGE not in file:
            return None
        if not lines:  # of a new command
            calls.clear()
        calls[frame.f_code] += 1
        if calls[frame.f_code] > CALLS_TRACED:
            return None
        name = file.rpartition(PACKAGE)[2]

        def of_line(frame: FrameType, event: str, _: Any) -> Any:
            lines.setdefault(name, set()).add(frame.f_lineno)
            return of_line

        return of_line(frame, event, None)

    threading.settrace(of_code)
    sys.settrace(of_code)
    try:
        yield lines
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]


def main() -> None:
    """Keep what users get, or print how it differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth", type=Path, help="folder of what users get")
    parser.add_argument("--compare", action="store_true", help="print the first difference")
    parser.add_argument("--trace", action="store_true", help="keep the lines that are run, too")
    parser.add_argument("--commands", help="numbers of the commands to run, by commas")
    options = parser.parse_args()
    for name, text in FILES.items():
        Path(name).write_text(text)
    wanted = set(range(len(COMMANDS)))
    if options.commands:
        wanted = {int(number) for number in options.commands.split(",")}
    if not options.compare:
        keep_truth(options.truth, wanted)
        return
    tracing = traced() if options.trace else contextlib.nullcontext({})
    with tracing as lines:
        print(first_difference(options.truth, wanted, lines), file=sys.__stdout__)


if __name__ == "__main__":
    main()
