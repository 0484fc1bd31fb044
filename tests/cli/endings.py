"""Commands that read a CSV or a table, and the files that they read."""

import math

PERSONS = """name,weight (kg),stature (cm)
a,70,175
b,80,180
c,60,165
"""
STUDY = """
[people]
file = "persons.csv"
[joint]
torque = "joint.csv"
[load]
mass = ["1 kg", "2 kg"]
[uncertainty]
usual = false
draws = 8
[design]
verify = 100
"""
WORDS = (
    ("state", "study.toml"),
    ("sweep", "study.toml", "--dry-run"),
    ("sweep", "study.toml", "--no-figures", "--out", "new"),
    ("design", "study.toml", "--dry-run"),
    ("design", "study.toml", "--no-figures", "--out", "answer"),
    ("fit-friction", "readings.csv", "--bend-angle", "144 deg"),
    ("show", "run"),
    ("show", "run/states.parquet", "--csv"),
    ("export", "run", "rows.csv"),
    ("check", "run"),
    ("plot", "run", "--out", "figure.png"),
    ("report", "run"),
)
READERS = ("show", "export", "check", "plot", "report")
"""Commands that read the run of the study."""

EXITS = {0, 4}
"""Exit codes of these commands: the answer may be negative."""
TIMES = 400
"""Number of times that each is run on a busy machine."""


def write_inputs(folder):
    """Write the study, and every CSV that a command reads, into a folder."""
    (folder / "study.toml").write_text(STUDY)
    (folder / "persons.csv").write_text(PERSONS)
    torque = [f"{angle},{0.01 * angle - 1.0:.4f}" for angle in range(-30, 170, 5)]
    (folder / "joint.csv").write_text("\n".join(["angle (deg),torque (N m)", *torque]))
    (folder / "readings.csv").write_text("\n".join(_readings()))


def _readings():
    """Yield the lines of a log of ten strokes of friction 0.1 over 144 degrees."""
    yield "time (s),force motor (N),force load (N)"
    limit = 0.1 * math.radians(144.0)
    ratio = -limit
    for row in range(1000):
        way = 1.0 if row // 100 % 2 == 0 else -1.0
        ratio = min(max(ratio + way * 0.1 * limit, -limit), limit)
        wiggle = 0.01 * ((7 * row) % 11 - 5)
        yield f"{0.02 * row:.2f},{20.0 * math.exp(ratio) + wiggle:.3f},{20.0 - wiggle:.3f}"
