"""Design questions as text, and their solutions."""

from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import load_study

LOADS = '[load]\nmass = ["0 kg", "3 kg", "5 kg", "10 kg"]\n'

# Springs and spools of the paper's arm, and one of each beyond them.
CATALOGUE = (
    '[spring]\nstiffness = ["1 kN/m", "3 kN/m", "5 kN/m"]\n[spool]\nratio = [1.0, 0.7, 0.6]\n'
    + LOADS
)
RANGES = (
    '[spring]\nstiffness = { from = "1 kN/m", to = "8 kN/m", num = 8 }\n'
    "[spool]\nratio = { from = 0.5, to = 1.0, num = 6 }\n" + LOADS
)

_ANGLES = [10.0 * place for place in range(10)]
NO_UPPER_END = {
    "excursion": {
        "angle": [f"{angle} deg" for angle in _ANGLES],
        "flexor": [f"{0.87 * angle - 0.003 * angle**2} mm" for angle in _ANGLES],
        "extensor": [f"{0.78 * angle + 0.0006 * angle**2} mm" for angle in _ANGLES],
    }
}
"""Joint whose moment arms make it the stiffer the more pretension there is: windows are open."""


def question_from(text, folder):
    """Return the question of a study given as text."""
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return question_of(load_study(file))


def solved(question):
    """Solve every choice of a question."""
    return solve(Solver(question), question.all_points())
