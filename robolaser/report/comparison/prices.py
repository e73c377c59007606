"""Prices and qualities of runs as people read them."""

import math

from robolaser.report.digits import plain, times

NEVER = "never"
"""Of a price that no run could tell."""
BEST = "best"
"""Of a run that found what is best known."""
SAME = 1e-6
"""Excess that nobody would call one: of an RMS as a share of the best known, of a cost in units of its scale."""
TEN = 9.95
"""What is written as 10 if there is to be one digit after the point."""
MANIFOLD = 2.0
"""Relative excess from which it is said how many times the best something is."""
PLAINLY = 0.1
"""Share from which per cents are whole."""
MINUTE, HOUR = 60.0, 3600.0
"""From one and a half of each on, durations are written in it [s]."""


def count(evaluations: float) -> str:
    """Evaluations as a whole number of no more than three digits that matter."""
    if not math.isfinite(evaluations):
        return "" if math.isnan(evaluations) else NEVER
    if evaluations < 1000:
        return f"{evaluations:.0f}"
    last = math.floor(math.log10(evaluations)) - 2
    return f"{round(evaluations, -last):,.0f}"


def duration(seconds: float) -> str:
    """Wall time, in the unit a person would use."""
    if not math.isfinite(seconds):
        return "" if math.isnan(seconds) else NEVER
    if seconds >= 1.5 * HOUR:
        return f"{seconds / HOUR:.3g} h"
    if seconds >= 1.5 * MINUTE:
        return f"{seconds / MINUTE:.3g} min"
    if seconds < 1e-3:
        return f"{float(f'{seconds * 1e6:.2g}'):g} µs"
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{seconds * 1e3:.3g} ms"


def many(ratio: float) -> str:
    """How many times the first's."""
    return f"{manifold(ratio)} ×"


def manifold(ratio: float) -> str:
    """How many times, with two digits that matter."""
    if ratio < TEN:
        return f"{ratio:.1f}"
    return f"{round(ratio, 1 - math.floor(math.log10(ratio))):,.0f}"


def rms_excess(tolerance: float) -> str:
    """RMS over the best known, of a cost that is so much of the lowest one more."""
    if not math.isfinite(tolerance):
        return "" if math.isnan(tolerance) else "nothing found"
    excess = math.sqrt(1.0 + max(tolerance, 0.0)) - 1.0
    if excess < SAME:
        return BEST
    return f"{times(1.0 + excess)} times" if excess >= MANIFOLD else f"+{_percent(excess)}"


def cost_excess(tolerance: float, scale: float, unit: str) -> str:
    """Cost over the lowest known, where that is next to nothing."""
    if not math.isfinite(tolerance * scale):
        return "" if math.isnan(tolerance * scale) else "nothing found"
    return BEST if tolerance < SAME else f"+{plain(tolerance * scale, unit, 2)}"


def rms_target(tolerance: float) -> str:
    """How far the RMS may be above the best known at a target."""
    excess = math.sqrt(1.0 + tolerance) - 1.0
    return f"{times(1.0 + excess)} times" if excess >= MANIFOLD else _percent(excess)


def rate(share: float) -> str:
    """A share of runs in whole per cent."""
    return "" if math.isnan(share) else f"{100 * share:.0f} %"


def interval(low: float, high: float) -> str:
    """From one share to another."""
    return "" if math.isnan(low + high) else f"{100 * low:.0f} to {100 * high:.0f} %"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= PLAINLY else f"{plain(100 * share, '', 2)} %"


def number(value: float) -> str:
    """A tolerance: few digits, and a bare power of ten where it is one."""
    return f"{value:,.0f}" if value >= 1.0 else plain(value, "", 2).removeprefix("1 × ")
