"""Checks of the rig, and what may be wrong with the number: what was seen, what it does, what helps."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.friction.budget import FEW, FEW_SHARE, RESOLUTION
from tendon_cli.friction.effects import DELAY, ENTRY, FORCE, OFFSETS
from tendon_cli.friction.estimate import FrictionEstimate, climbing
from tendon_cli.friction.fit_result import Check, Fit
from tendon_cli.friction.reading.header import force_factor
from tendon_cli.friction.strokes import disagreement
from tendon_cli.friction.usable_rows import NOT_POSITIVE, SATURATED, SPIKE, Log
from tendon_cli.units import counted

_SHOWN, _OPEN = 0.5, 0.05
"""Probability from which an effect is shown, and under which it is not there."""
_MATTERS, _NOTED = 0.02, 0.005
"""Shares of μ from which something is a warning, or a note."""
_MOST = {
    SATURATED: (0.10, "are saturated: what slips there is not known; use a larger range"),
    SPIKE: (0.10, "are spikes: what is left between them may be wrong, too; check the wiring"),
    NOT_POSITIVE: (0.15, "are at or below zero: the tendon is slack or a zero is off; load it"),
}
"""Shares of rows beyond which what is left is chosen by the fault, and the words for it."""
_GAIN_NOTE, _GAIN_WARNING, _PLAIN_AWAY, _LATE = 0.05, 0.20, 0.25, 0.03
_APART = 0.05
"""Difference of the forces of the two directions, as a share, from which a zero error does not act on both alike."""
_DRIFT_STROKES, _BY_CHANCE = 6, 0.003
"""A drift comes by chance in three of a thousand logs; fewer than six strokes show none."""
_CLIMBS, _FEW_USED = 0.02, 0.30
"""Of the way from limit to limit over a stroke, from which rows have not settled; share of rows on a limit, of which
strokes that slip have more."""


class Remarks:
    """What is remarked of a fit, each in one line: what was seen, what it does to μ, what to do at the bench."""

    def __init__(
        self, fit: Fit, log: Log, result: FrictionEstimate, time_unit: str | None, zero_given: bool
    ) -> None:
        self.fit, self.log, self.result, self.points = fit, log, result, result.points
        self.time_unit, self.zero_given, self.friction = time_unit, zero_given, result.friction
        self.mu = "μφ" if fit.bend_angle is None else "μ"
        self.checks: list[Check] = []
        self.notes, self.warnings = [*fit.notes], [*fit.warnings]
        for look in (
            self._effects,
            self._drift,
            self._zeros,
            self._gains,
            self._rows,
            self._number,
        ):
            look()

    def _effects(self) -> None:
        """The checks of what can be fitted, and what those mean for the number."""
        for effect in (*OFFSETS, DELAY, FORCE, ENTRY):
            check = self._check(effect)
            value = check.value or 0.0
            late = abs(value) / self.log.duration
            if effect != ENTRY or check.found is not None:
                self.checks.append(check)
            if effect == DELAY and check.found and late > _LATE:
                self.warnings.append(
                    f"delay: the {'load' if value > 0.0 else 'motor'}'s cell is {abs(value):.3g} {check.unit} late,"
                    f" {100.0 * late:.0f} % of a stroke; {self.mu} is corrected for it; log both cells by one clock and"
                    " filter"
                )
            if effect == FORCE and check.found:
                self.warnings.append(
                    f"{self.mu} goes with the force to the power {value:.2g}: the number holds at the mean force;"
                    " measure at the force that you use"
                )
            if effect == ENTRY and check.found:
                self.warnings.append(
                    f"friction outside of the bend takes {value:.3g} ± {check.standard_error:.1g} of the log ratio: it"
                    f" is not in {self.mu}; look for what rubs at the ends of the sheath"
                )

    def _check(self, effect: str) -> Check:
        """One effect, by the likeliest model that has it; nothing if the readings cannot show it."""
        average, delay = self.result.average, self.result.delay if effect == DELAY else 0.0
        unit = "1"
        if effect in OFFSETS:
            unit = self.fit.unit or "unit of the file"
        elif effect == DELAY:
            unit = self.time_unit or "unit of the file's time"
        having = [at for at, model in enumerate(average.models) if effect in model.effects]
        if not having:
            return Check(
                effect, delay or None, 0.0 if delay else None, unit, True if delay else None, None
            )
        model = average.models[max(having, key=average.weights.__getitem__)]
        share = float(np.sum(average.weights[having]))
        value, error = model.value(effect)
        scale = model.friction if effect == FORCE else 1.0
        moves = average.models[0].friction / model.friction - 1.0
        is_shown = bool(delay) or share > _SHOWN
        if (
            not is_shown
            and share > _OPEN
            and abs(moves) + 2.0 * model.error / model.friction > _MATTERS
        ):
            return Check(effect, None, None, unit, None, None)
        return Check(effect, (value + delay) / scale, error / abs(scale), unit, is_shown, moves)

    def _drift(self) -> None:
        """Whether strokes change along the file: never fitted, only tested."""
        from scipy.special import stdtr

        points = self.points
        if points.strokes < _DRIFT_STROKES:
            self.checks.append(Check("drift", None, None, "1", None, None))
            return
        count = np.bincount(points.stroke)
        columns = (self.result.average.best.residual, points.way * points.bend, points.place)
        left, turn, place = (np.bincount(points.stroke, column) / count for column in columns)
        every = [
            self.friction * turn * place,
            turn,
            place,
            np.ones(len(left)),
        ]  # of μ, and of the gain
        design = np.stack(every if points.both_ways else every[:2], axis=1)
        inverse = np.linalg.pinv(design.T @ design)
        values = inverse @ design.T @ left
        free = max(len(left) - design.shape[1], 1)
        error = np.sqrt(
            np.maximum(np.diag(inverse) * np.sum((left - design @ values) ** 2) / free, 1e-300)
        )
        drifts = (2.0 * stdtr(free, -np.abs(values) / error) < _BY_CHANCE) & (
            np.abs(values) > _MATTERS
        )
        self.checks.append(
            Check("drift", float(values[0]), float(error[0]), "1", bool(drifts[::2].any()), 0.0)
        )
        speed, changes = (
            self.fit.speed,
            {self.mu: 0} | ({"the gain of the cells": 2} if points.both_ways else {}),
        )
        for what, at in changes.items():
            if drifts[at] and at == 0 and speed and abs(speed.power) > 3.0 * speed.standard_error:
                self.warnings.append(
                    f"{self.mu} goes with the speed to the power {speed.power:.2g}: the number is a mean over the"
                    " speeds of the file; measure at the speed that you use"
                )
            elif drifts[at]:
                self.warnings.append(
                    f"drift: {what} changes by {100.0 * values[at]:+.1f} % along the file, {self.mu} is a mean; warm up"
                    " the cells, run the tendon in, and measure again"
                )

    def _zeros(self) -> None:
        """What a zero error would do if the readings do not show it."""
        models, points, unit = self.result.average.models, self.points, self.fit.unit
        if (
            any(OFFSETS[0] in model.effects for model in models)
            or self.zero_given
            or not points.both_ways
        ):
            return
        # Without a unit, 1 % of the force stands for 1 N.
        newton = 1.0 / (force_factor(unit) or 1.0) if unit else 0.01 * float(np.mean(points.load))
        moved = max(abs(slope) * newton / self.friction for slope in models[0].zero)
        amount = "1 N" if unit else "1 % of the force"
        would = f"{amount} of zero error in a cell would move {self.mu} by {100.0 * moved:.1f} %"
        up, down = (float(np.mean(np.log(points.load[points.way == way]))) for way in (1, -1))
        if abs(up - down) > _APART and moved > _MATTERS:
            apart = f"the forces of the two directions lie {100.0 * abs(up - down):.0f} % apart"
            self.warnings.append(
                f"{apart}: {would}; state the cells' zeros (--zero-motor, --zero-load)"
            )
        elif moved > _NOTED:
            self.notes.append(f"{would}, and these forces do not show it")

    def _gains(self) -> None:
        """The cells against each other."""
        average, points = self.result.average, self.points
        if not points.both_ways:
            several = len(np.unique(self.log.way)) == 2
            what = "only one direction reaches a limit" if several else "one direction only"
            (self.warnings if several else self.notes).append(
                f"{what}: gain and zero errors of the cells hide in it; 1 % between the gains would change {self.mu} by"
                f" {1.0 / float(points.bend.max()) / self.friction:.1f} %"
            )
            self.checks.append(Check("gain", None, None, "1", None, None))
            return
        gain, error = (
            math.exp(average.log_gain),
            math.sqrt(max(float(average.best.covariance[1, 1]), 0.0)),
        )
        differs = points.strokes > 2 and abs(average.log_gain) > max(3.0 * error, 1e-3)
        self.checks.append(Check("gain", gain, error, "1", differs, 0.0))
        more = max(gain, 1.0 / gain) - 1.0
        reads = f"one cell reads {100.0 * more:.0f} % more than the other at the same force"
        if more > _GAIN_WARNING:
            wrong = "one of them is not calibrated, or not of this tendon"
            self.warnings.append(f"{reads}: {wrong}; load both with one weight")
        elif more > _GAIN_NOTE:
            self.notes.append(f"{reads}; it cancels between the directions, but calibrate them")

    def _rows(self) -> None:
        """Rows set aside in numbers that choose among the rest, and rows that have not settled."""
        for code, (most, text) in _MOST.items():
            if (share := float(np.mean(self.fit.rows["code"] == code))) > most:
                self.warnings.append(f"{100.0 * share:.0f} % of the rows {text}")
        share, climb = float(np.mean(self.result.used)), climbing(self.log, self.result)
        if share < _FEW_USED:
            self.warnings.append(
                f"only {100.0 * share:.0f} % of the rows lie on a limit, and {self.mu} may be that of peaks: a cell is"
                " late or the strokes are short; log both cells by one clock, make the strokes longer"
            )
        if climb > _CLIMBS:
            self.warnings.append(
                f"the force ratio still climbs on the limit, by {100.0 * climb:.0f} % of its way in a stroke: {self.mu}"
                " may be too small; make the strokes longer"
            )

    def _number(self) -> None:
        """The number itself against the plain answer, the directions and what is plausible."""
        fit, friction, mu, warn = self.fit, self.friction, self.mu, self.warnings.append
        coarse, alone = (
            fit.uncertainty.of(RESOLUTION) / friction,
            [part.friction for part in fit.by_direction.values()],
        )
        if coarse > _MATTERS:
            warn(
                f"the steps of the cells leave {mu} open by {100.0 * coarse:.0f} %; use a finer converter"
            )
        if self.points.strokes < FEW:
            strokes, assumed = (
                counted(self.points.strokes, "stroke"),
                f"{100.0 * FEW_SHARE:.0f} % of {mu} is assumed",
            )
            warn(f"{strokes} cannot show how strokes scatter: {assumed}; repeat the measurement")
        if abs(fit.from_plain) > _PLAIN_AWAY:
            away = (
                f"{100.0 * fit.from_plain:+.0f} % from the plain answer, {fit.plain.friction:.3g}"
            )
            warn(f"{mu} is {away}; look which rows are used (--plot)")
        slack = 2.0 * fit.uncertainty.standard_error
        if len(alone) == 2 and not min(alone) - slack <= friction <= max(alone) + slack:
            warn(
                f"{mu} is outside of what each direction gives alone, {alone[0]:.3g} and {alone[1]:.3g}: what was"
                " fitted of the rig makes it; state the cells' zeros"
            )
        if fit.bend_angle is not None and friction > 1.0:
            warn("a coefficient above 1 is not plausible for a tendon; check units and bend angle")
        self.warnings += disagreement(fit.files)
