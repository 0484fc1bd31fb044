"""One panel of a slack map: margin in colour, the line where it is zero, hatching where there is no equilibrium."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.figures.engine import Axes, Line2D, Patch, TickedStroke, TwoSlopeNorm, mpl, withStroke
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import DIVERGING, INK

Floats = npt.NDArray[np.float64]

BOUNDARY_WIDTH = 1.2
_HATCH = "////"
_FEWEST_FOR_LEVELS = 6
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
# Contours run with the higher values on their left; the ticks stand on the right, where a tendon goes slack.
_TICKS = TickedStroke(spacing=5.0, angle=-90.0, length=0.45, linewidth=0.6, foreground=INK)
_HALO = withStroke(linewidth=2.6, foreground="white")


@dataclass(frozen=True)
class ColourScale:
    """Symmetric about zero and round; wide enough for all but the far ends."""

    limit: float
    levels: tuple[float, ...]
    extend: str
    """Which ends of the colour bar stand for values beyond it."""

    @property
    def norm(self) -> TwoSlopeNorm:
        """From a margin to its colour."""
        return TwoSlopeNorm(0.0, -self.limit, self.limit)


def colour_scale(margins: list[Floats]) -> ColourScale:
    """One scale for all panels: the positive side is shown whole, a far longer negative side is cut off."""
    finite = np.concatenate([panel[np.isfinite(panel)] for panel in margins]) if margins else np.zeros(0)
    most, least = (float(finite.max()), float(finite.min())) if len(finite) else (1.0, -1.0)
    usual = float(np.quantile(np.abs(finite), 0.9)) if len(finite) else 1.0
    bound = max(most, -least)
    if bound > 1.5 * max(usual, most):
        bound = max(usual, most)
    limit = _round_up(bound or 1.0)
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    levels = mpl.ticker.MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]).tick_values(-limit, limit)
    inside = tuple(float(level) for level in levels if abs(level) <= limit * (1 + 1e-9))
    return ColourScale(limit, inside, extend[least < -limit, most > limit])


def draw_panel(axes: Axes, x: Scale, y: Scale, margin: Floats, colours: ColourScale, ticks: int) -> None:
    """Draw margins of shape (y, x), in the order of the scales' places, with at most so many ticks on x."""
    known = np.isfinite(margin)
    if not known.all():
        axes.patch.set(facecolor="#efefef", hatch=_HATCH, edgecolor="#8a8a8a", linewidth=0.0)
    shown = np.ma.masked_invalid(margin)
    axes.pcolormesh(x.edges, y.edges, shown, cmap=DIVERGING, norm=colours.norm, rasterized=True, gid="margin")
    if x.names or y.names:
        draw_steps(axes, x, y, margin)
    elif min(margin.shape) > 1:
        _draw_levels(axes, x, y, shown, colours)
    x.apply(axes, "x", ticks=ticks)
    y.apply(axes, "y")


def boundary_key() -> Line2D:
    """The sign of the boundary, for the key."""
    label = "margin = 0, ticks on the slack side"
    return Line2D(
        [], [], color=INK, linewidth=BOUNDARY_WIDTH, path_effects=[_TICKS, mpl.patheffects.Normal()], label=label
    )


def hatch_key(label: str = "no equilibrium at some elbow angle") -> Patch:
    """The sign of what has no equilibrium, for the key."""
    return Patch(facecolor="#efefef", hatch=_HATCH, edgecolor="#8a8a8a", linewidth=0.0, label=label)


def crosses_zero(margin: Floats) -> bool:
    """Whether some designs are slack and others are not."""
    return bool(np.nanmin(margin, initial=np.inf) < 0.0 <= np.nanmax(margin, initial=-np.inf))


def _draw_levels(axes: Axes, x: Scale, y: Scale, margin: Floats, colours: ColourScale) -> None:
    """Thin lines at the ticks of the colour bar, and the boundary, interpolated between designs."""
    least, most = float(margin.min()), float(margin.max())
    levels = [level for level in colours.levels if level != 0.0 and least < level < most]
    if levels and min(margin.shape) >= _FEWEST_FOR_LEVELS:
        axes.contour(x.places, y.places, margin, levels=levels, colors="#00000055", linewidths=0.35,
                     linestyles="solid")  # fmt: skip
    if least < 0.0 < most:
        effects = [_HALO, _TICKS, mpl.patheffects.Normal()]
        lines = axes.contour(x.places, y.places, margin, levels=[0.0], colors=INK, linewidths=BOUNDARY_WIDTH)
        lines.set(path_effects=effects, gid="boundary")


def draw_steps(axes: Axes, x: Scale, y: Scale, margin: Floats) -> None:
    """The boundary where one axis is of names: per name, a stroke where the margin changes its sign."""
    along_x = not x.names
    places, table = (x.places, margin) if along_x else (y.places, margin.T)
    for at, line in enumerate(table):
        for zero, rises in zero_crossings(places, line):
            across = (at - 0.5, at + 0.5)
            # Drawn so that the higher side is on the left, as contours are.
            up = across if rises != along_x else across[::-1]
            xy = ([zero, zero], up) if along_x else (up, [zero, zero])
            effects = [_HALO, _TICKS, mpl.patheffects.Normal()]
            axes.plot(
                *xy, color=INK, linewidth=BOUNDARY_WIDTH, path_effects=effects, solid_capstyle="butt", gid="boundary"
            )


def zero_crossings(places: Floats, values: Floats) -> list[tuple[float, bool]]:
    """Where values along an axis cross zero, linearly between two of them, and whether they rise there."""
    found = []
    for at in range(len(values) - 1):
        low, high = values[at], values[at + 1]
        if np.isfinite(low) and np.isfinite(high) and (low < 0.0) != (high < 0.0):
            share = low / (low - high)
            found.append((float(places[at] + share * (places[at + 1] - places[at])), bool(high > low)))
    return found


def _round_up(value: float) -> float:
    """The next of the round numbers times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in _ROUND if step * power >= value * (1 - 1e-9)))
