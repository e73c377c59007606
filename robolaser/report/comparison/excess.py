"""How far costs are above the best known, as people read them."""

import math

from robolaser.report.digits import plain, times

BEST = "best"
"""Of a run that found what is best known."""
NOTHING = "nothing found"
"""Of a run without a finite cost."""
SAME = 1e-6
"""Excess that counts as none: of an RMS as a share of the best known, of a cost in units of its scale."""
MANIFOLD = 2.0
"""Relative excess from which it is said how many times the best something is."""
LARGE = 1e7
"""Cost from which powers of ten are read more easily than digits."""
WHOLE = 0.1
"""Share from which per cents are whole."""


def rms_excess(tolerance: float) -> str:
    """RMS over the best known, of a cost that is so much of the lowest one more."""
    if not math.isfinite(tolerance):
        return "" if math.isnan(tolerance) else NOTHING
    excess = math.sqrt(1.0 + max(tolerance, 0.0)) - 1.0
    if excess < SAME:
        return BEST
    return f"{times(1.0 + excess)} times" if excess >= MANIFOLD else f"+{_percent(excess)}"


def cost_excess(tolerance: float, scale: float, unit: str) -> str:
    """Cost over the lowest known, where that is next to nothing."""
    if not math.isfinite(tolerance * scale):
        return "" if math.isnan(tolerance * scale) else NOTHING
    if tolerance < SAME:
        return BEST
    cost = float(f"{tolerance * scale:.2g}")
    return f"+{cost:,.0f} {unit}".rstrip() if 10 <= cost < LARGE else f"+{plain(cost, unit, 2)}"


def rms_target(tolerance: float) -> str:
    """How far the RMS may be above the best known at a target."""
    excess = math.sqrt(1.0 + tolerance) - 1.0
    return f"{times(1.0 + excess)} times" if excess >= MANIFOLD else _percent(excess)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= WHOLE else f"{plain(100 * share, '', 2)} %"


def number(value: float) -> str:
    """A tolerance: few digits, and a bare power of ten where it is one."""
    return f"{value:,.0f}" if value >= 1.0 else plain(value, "", 2).removeprefix("1 × ")
