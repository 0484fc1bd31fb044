"""Checks of the rig, and remarks on what may be wrong with the number and what helps."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass

import numpy as np

from tendon_cli import say
from tendon_cli.fits.friction.budget import (
    FEW,
    FEW_SHARE,
    LATE,
    LEAST_SCATTER,
    RESOLUTION,
    ZEROS,
)
from tendon_cli.fits.friction.effects import DELAY, ENTRY, FORCE, OFFSETS, STRICT
from tendon_cli.fits.friction.estimate import FrictionEstimate, climbing
from tendon_cli.fits.friction.fit_result import DOUBT, Check, Fit
from tendon_cli.fits.friction.models import REFUTED
from tendon_cli.fits.friction.strokes import disagreement
from tendon_cli.fits.friction.usable_rows import (
    AT_REST,
    LOG_ROWS,
    NOT_POSITIVE,
    SATURATED,
    SPIKE,
    UNLOADED,
    Log,
)
from tendon_cli.fits.log_rows import Floats, means_by
from tendon_cli.units import counted, force_factor, shorten

_SHOWN = 0.5
"""Probability above which the readings show an effect."""
_OPEN = 0.05
"""Probability below which an effect is absent; between the two it is open."""
_MATTERS = 0.02
"""Share of μ from which something is a warning."""
_NOTED = 0.005
"""Share of μ from which something is a note."""
_MOST = {
    SATURATED: (0.10, "are saturated, so what slips there is unknown; use cells of a larger range"),
    SPIKE: (0.10, "are spikes, and the readings between them may be wrong too; check the wiring"),
    NOT_POSITIVE: (
        0.15,
        "are at or below zero: the tendon is slack or a cell's zero is off; load the tendon",
    ),
}
"""Largest share of rows with each fault, and words for more: the fault then selects the rest."""
_LOOK_ALIKE = {
    FORCE: "friction that depends on the force or, behind a spring, on the place",
    DELAY: "a late cell",
}
"""Effects that look like zero errors that are alike in both cells, in words."""
_NOTED_ZERO = 0.01
"""Reading of a cell without load, as a share of the force, from which it is a note."""
_GAIN_NOTE = 0.05
"""Difference of the cells' gains, as a share, from which it is a note."""
_GAIN_WARNING = 0.20
"""Difference of the cells' gains, as a share, from which it is a warning."""
_PLAIN_AWAY = 0.25
"""Difference from the plain answer, as a share of it, from which it is a warning."""
_LATE = 0.03
"""Delay, as a share of a stroke, from which it is a warning."""
_FAR_FORCES = 0.05
"""Difference of the forces of the two directions, as a share, from which a zero error does not act
on both alike."""
_DRIFT_STROKES = 6
"""Least number of strokes that show a drift."""
_BY_CHANCE = 0.02
"""Probability below which a drift is shown; two drifts are tried, of μ and of the gain, so
chance makes at most four in a hundred logs."""
_HARDLY_BY_CHANCE = 0.002
"""Probability below which a drift of a zero is shown: it is warned of when it is small, too."""
_ZERO_MOVES = 0.01
"""Least share of μ by which a drift of a zero must move it to be warned of."""
_CLIMBS = 0.02
"""Climb over a stroke, as a share of the way from limit to limit, from which rows have not
settled."""
_LARGEST_PRODUCT = 2.0
"""Largest μφ of a sheath: one cell then reads seven times the other."""
_USUAL_FRICTION = 0.1
"""Usual friction coefficient of a tendon in a sheath."""
_LARGEST_FRICTION = 0.5
"""Friction coefficient above those of all sheaths, by which the bend angle is in doubt."""
_ENOUGH_STROKES = 6
"""Number of strokes whose number is used though most of the others are not, if the rows agree."""
_FEW_USED = 0.30
"""Share of rows on a limit that strokes that slip exceed."""


def doubts_of(fit: Fit, column: str) -> list[str]:
    """Return the one warning that comes first: what was read may not be what was measured.

    Args:
        fit: Fit.
        column: Header of a column that may say the direction but is not read; "" if there is none.
    """
    reasons = []
    is_alone = fit.strokes < _ENOUGH_STROKES or abs(fit.from_plain) > _PLAIN_AWAY
    if fit.leaves_out_most and is_alone:
        reasons.append(f"{strokes_used(fit)} found can be used (--plot shows them)")
    is_bare = fit.rows["code"].isin([UNLOADED, NOT_POSITIVE]).any()
    if column and is_bare:
        name = f'"{shorten(column, 30)}"'
        reasons.append(
            f"there are rows without load, and {name}, which looks like the direction, is not read:"
            f" give --direction {shlex.quote(column)}"
        )
    if fit.friction_bend > _LARGEST_PRODUCT:
        reasons.append(
            f"μφ is {fit.friction_bend:.3g}, so one cell reads {math.exp(fit.friction_bend):.1f}"
            " times the other: check that both measure one tendon, and their units and zeros"
        )
    elif fit.friction is not None and fit.friction > _LARGEST_FRICTION:
        stated = math.degrees(fit.friction_bend / fit.friction)
        usual = math.degrees(fit.friction_bend / _USUAL_FRICTION)
        reasons.append(
            f"μ is {fit.friction:.2g}, and sheaths have 0.03 to 0.3: these readings suggest a bend"
            f" of about {usual:.0f} deg (at μ = {_USUAL_FRICTION:g}), not of {stated:.3g} deg"
        )
    return [f"{DOUBT}: {'; '.join(reasons)}"] if reasons else []


def strokes_used(fit: Fit) -> str:
    """Return how many of the strokes are used, in words."""
    return f"only {fit.strokes} of {counted(len(fit.stroke_table), 'stroke')}"


def _regression(columns: list[Floats], target: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit a target by columns; return values, standard errors, and the chance of such values."""
    from scipy.special import stdtr

    design = np.stack(columns, axis=1)
    inverse = np.linalg.pinv(design.T @ design)
    values = inverse @ design.T @ target
    free = max(len(target) - design.shape[1], 1)
    squares = np.sum((target - design @ values) ** 2)
    error = np.sqrt(np.maximum(np.diag(inverse) * squares / free, 1e-300))
    return values, error, 2.0 * stdtr(free, -np.abs(values) / error)


@dataclass(eq=False)
class Remarks:
    """Remarks on a fit, each in one line: the finding, its effect on μ, and what to do about it."""

    fit: Fit
    log: Log
    result: FrictionEstimate
    time_unit: str
    zeros: tuple[float, float]
    """Stated readings of the motor's and of the load's cell without load; 0 if not stated."""
    zero_given: bool
    without_load: tuple[dict[str, float], dict[str, float]]
    """Readings of both at rest without load, as `readings_without_load` returns them."""

    def __post_init__(self) -> None:
        """Make `checks`, `notes` and `warnings`."""
        fit = self.fit
        self.points = self.result.points
        self.friction = self.result.friction
        self.average = self.result.average
        self.mu = "μφ" if fit.bend_angle is None else "μ"
        self.unit = f" {fit.unit}" if fit.unit else ""
        self.checks: list[Check] = []
        self.notes = [*fit.notes]
        self.warnings = [*fit.warnings]
        self.note = self.notes.append
        self.warn = self.warnings.append
        self.is_ambiguous = self._check_look_alikes()
        self._check_effects()
        self._check_which_cell()
        self._check_rare_delay()
        self._check_drift()
        for number, end in enumerate(("motor", "load")):
            if self.without_load[number]:
                self._remark_without_load(number, end, self.without_load[number])
        if not any(self.without_load):
            self._check_zeros()
        self._check_late()
        self._check_gains()
        self._check_rows()
        self._check_number()

    def _check_look_alikes(self) -> bool:
        """Warn of effects that these readings cannot tell apart, if μ depends on which it is."""
        likely = [
            model
            for model, weight in zip(self.average.models, self.average.weights, strict=True)
            if weight > _OPEN
        ]
        frictions = [model.friction for model in likely]
        spread = (max(frictions) - min(frictions)) / self.friction
        if spread < _MATTERS or not any(model.has_alike_zeros for model in likely):
            return False
        causes = ["zero errors that are alike in both cells"]
        for effect, cause in _LOOK_ALIKE.items():
            if any(effect in model.effects for model in likely):
                causes.append(cause)
        if len(causes) == 1:
            return False
        self.warn(
            f"these readings cannot tell {say.join_words(causes, 'from')}: {self.mu} may be"
            f" anything from {min(frictions):.3g} to {max(frictions):.3g}, which the interval"
            " allows for; state what the cells read without load (--zero-motor, --zero-load)"
        )
        return True

    def _check_effects(self) -> None:
        """Check for each effect that can be fitted, and warn of those that change the number."""
        for effect in (*OFFSETS, DELAY, FORCE, ENTRY):
            check = self._check(effect)
            value = check.value or 0.0
            if effect != ENTRY or check.found is not None:
                self.checks.append(check)
            if not check.found:
                continue
            stroke_share = abs(value) / self.log.duration
            if effect == DELAY and stroke_share > _LATE:
                cell = "load" if value > 0.0 else "motor"
                grows = "grows" if value > 0.0 else "falls"
                self.warn(
                    f"delay: the {cell}'s cell is {abs(value):.3g} {check.unit} late,"
                    f" {100.0 * stroke_share:.0f} % of a stroke, or friction {grows} with the"
                    f" speed, which looks the same; {self.mu} is corrected for it; log both cells"
                    " with one clock and one filter, and move more slowly"
                )
            if effect == FORCE and not self.is_ambiguous:
                self.warn(
                    f"{self.mu} varies with the force to the power {value:.2g}:"
                    " the number holds at the mean force; measure at the force that you use"
                )
            if effect == ENTRY:
                self.warn(
                    f"friction outside the bend takes {value:.3g} ± {check.standard_error:.1g}"
                    f" of the log ratio and is not in {self.mu};"
                    " look for what rubs at the ends of the sheath"
                )

    def _check(self, effect: str) -> Check:
        """Check for one effect by the likeliest model that has it."""
        average = self.average
        delay = self.result.delay if effect == DELAY else 0.0
        unit = "1"
        if effect in OFFSETS:
            unit = self.fit.unit or "unit of the file"
        elif effect == DELAY:
            unit = self.time_unit
        having = [place for place, model in enumerate(average.models) if effect in model.effects]
        if not having:
            if delay:
                return Check(effect, delay, 0.0, unit, found=True)
            return Check(effect, unit=unit)
        model = average.models[max(having, key=average.weights.__getitem__)]
        share = average.share_of(effect)
        value, error = model.value(effect)
        scale = model.friction if effect == FORCE else 1.0
        moves = average.models[0].friction / model.friction - 1.0
        is_shown = bool(delay) or share > _SHOWN
        matters = abs(moves) + 2.0 * model.error / model.friction > _MATTERS
        if not is_shown and share > _OPEN and matters:
            return Check(effect, unit=unit)
        return Check(effect, (value + delay) / scale, error / abs(scale), unit, is_shown, moves)

    def _check_which_cell(self) -> None:
        """Warn if the readings show a zero error, but not in which cell, and μ depends on that.

        Explanations count that the readings do not refute.
        """
        best = self.average.best
        if self.is_ambiguous or not best.fits_zero:
            return
        rivals = [
            model.friction
            for model in self.average.models
            if model.fits_zero and model.evidence > best.evidence - REFUTED
        ]
        if self.fit.uncertainty.holds(min(rivals)) and self.fit.uncertainty.holds(max(rivals)):
            return
        self.warn(
            f"the readings show a zero error, but hardly in which cell: {self.mu} may be anything"
            f" from {min(rivals):.3g} to {max(rivals):.3g};"
            " state what the cells read without load (--zero-motor, --zero-load)"
        )

    def _check_rare_delay(self) -> None:
        """Warn of a delay that the readings favour, but that is left out because it is rare.

        It is warned of if μ would then lie outside the interval.
        """
        models = self.average.models
        likeliest = max(model.evidence for model in models if DELAY not in model.effects)
        late = [model for model in models if DELAY in model.effects]
        if self.result.delay or not late or DELAY in self.average.best.effects:
            return
        best = max(late, key=lambda model: model.evidence)
        if best.evidence + STRICT[DELAY] <= likeliest or self.fit.uncertainty.holds(best.friction):
            return
        value = best.value(DELAY)[0]
        cell = "load" if value > 0.0 else "motor"
        self.warn(
            f"delay: the {cell}'s cell may be {abs(value):.2g} {self.time_unit} late, which these"
            f" readings hardly show; {self.mu} would be {best.friction:.4g}; log both cells with"
            " one clock and one filter, and make the strokes longer"
        )

    def _check_drift(self) -> None:
        """Test if strokes change along the file, which is never fitted."""
        points = self.points
        if points.strokes < _DRIFT_STROKES:
            self.checks.append(Check("drift"))
            return
        residual = means_by(points.stroke, self.average.best.residual)
        bend = means_by(points.stroke, points.way * points.bend)
        place = means_by(points.stroke, points.place)
        slopes = [self.friction * bend * place, bend]  # of a drift of μ, and of μ
        if points.both_ways:
            slopes += [place, np.ones(len(residual))]  # of a drift of the gain, and of the gain
        values, error, chance = _regression(slopes, residual)
        drifts = (chance < _BY_CHANCE) & (np.abs(values) > _MATTERS)
        zero_drift = "" if drifts[::2].any() else self._zero_drift(residual, bend, place)
        has_drift = bool(drifts[::2].any()) or bool(zero_drift)
        self.checks.append(Check("drift", float(values[0]), float(error[0]), "1", has_drift, 0.0))
        speed = self.fit.speed
        if drifts[0] and speed and abs(speed.power) > 3.0 * speed.standard_error:
            self.warn(
                f"{self.mu} varies with the speed to the power {speed.power:.2g}: the number is a"
                " mean over the speeds in the file; measure at the speed that you use"
            )
            drifts[0] = False
        if zero_drift:
            self.warn(zero_drift)
        changes = {self.mu: values[0]} if drifts[0] else {}
        if points.both_ways and drifts[2]:
            changes["the ratio of the cells at the same force"] = values[2]
        if changes:
            said = [f"{name} changes by {100.0 * value:+.1f} %" for name, value in changes.items()]
            self.warn(
                f"drift: {' and '.join(said)} over the file, so {self.mu} is a mean; a cell's zero"
                " or gain drifts, their clocks part, or the tendon warms up or runs in: read the"
                " cells without load before and after, warm them up, run the tendon in, and measure"
                " again"
            )

    def _zero_drift(self, residual: Floats, bend: Floats, place: Floats) -> str:
        """Return a warning of a cell whose zero drifts; "" if none does.

        It is one number, which adds place/F to the log ratio, and shows where a change of the gain
        does not. It matters if it may move μ by more than the interval allows for.

        Args:
            residual: Mean residual of each stroke.
            bend: Mean bend angle of each stroke, with the sign of its direction.
            place: Place of each stroke in the file, from -1/2 to 1/2.
        """
        points = self.points
        models = self.average.models
        if not points.both_ways:
            return ""
        low, high = self.fit.uncertainty.interval_95
        allowed = max(0.5 * (high - low), _ZERO_MOVES * self.friction)
        for number, (end, cell) in enumerate((("motor", points.motor), ("load", points.load))):
            inverse_force = means_by(points.stroke, 1.0 / cell)
            slopes = [inverse_force * place, bend, np.ones(len(residual))]
            if any(OFFSETS[number] in model.effects for model in models):
                slopes.append(inverse_force)
            values, _, chance = _regression(slopes, residual)
            moved = abs(models[0].zero[number] * float(values[0]))
            if chance[0] < _HARDLY_BY_CHANCE and moved > allowed:
                return (
                    f"drift: the zero of the {end}'s cell changes by {values[0]:+.2g}{self.unit}"
                    f" over the file, which may move {self.mu} by"
                    f" {100.0 * moved / self.friction:.1f} %: read the cells without load before"
                    " and after, warm them up, and measure again"
                )
        return ""

    def _remark_without_load(self, number: int, end: str, left: dict[str, float]) -> None:
        """Say what a cell reads at rest without load, before and after the strokes.

        Args:
            number: 0 for the motor's cell, 1 for the load's.
            end: "motor" or "load".
            left: Reading at the start and at the end of the file, a stated zero taken off.
        """
        mean = float(np.mean(list(left.values())))
        slope = self.average.models[0].zero[number] / self.friction
        moved = abs(slope * mean)
        span = float(np.ptp(list(left.values())))
        for place, check in enumerate(self.checks):
            if check.name == OFFSETS[number] and check.found is None:
                is_off = moved > _NOTED
                self.checks[place] = Check(check.name, mean, span / 2.0, check.unit, is_off, 0.0)
        # Under a constant force a zero error of the load's cell passes for a gain.
        force = float(self.fit.rows.loc[self.fit.rows["used"], end].median())
        is_gain = abs(mean) > _NOTED_ZERO * force
        if max(moved, abs(slope) * span) <= _NOTED and not is_gain:
            return
        zero = self.zeros[number]
        read = [f"{zero + force:.3g}{self.unit} at the {name}" for name, force in left.items()]
        option = f'--zero-{end} "{zero + mean:.3g}{self.unit}"'
        means = ": its zero drifts, and one zero for the whole file takes off no more than the mean"
        if moved > _NOTED:
            means = f", which moves {self.mu} by {100.0 * moved:.1f} % unless it is taken off:"
            means += f" {option}"
        elif is_gain:
            share = 100.0 * abs(mean) / force
            means = f", {share:.1f} % of the force, which passes for a gain here: take it off by"
            means += f" {option}"
        is_fitted = OFFSETS[number] in self.average.best.effects
        remark = self.warn if moved > _MATTERS and not is_fitted else self.note
        remark(f"without load the {end}'s cell reads {' and '.join(read)}{means}")

    def _check_zeros(self) -> None:
        """Say how far a zero error would move μ, if the readings do not show it."""
        models = self.average.models
        points = self.points
        unit = self.fit.unit
        is_fitted = any(model.fits_zero for model in models)
        if is_fitted or self.zero_given or not points.both_ways:
            return
        # Without a unit, 1 % of the force takes the place of 1 N.
        newton = 1.0 / (force_factor(unit) or 1.0) if unit else 0.01 * float(np.mean(points.load))
        moved = max(abs(slope) * newton / self.friction for slope in models[0].zero)
        amount = "1 N" if unit else "1 % of the force"
        would = f"a zero error of {amount} in a cell would move {self.mu} by {100.0 * moved:.1f} %"
        up = float(np.mean(np.log(points.load[points.way == 1])))
        down = float(np.mean(np.log(points.load[points.way == -1])))
        difference = abs(up - down)
        if difference > _FAR_FORCES and moved > _MATTERS:
            self.warn(
                f"the forces of the two directions differ by {100.0 * difference:.0f} %: {would};"
                " state the cells' zeros (--zero-motor, --zero-load)"
            )
        elif moved > _NOTED:
            parts = self.fit.uncertainty.parts
            assumed = [part.standard_uncertainty for part in parts if part.name in ZEROS]
            room = ""
            if assumed:
                force = f"{max(assumed):.2g}{self.unit}"
                room = f"; the interval allows for {force} (--cell-uncertainty states yours)"
            self.note(f"{would}, and these forces would not show it{room}")

    def _check_late(self) -> None:
        """Say how far a late cell would move μ, if it is assumed and not known how late one is."""
        for part in self.fit.uncertainty.parts:
            share = part.contribution / self.friction
            if part.name == LATE and share > _NOTED:
                self.note(
                    f"a cell that is {part.standard_uncertainty:.2g} {part.unit} late would move"
                    f" {self.mu} by {100.0 * share:.1f} %, and while the force changes steadily"
                    " these readings would not show it; the interval allows for it"
                    " (--cell-uncertainty states yours)"
                )

    def _check_gains(self) -> None:
        """Compare the gains of the cells, or say that one direction alone does not show them."""
        if not self.points.both_ways:
            has_both = len(np.unique(self.log.way)) == 2
            found = "only one direction reaches a limit" if has_both else "one direction only"
            change = 1.0 / float(self.points.bend.max()) / self.friction
            (self.warn if has_both else self.note)(
                f"{found}: gain and zero errors of the cells hide in {self.mu};"
                f" 1 % between the gains would change it by {change:.1f} %"
            )
            self.checks.append(Check("gain"))
            return
        average = self.average
        gain = math.exp(average.log_gain)
        error = math.sqrt(max(float(average.best.covariance[1, 1]), 0.0))
        differs = self.points.strokes > 2 and abs(average.log_gain) > max(3.0 * error, 1e-3)
        self.checks.append(Check("gain", gain, error, "1", differs, 0.0))
        excess = max(gain, 1.0 / gain) - 1.0
        reads = f"one cell reads {100.0 * excess:.0f} % more than the other at the same force"
        if excess > _GAIN_WARNING:
            self.warn(
                f"{reads}: one of them is not calibrated, or does not measure this tendon;"
                " load both with the same weight"
            )
        elif excess > _GAIN_NOTE:
            self.note(f"{reads}; this cancels between the directions, but calibrate the cells")

    def _check_rows(self) -> None:
        """Warn of many rows set aside for one fault, and of rows that have not settled."""
        codes = self.fit.rows["code"].to_numpy()
        strokes = np.flatnonzero(self.fit.rows["run"] >= 0)
        moving = codes[strokes[0] : strokes[-1] + 1]
        moving = moving[moving != AT_REST]
        for code, (most, text) in _MOST.items():
            # Before and after the strokes a tendon may be slack.
            share = float(np.mean((moving if code == NOT_POSITIVE else codes) == code))
            if share > most:
                self.warn(f"{100.0 * share:.0f} % of the rows {text}")
        if self.fit.leaves_out_most and not self.fit.is_doubtful:
            self.note(
                f"{strokes_used(self.fit)} found reach the limit; the others are left out, and the"
                " rows as a whole show the same number"
            )
        share = float(np.mean(self.result.used))
        if share < _FEW_USED:
            self.warn(
                f"only {100.0 * share:.0f} % of the rows lie on a limit, so {self.mu} may come"
                " from peaks: a cell is late or the strokes are short; log both cells with one"
                " clock and make the strokes longer"
            )
        climb = climbing(self.log, self.result)
        if climb > _CLIMBS:
            self.warn(
                f"the force ratio still climbs on the limit, by {100.0 * climb:.0f} % of its change"
                f" in a stroke: {self.mu} may be too small; make the strokes longer"
            )

    def _check_number(self) -> None:
        """Compare the number with the plain answer, the directions and what is plausible."""
        fit = self.fit
        friction = self.friction
        coarse = fit.uncertainty.contribution_of(RESOLUTION) / friction
        if coarse > _MATTERS:
            self.warn(
                f"the resolution of the cells makes {self.mu} uncertain by {100.0 * coarse:.0f} %;"
                " use a finer converter"
            )
        least = LEAST_SCATTER * friction / math.sqrt(self.points.strokes)
        if not self.log.shows_steps and self.average.scatter < least:
            (self.warn if len(self.log.way) >= LOG_ROWS else self.note)(
                "repeated readings are all alike and do not show how finely the cells read: a unit"
                " of the last decimal is assumed; use a finer converter"
            )
        if self.points.strokes < FEW:
            self.warn(
                f"{counted(self.points.strokes, 'stroke')} cannot show how strokes scatter:"
                f" {100.0 * FEW_SHARE:.0f} % of {self.mu} is assumed; repeat the measurement"
            )
        if abs(fit.from_plain) > _PLAIN_AWAY:
            self.warn(
                f"{self.mu} differs by {100.0 * fit.from_plain:+.0f} % from the plain answer,"
                f" {fit.plain.friction:.3g}; see which rows are used (--plot)"
            )
        slack = 2.0 * fit.uncertainty.standard_error
        alone = [direction.friction for direction in fit.by_direction.values()]
        if len(alone) == 2 and not min(alone) - slack <= friction <= max(alone) + slack:
            self.warn(
                f"{self.mu} lies outside what each direction gives alone,"
                f" {alone[0]:.3g} and {alone[1]:.3g}: the effects fitted for the rig cause this;"
                " state the cells' zeros"
            )
        self.warnings += disagreement(fit.files)
