"""Result of a friction fit: numbers, their origin, how far they can be trusted, and its files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from tendon_cli import say
from tendon_cli.files import begins_with, write_output
from tendon_cli.fits.friction.budget import BEND, ZEROS, FrictionUncertainty
from tendon_cli.fits.friction.rig import BendAngle
from tendon_cli.fits.friction.strokes import Presliding, Speed
from tendon_cli.fits.friction.usable_rows import REASONS, USED
from tendon_cli.fits.written import plain, toml_text
from tendon_cli.say.display import Displayed
from tendon_cli.units import counted, shorten
from tendon_cli.version import __version__

_STROKES_MARK = "# strokes of a log, by tendon fit-friction"
_MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""Beginning of a fragment."""
_HEADER = f"""\
{_MARK} To use it in a study:
#     [sheath]
#     friction_from = "friction.toml"
"""
is_fragment = begins_with(_MARK)
"""Function that recognises a fragment."""
is_strokes = begins_with(_STROKES_MARK)
"""Function that recognises a table of strokes."""
_OF_THE_RIG = "# The bend angle is that of the rig, not of the study's sheath.\n"
_OF_ONE_SHEATH = (
    '#     bend_angle = "..."      # not known here: give that of this sheath'
    " when μφ was measured\n"
)
DOUBT = "do not use this number"
"""Beginning of the warning that stands above the number."""
_MOST_RESIDUALS = 20
"""Number of the largest residuals that a record lists."""
_MOST_STRETCHES = 20
"""Largest number of stretches of readings that are listed for each reason to set them aside."""
_RECORDED = (
    "friction",
    "standard_error",
    "interval_95",
    "friction_bend",
    "friction_bend_standard_error",
    "friction_bend_interval_95",
    "gain_ratio",
    "by_direction",
    "plain",
    "strokes",
    "speed",
    "presliding",
    "files",
    "set_aside",
    "warnings",
    "notes",
    "checks",
    "unit",
    "source",
    "sha256",
)
"""Fields and properties of a fit that its record has under the same names."""


@dataclass(frozen=True)
class DirectionFit:
    """Fit of one direction alone, with the gain of the cells taken as 1, as the paper does it."""

    friction: float
    """μ."""
    standard_error: float | None
    """Standard error of μ; None if the direction has only one stroke."""
    plain: float
    """Plain answer: the median of |ln ratio| over the bend angle, by rows beyond the middle."""
    used: int
    """Number of readings used."""


@dataclass(frozen=True)
class SetAside:
    """Readings that are not used, for one reason."""

    reason: str
    rows: int
    """Number of readings."""
    lines: tuple[tuple[int, int], ...]
    """First and last line of the first 20 stretches of them."""


@dataclass(frozen=True)
class Check:
    """Check of one thing that may be wrong with the rig."""

    name: str
    value: float | None = None
    """None if the readings cannot show it."""
    standard_error: float | None = None
    unit: str = "1"
    found: bool | None = None
    """True if the readings show it, False if they do not; None if they cannot."""
    effect_on_friction: float | None = None
    """Change of μ if it is left out of the fit, as a share of μ."""


@dataclass(frozen=True)
class PlainAnswer:
    """Plain answer, and the reasons why the fit differs from it."""

    friction: float
    """Mean of both directions' medians, in which gains cancel."""
    moved_by_rows: float
    """Change of μ if rows are set aside, as a share of μ."""
    moved_by_fit: float
    """Further change of μ by the effects and the weights of strokes, as a share of μ."""


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Displayed):
    """Friction coefficient with its uncertainty and provenance."""

    friction_bend: float
    """μφ; with several bend angles at their mean."""
    bend_angle: float | None
    """Mean of the bend angles used, rad; None if it was not given."""
    uncertainty: FrictionUncertainty
    """Uncertainty of μ, or of μφ without a bend angle."""
    gain_ratio: float
    """Gain of the motor's cell over that of the load's; 1 if it could not be estimated."""
    by_direction: dict[str, DirectionFit]
    """"toward_motor" and "toward_load", as far as there are readings; the gain needs both."""
    plain: PlainAnswer
    bend: BendAngle
    """Bend angle as given, or in degrees if it comes from a column; "not given"."""
    motor: str
    """"1" or "2", the cell at the motor."""
    is_log: bool
    """True if the readings are a raw log rather than settled readings."""
    rows: pd.DataFrame
    """Table with a row per reading.

    It has `line` and number of its `file`, forces `motor` and `load` (stated zeros taken off, in
    the unit of the file), `log_ratio` (NaN without one), `way` (+1 toward the motor, -1 toward the
    load, 0 if it is set aside before), `bend_angle` (rad), `run` (number of its stroke, -1 if
    none), `used`, `code` (why it is not), `residual` (NaN if not used), and, if the file has them,
    `time`, and the motor's `position` or `speed`.
    """
    stroke_table: pd.DataFrame
    """Table with a row per stroke, used or not, that `--strokes` writes."""
    speed: Speed | None
    """Dependence of μ on speed, if the strokes have different speeds."""
    presliding: Presliding | None
    """Stiffness and backlash of the motor's end, if a position is read."""
    files: tuple[dict[str, Any], ...]
    """μ of each file, if there are several."""
    points: pd.DataFrame
    """Table of means over parts of strokes, by which the rig is checked.

    It has `way`, `force` at the load, `rate` d ln F/dt if there is a time, `misfit` of the log
    ratio before effects, the part of it that the `effects` that were fitted explain, and the part
    of these that a `delay` explains.
    """
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """Sentences on what was inferred, and on what the coefficient is sensitive to."""
    warnings: tuple[str, ...]
    """Sentences on what may make this very number wrong."""
    unit: str | None
    """Unit of the forces; None if the file does not say."""
    source: str
    """Name of the file."""
    sha256: str

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_fit"

    @property
    def text(self) -> str:
        """Result in words, a line for each number, note and warning."""
        uncertainty = self.uncertainty
        digits = _digits(uncertainty.standard_error)
        low, high = uncertainty.interval_95
        interval = f"{low:.{digits}f} to {high:.{digits}f}"
        gain = f"{self.gain_ratio:.4f}, motor's cell (cell {self.motor}) over load's; μ is"
        gain += " corrected for it"
        if len(self.by_direction) == 1:
            gain = "1, assumed (one direction only)"
        rows = [
            ("95 % interval", f"{interval}, standard error {uncertainty.standard_error:.2g}"),
            *_zero_rows(self),
            ("bend angle", _bend_text(self)),
            ("gain ratio", gain),
        ]
        for name, direction in self.by_direction.items():
            text = f"{direction.friction:.{digits}f}"
            if direction.standard_error is not None:
                text += f" ± {direction.standard_error:.{digits}f}"
            text += f" with a gain ratio of 1, {counted(direction.used, 'reading')}"
            rows.append((say.spaced(name), text))
        rows.append(("plain answer", _plain_text(self, digits)))
        for place, part in enumerate(uncertainty.parts):
            kind = f"type {part.type}"
            if not math.isinf(part.degrees_of_freedom):
                kind += f", {part.degrees_of_freedom:.0f} degrees of freedom"
            name = "standard error from" if place == 0 else ""
            rows.append((name, f"{part.contribution:.2g} {part.name} ({kind})"))
        rows += _readings_rows(self)
        answer = (
            "friction over the bend  μφ" if self.friction is None else "friction coefficient  μ"
        )
        lines = [f"warning: {text}" for text in self.warnings if text.startswith(DOUBT)]
        lines.append(f"{answer} = {self.fitted:.{digits}f}")
        lines += [f"  {name:<20}{text}" for name, text in rows]
        lines += [f"note: {text}" for text in self.notes]
        lines += [f"warning: {text}" for text in self.warnings if not text.startswith(DOUBT)]
        return "\n".join(lines)

    @property
    def strokes(self) -> int:
        """Number of strokes used."""
        return int(np.count_nonzero(self.stroke_table["used"]))

    @property
    def leaves_out_most(self) -> bool:
        """True if fewer than half of the strokes are used."""
        return 2 * self.strokes < len(self.stroke_table)

    @property
    def is_doubtful(self) -> bool:
        """True if the first warning is not to use the number."""
        return any(text.startswith(DOUBT) for text in self.warnings)

    @property
    def bend_angles(self) -> tuple[float, ...]:
        """Different bend angles of the readings used, rad; empty if none is given."""
        if self.bend_angle is None:
            return ()
        return tuple(np.unique(self.rows["bend_angle"][self.rows["used"]]).tolist())

    @property
    def set_aside(self) -> tuple[SetAside, ...]:
        """Readings not used, by reason, in the order in which the reasons first occur."""
        parts = []
        lines = self.rows["line"].to_numpy()
        codes = self.rows["code"].to_numpy()
        for code in pd.unique(codes[codes != USED]):
            rows = np.flatnonzero(codes == code)
            border = np.flatnonzero(np.diff(rows) > 1)[:_MOST_STRETCHES]
            first = rows[np.append(0, border + 1)]
            last = rows[np.append(border, -1)]
            stretches = [
                (int(lines[start]), int(lines[end])) for start, end in zip(first, last, strict=True)
            ]
            parts.append(SetAside(REASONS[code], len(rows), tuple(stretches[:_MOST_STRETCHES])))
        return tuple(parts)

    @property
    def record(self) -> dict[str, Any]:
        """Fit as plain JSON values, as `--json` prints it; angles in rad."""
        used = self.rows[self.rows["used"]]
        residuals = used["residual"].to_numpy()
        lines = used["line"].to_numpy()
        largest = np.argsort(-np.abs(residuals), kind="stable")[:_MOST_RESIDUALS]
        bend_angle: Any = self.bend_angles or None
        if len(self.bend_angles) == 1:
            bend_angle = self.bend_angles[0]
        record = {name: getattr(self, name) for name in _RECORDED} | {
            "bend_angle": bend_angle,
            "budget": self.uncertainty.parts,
            "coverage_factor": self.uncertainty.coverage,
            "degrees_of_freedom": self.uncertainty.degrees_of_freedom,
            "used": len(used),
            "residuals": {
                "rms": float(np.sqrt(np.mean(residuals**2))),
                "max": float(np.max(np.abs(residuals))),
                "rows": [
                    {"line": int(lines[row]), "residual": float(residuals[row])} for row in largest
                ],
            },
        }
        return dict(plain(record))

    @property
    def fitted(self) -> float:
        """μ, or μφ without a bend angle."""
        return self.friction_bend / (self.bend_angle or 1.0)

    @property
    def from_plain(self) -> float:
        """Difference of the fit from the plain answer, as a share of that."""
        if not self.plain.friction:
            return 0.0
        return self.fitted / self.plain.friction - 1.0

    @property
    def friction(self) -> float | None:
        """Coulomb coefficient μ between tendon and sheath; None without a bend angle."""
        return None if self.bend_angle is None else self.fitted

    @property
    def standard_error(self) -> float | None:
        """Standard error of μ, all its parts together."""
        return None if self.bend_angle is None else self.uncertainty.standard_error

    @property
    def interval_95(self) -> tuple[float, float] | None:
        """95 % interval of μ."""
        return None if self.bend_angle is None else self.uncertainty.interval_95

    @property
    def friction_bend_standard_error(self) -> float:
        """Standard error of μφ, to which the uncertainty of the bend angle adds nothing."""
        variance = self.uncertainty.standard_error**2 - self.uncertainty.contribution_of(BEND) ** 2
        return math.sqrt(max(variance, 0.0)) * (self.bend_angle or 1.0)

    @property
    def friction_bend_interval_95(self) -> tuple[float, float]:
        """95 % interval of μφ."""
        half = self.uncertainty.coverage * self.friction_bend_standard_error
        return self.friction_bend - half, self.friction_bend + half


# --- Words ----------------------------------------------------------------------------------------


def _zero_rows(fit: Fit) -> list[tuple[str, str]]:
    """Return a row on zero errors that are assumed, if most of the interval comes from them."""
    uncertainty = fit.uncertainty
    zeros = [part for part in uncertainty.parts if part.name in ZEROS]
    without = uncertainty.standard_error**2 - sum(part.contribution**2 for part in zeros)
    if not zeros or without > 0.5 * uncertainty.standard_error**2:
        return []
    assumed = max(part.standard_uncertainty for part in zeros)
    left = 100.0 * math.sqrt(max(without, 0.0)) / uncertainty.standard_error
    unit = f" {fit.unit}" if fit.unit else ""
    text = (
        f"mostly from the cells' zeros, {assumed:.2g}{unit} each: {left:.0f} % of its width without"
    )
    return [("", text), ("", "them; log rests without load, or state --cell-uncertainty")]


def _readings_rows(fit: Fit) -> list[tuple[str, str]]:
    """Return rows on the readings used, and on what else they show."""
    where = "on the limit" if fit.is_log else "settled"
    used = f"{fit.rows['used'].sum():,} of {len(fit.rows):,} {where}"
    rows = [("readings", f"{used}, in {counted(fit.strokes, 'stroke')}")]
    rows += [("set aside", f"{aside.rows}: {aside.reason}") for aside in fit.set_aside]
    if speed := fit.speed:
        span = f"from {speed.slowest:.3g} to {speed.fastest:.3g}"
        rows.append(("power of speed", f"{speed.power:+.3f} ± {speed.standard_error:.2g}, {span}"))
    if presliding := fit.presliding:
        stiffness = f"stiffness {presliding.stiffness:.3g}, backlash {presliding.backlash:.3g}"
        reversals = counted(presliding.reversals, "reversal")
        rows.append(("before it slides", f"{stiffness}, {reversals}"))
    for file in fit.files:
        text = "nothing used" if file["friction"] is None else f"{file['friction']:.4g}"
        rows.append((shorten(file["file"], 18), f"{text}, {counted(file['strokes'], 'stroke')}"))
    for check in fit.checks:
        if check.found and check.name != "gain":
            text = f"{check.value:.3g} ± {check.standard_error:.2g}"
            if check.unit != "1":
                text += f" {check.unit}"
            if check.effect_on_friction:
                text += f", fitted: {100.0 * check.effect_on_friction:+.1f} % of μ without it"
            rows.append((say.spaced(check.name), text))
    return rows


def _digits(error: float) -> int:
    """Return the decimals that show a standard error with two significant digits."""
    return min(9, max(2, 1 - math.floor(math.log10(error))))


def _bend_text(fit: Fit) -> str:
    """Return the bend angle with its uncertainty, and μφ."""
    text = fit.bend.text
    product = f"μφ = {fit.friction_bend:.4g}"
    if not fit.bend_angles:
        return "not given, so the answer is μφ; give --bend-angle for μ"
    if fit.bend.uncertainty_text:
        return f"{text} +/- {fit.bend.uncertainty_text}; {product}"
    if len(fit.bend_angles) > 1:
        return text
    share = 100.0 * math.radians(1.0) / fit.bend_angles[0]
    return f"{text} (taken as exact; 1 deg more gives {share:.1f} % less μ); {product}"


def _plain_text(fit: Fit, digits: int) -> str:
    """Return the plain answer, which ten lines of NumPy give, and why the fit differs."""
    plain = fit.plain
    changes = {"by rows set aside": plain.moved_by_rows, "by fitted effects": plain.moved_by_fit}
    reasons = [
        f"{100.0 * share:+.1f} % {reason}"
        for reason, share in changes.items()
        if abs(share) >= 5e-4
    ]
    text = f"{plain.friction:.{digits}f}, median |ln ratio|"
    text += f"; the fit is {100.0 * fit.from_plain:+.1f} % from it"
    return f"{text}: {', '.join(reasons)}" if reasons else text


# --- Files ---------------------------------------------------------------------------------------


def write_fragment(fit: Fit, path: Path, *, overwrite: bool = False) -> None:
    """Write the coefficient (or μφ) for a study, with its uncertainty and its source.

    The file is written whole or not at all. One that tendon did not write is replaced only if
    `overwrite` is true.

    Raises:
        UsageError: if tendon did not write the file.
        OutputError: if it cannot be written.
    """
    values: dict[str, Any] = {}
    if fit.friction is not None:
        values = {
            "coefficient": fit.friction,
            "standard_error": fit.standard_error,
            "interval_95": fit.interval_95,
            "bend_angle": fit.bend.text,
            "bend_angle_uncertainty": fit.bend.uncertainty_text,
        }
    values |= {
        "friction_bend": fit.friction_bend,
        "friction_bend_standard_error": fit.friction_bend_standard_error,
        "gain_ratio": fit.gain_ratio,
        "source": fit.source,
        "sha256": fit.sha256,
        "rows_used": int(fit.rows["used"].sum()),
        "rows_set_aside": int((~fit.rows["used"]).sum()),
        "tendon_version": __version__,
    }
    lines = [
        f"{key} = {toml_text(value)}" for key, value in values.items() if value not in {None, ""}
    ]
    header = _HEADER + (_OF_ONE_SHEATH if fit.friction is None else _OF_THE_RIG)
    content = "\n".join([header, "[friction]", *lines, ""]).encode()
    write_output(path, content, is_fragment, overwrite=overwrite)


def write_strokes(fit: Fit, path: Path, *, overwrite: bool = False) -> None:
    """Write the table of strokes as CSV.

    A file that tendon did not write is replaced only if `overwrite` is true.

    Raises:
        UsageError: if tendon did not write the file.
        OutputError: if the file cannot be written.
    """
    content = f"{_STROKES_MARK}\n{fit.stroke_table.to_csv(index=False)}".encode()
    write_output(path, content, is_strokes, overwrite=overwrite)
