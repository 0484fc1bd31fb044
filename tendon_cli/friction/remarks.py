"""Checks of the rig, and what may be wrong with the number: what was seen, what it does, what helps."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from tendon_cli.friction.budget import FEW, FEW_SHARE, RESOLUTION, FrictionUncertainty
from tendon_cli.friction.effects import DELAY, ENTRY, FORCE, OFFSETS
from tendon_cli.friction.estimate import Estimated, Log
from tendon_cli.friction.reading.header import force_factor
from tendon_cli.friction.reading.readings import Floats
from tendon_cli.friction.result import Check, DirectionFit, Plain
from tendon_cli.friction.rows import NOT_POSITIVE, SATURATED, SPIKE
from tendon_cli.units import counted

_SHOWN, _OPEN = 0.5, 0.05
"""Probability from which an effect is found, and under which it is not there."""
_MATTERS = 0.02
"""Share of μ that is worth a word."""
_WORTH_A_NOTE = 0.005
_BAD_ROWS, _ZERO_ROWS = 0.10, 0.15
"""Shares of saturated rows or spikes, and of rows at or below zero: beyond, what is left is chosen by the fault."""
_GAIN_NOTE, _GAIN_WARNING, _PLAIN_AWAY, _LATE = 0.05, 0.20, 0.25, 0.03
_APART = 0.05
"""Difference of the forces of the two directions, as a share, from which a zero error does not act on both alike."""
_DRIFTS, _DRIFT_STROKES, _BY_CHANCE = 0.02, 6, 0.003
"""A drift is 2 % along the file and comes by chance in three of a thousand logs; fewer than six strokes show none."""
_CLIMBS, _NEVER_RESTS = 0.02, 0.10
"""Of the way from limit to limit, over a whole stroke: what climbs by more has not settled, or has no limit at all."""
_FEW_ROWS, _SOME_ROWS = 0.10, 0.25
"""Shares of rows on a limit: under a tenth do not answer for the others; under a quarter may be the turn of a crank."""


@dataclass(eq=False)
class Remarks:
    """A fit as it is looked at, and what is remarked."""

    log: Log
    estimate: Estimated
    uncertainty: FrictionUncertainty
    directions: dict[str, DirectionFit]
    plain: Plain
    codes: np.ndarray
    unit: str | None
    time_unit: str | None
    zero_given: bool
    bend_given: bool
    checks: list[Check] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.friction = self.estimate.average.friction
        self.name = "μ" if self.bend_given else "μφ"
        for look in (self._effects, self._drift, self._zeros, self._gains, self._rows, self._number):
            look()

    def _effects(self) -> None:
        """The checks of what can be fitted, and what those that put the number in doubt mean."""
        force, time = self.unit or "unit of the file", self.time_unit or "unit of the file's time"
        duration = self.estimate.points.duration
        for name, effect, part, unit in (
            ("offset_motor", OFFSETS, 0, force), ("offset_load", OFFSETS, 1, force), ("delay", DELAY, 0, time),
            ("force_dependence", FORCE, 0, "1"), ("entry", ENTRY, 0, "1"),
        ):  # fmt: skip
            check = self._check(name, effect, part, unit)
            if effect != ENTRY or check.found is not None:
                self.checks.append(check)
            if not check.found or check.value is None:
                continue
            if effect == DELAY and abs(check.value) > _LATE * duration:
                self.warnings.append(
                    f"delay: the {'load' if check.value > 0.0 else 'motor'}'s cell is {abs(check.value):.3g}"
                    f" {unit} late,"
                    f" {100.0 * abs(check.value) / duration:.0f} % of a stroke; {self.name} is corrected for it;"
                    " log both"
                    " cells by"
                    " one clock and filter"
                )
            if effect == FORCE:
                self.warnings.append(
                    f"{self.name} goes with the force to the power {check.value:.2g}: the number holds at the mean"
                    " force;"
                    " measure at the force that you use"
                )
            if effect == ENTRY:
                self.warnings.append(
                    f"friction outside of the bend takes {check.value:.3g} ± {check.standard_error:.1g} of the log"
                    " ratio:"
                    f" it is not in {self.name}; look for what rubs at the ends of the sheath"
                )

    def _check(self, name: str, effect: str, part: int, unit: str) -> Check:
        """One effect: from the likeliest model that has it; nothing if the readings cannot tell."""
        average, delay = self.estimate.average, self.estimate.delay if effect == DELAY else 0.0
        have = [(w, model) for w, model in zip(average.weights, average.models, strict=True) if effect in model.effects]
        if not have:
            return Check(name, delay or None, 0.0 if delay else None, unit, True if delay else None, None)
        model = max(have, key=lambda each: each[0])[1]
        value, error = model.value(effect, part)
        scale = model.friction if effect == FORCE else 1.0
        share = average.share(effect)
        found = bool(delay) or share > _SHOWN
        moves = average.models[0].friction / model.friction - 1.0
        unsure = abs(moves) + 2.0 * math.sqrt(max(float(model.covariance[0, 0]), 0.0)) / model.friction
        if not found and share > _OPEN and unsure > _MATTERS:
            return Check(name, None, None, unit, None, None)
        return Check(name, (value + delay) / scale, error / abs(scale), unit, found, moves)

    def _drift(self) -> None:
        """Whether strokes change along the file: never fitted, only tested."""
        from scipy.special import stdtr

        points, model = self.estimate.points, self.estimate.average.best
        if points.strokes < _DRIFT_STROKES:
            self.checks.append(Check("drift", None, None, "1", None, None))
            return
        count = np.bincount(points.stroke)
        columns = (model.residual, points.way * points.bend, points.place)
        left, turn, place = (np.bincount(points.stroke, column) / count for column in columns)
        design = np.stack(
            [turn * place * self.friction, turn, place, np.ones(len(left))][: 4 if points.both_ways else 2], 1
        )
        inverse = np.linalg.pinv(design.T @ design)
        values = inverse @ design.T @ left
        free = max(len(left) - design.shape[1], 1)
        error = np.sqrt(np.maximum(np.diag(inverse) * np.sum((left - design @ values) ** 2) / free, 1e-300))
        chance = 2.0 * stdtr(free, -np.abs(values) / error)
        drifts = (chance < _BY_CHANCE) & (np.abs(values) > _DRIFTS)
        what = {0: self.name, 2: "the gain of the cells"}
        for at in (at for at in what if at < len(values) and drifts[at]):
            self.warnings.append(
                f"drift: {what[at]} changes by {100.0 * values[at]:+.1f} % along the file, {self.name} is a mean;"
                " warm up"
                " the cells,"
                " run the tendon in, and measure again"
            )
        found = any(drifts[at] for at in what if at < len(values))
        self.checks.append(Check("drift", float(values[0]), float(error[0]), "1", found, 0.0))

    def _zeros(self) -> None:
        """What a zero error would do if the readings do not show it."""
        average, points = self.estimate.average, self.estimate.points
        shown = any(OFFSETS in model.effects for model in average.models)
        if shown or self.zero_given or not points.both_ways:
            return
        # Without a unit, 1 % of the force stands for 1 N.
        newton = 1.0 / (force_factor(self.unit) or 1.0) if self.unit else 0.01 * float(np.mean(points.load))
        moved = max(abs(slope) * newton / self.friction for slope in average.models[0].zero)
        amount = "1 N" if self.unit else "1 % of the force"
        text = f"{amount} of zero error in a cell would move {self.name} by {100.0 * moved:.1f} %"
        up, down = (float(np.mean(np.log(points.load[points.way == way]))) for way in (1, -1))
        if abs(up - down) > _APART and moved > _MATTERS:
            self.warnings.append(
                f"the forces of the two directions lie {100.0 * (abs(up - down)):.0f} % apart: {text}; state the"
                " cells' zeros"
                " (--zero-motor, --zero-load)"
            )
        elif moved > _WORTH_A_NOTE:
            self.notes.append(f"{text}, and these forces do not show it")

    def _gains(self) -> None:
        """The cells against each other."""
        average, points = self.estimate.average, self.estimate.points
        if not points.both_ways:
            share = 0.01 / float(points.bend.max()) / self.friction
            self.checks.append(Check("gain", None, None, "1", None, None))
            several = len(np.unique(self.log.way)) == 2
            what = "only one direction reaches a limit" if several else "one direction only"
            (self.warnings if several else self.notes).append(
                f"{what}: gain and zero errors of the cells hide in it; 1 % between the gains would change"
                f" {self.name} by"
                f" {100.0 * share:.1f} %"
            )
            return
        gain, error = math.exp(average.log_gain), math.sqrt(max(float(average.best.covariance[1, 1]), 0.0))
        found = points.strokes > 2 and abs(average.log_gain) > max(3.0 * error, 1e-3)
        self.checks.append(Check("gain", gain, error, "1", found, 0.0))
        more = max(gain, 1.0 / gain) - 1.0
        text = f"one cell reads {100.0 * more:.0f} % more than the other at the same force"
        if more > _GAIN_WARNING:
            self.warnings.append(
                f"{text}: one of them is not calibrated, or not of this tendon; load both with one weight"
            )
        elif more > _GAIN_NOTE:
            self.notes.append(f"{text}; it cancels between the directions, but calibrate them")

    def _rows(self) -> None:
        """Rows set aside in numbers that choose among the rest, and rows that have not settled."""
        for code, most, what, cure in (
            (SATURATED, _BAD_ROWS, "are saturated: what slips there is not known", "use a larger range"),
            (SPIKE, _BAD_ROWS, "are spikes: what is left between them may be wrong, too", "check the wiring"),
            (NOT_POSITIVE, _ZERO_ROWS, "are at or below zero: the tendon is slack or a zero is off", "load it more"),
        ):
            share = float(np.mean(self.codes == code))
            if share > most:
                self.warnings.append(f"{100.0 * share:.0f} % of the rows {what}; {cure}")
        climb = climbing(self.log, self.estimate)
        if climb > _CLIMBS:
            self.warnings.append(
                f"the force ratio still climbs on the limit, by {100.0 * climb:.0f} % of its way in a stroke:"
                f" {self.name}"
                " may be too"
                " small; make the strokes longer"
            )

    def _number(self) -> None:
        """The number itself against the plain answer, the directions and what is plausible."""
        friction, name, strokes = self.friction, self.name, self.estimate.points.strokes
        coarse = self.uncertainty.of(RESOLUTION) / friction
        if coarse > _MATTERS:
            self.warnings.append(
                f"the steps of the cells leave {name} open by {100.0 * coarse:.0f} %; use a finer converter"
            )
        if strokes < FEW:
            self.warnings.append(
                f"{counted(strokes, 'stroke')} cannot show how strokes scatter: {100.0 * FEW_SHARE:.0f} % of {name} is"
                " assumed; repeat"
                " the measurement"
            )
        away = friction / self.plain.friction - 1.0 if self.plain.friction else 0.0
        if abs(away) > _PLAIN_AWAY:
            self.warnings.append(
                f"{name} is {100.0 * away:+.0f} % from the plain answer, {self.plain.friction:.3g}; look which"
                " rows are used"
                " (--plot)"
            )
        own, slack = [part.friction for part in self.directions.values()], 2.0 * self.uncertainty.standard_error
        if len(own) == 2 and not min(own) - slack <= friction <= max(own) + slack:
            self.warnings.append(
                f"{name} is outside of both directions' own, {own[0]:.3g} and {own[1]:.3g}: what was fitted of the"
                " rig makes"
                " it; state the cells' zeros"
            )
        widest = float(self.estimate.points.bend.max())
        if self.bend_given and widest > 4.0 * math.pi:
            self.warnings.append(f"the bend angle is {widest / 2.0 / math.pi:.1f} turns; are its units right?")
        if self.bend_given and friction > 1.0:
            self.warnings.append("a coefficient above 1 is not plausible for a tendon; check units and bend angle")
        if self.uncertainty.interval_95[0] <= 0.0:
            self.warnings.append("the 95 % interval reaches 0: the readings do not show that there is friction")


def climbing(log: Log, estimate: Estimated) -> float:
    """How far the ratio surely climbs on the limit, the motor's cell alone, over a stroke: 0 in slip, 1 in stick."""
    from scipy.special import stdtrit

    points = estimate.points
    count = np.bincount(points.stroke)
    full = count >= 4
    if log.settled or np.count_nonzero(full) < 2:
        return 0.0
    every, kept = np.bincount(log.stroke), np.bincount(log.stroke[estimate.used], minlength=int(log.stroke[-1]) + 1)
    stretch = (every / np.maximum(kept, 1))[kept > 0][full] / 0.75
    at = np.arange(len(points.stroke)) - np.searchsorted(points.stroke, points.stroke)
    ends = [(at >= (0.75 * count)[points.stroke]), (at < (0.25 * count)[points.stroke])]

    def change(column: Floats) -> Floats:
        late, early = (np.bincount(points.stroke, column * end) / np.bincount(points.stroke, end) for end in ends)
        return np.asarray((late - early)[full])

    height = 2.0 * max(abs(estimate.average.friction) * float(np.mean(points.bend)), 1e-12)
    climbs = change(points.way * points.log_ratio) * stretch / height
    steps = [float(np.mean(np.abs(change(np.log(cell))))) for cell in (points.motor, points.load)]
    alone = 1.0 - min(steps) / max(steps) if max(steps) > 0.0 else 0.0
    error = float(np.std(climbs, ddof=1)) / math.sqrt(len(climbs)) * float(stdtrit(len(climbs) - 1, 0.975))
    return max(0.0, float(np.mean(climbs)) - error) * max(0.0, 2.0 * alone - 1.0)


def never_rests(log: Log, estimate: Estimated) -> str | None:
    """Why there is no limit at all; None if there is one."""
    if log.settled:
        return None
    share, climb = float(np.mean(estimate.used)), climbing(log, estimate)
    if climb > _NEVER_RESTS or (climb > _CLIMBS and share < _SOME_ROWS):
        return "no stroke slips: the force ratio still moves where each of them ends"
    if share < _FEW_ROWS:
        return f"only {estimate.used.sum()} of {len(log.way)} rows slip, which is too few to answer for the others"
    return None
