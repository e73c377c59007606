"""Numbers for people: familiar units, and no more digits than the error allows."""

import math
from collections.abc import Mapping

SIGNIFICANT = 3  # digits of an error alone: an RMS of a few hundred numbers is known to a few per cent

MINUTE, HOUR = 60.0, 3600.0  # durations above one and a half of each are written in it [s]
SURE = 1e-3  # probabilities are not distinguished below this, nor above its complement

NEGLIGIBLE = 1e-6  # standard deviation over value, below which it is omitted

HUMAN: Mapping[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "rad": ("°", 180 / math.pi),
    "m/px": ("µm/px", 1e6),
    "1/m²": ("1/mm²", 1e-6),
    "s": ("ms", 1e3),
    "rad/Nm": ("°/kNm", 180e3 / math.pi),
    "kg rad/Nm": ("kg °/kNm", 180e3 / math.pi),
}
"""Unit that people read, and its factor, by SI unit; other units are shown as they are."""


def human(value: float, unit: str) -> tuple[float, str]:
    """A number and its unit as people read them."""
    shown, factor = HUMAN.get(unit, (unit, 1.0))
    return value * factor, shown


def with_unit(number: str, unit: str) -> str:
    """Number and unit with a typographic space: none before a degree sign, except after an error or power."""
    return f"{number}{unit}" if unit == "°" and not {"±", "×"} & set(number) else f"{number} {unit}".rstrip()


def measured(value: float, std: float, unit: str) -> str:
    """A value in SI with two digits of its standard deviation; without it if there is none or a negligible one."""
    shown, label = human(value, unit)
    error, _ = human(std, unit)
    if not (math.isfinite(error) and error > 0):
        return with_unit(_plain(shown, 5), label)
    if error < NEGLIGIBLE * abs(shown):
        return with_unit(_plain(shown, 7), label)
    last = int(f"{error:.1e}".partition("e")[2]) - 1
    if -6 <= last <= 3:
        return with_unit(f"{_rounded(shown, last)} ± {_rounded(error, last)}", label)
    power = math.floor(math.log10(max(abs(shown), error)))
    scaled = (_rounded(number / 10.0**power, last - power) for number in (shown, error))
    return with_unit(f"({' ± '.join(scaled)}) × 10{_raised(power)}", label)


def plain(value: float, unit: str, digits: int = 4) -> str:
    """A value in SI that has no error, such as a bound."""
    shown, label = human(value, unit)
    return with_unit(_plain(shown, digits), label)


def millimetres(length_m: float | None) -> str:
    """An error as a length."""
    return "unknown" if length_m is None else f"{_plain(length_m * 1e3, SIGNIFICANT)} mm"


def millimetre_interval(low_m: float, high_m: float) -> str:
    """From one error to another, with the same decimals: "0.100 to 0.122 mm"."""
    high = high_m * 1e3
    last = math.floor(math.log10(high)) - SIGNIFICANT + 1 if high > 0 else 0
    if not -6 <= last <= 1:
        return f"{millimetres(low_m)} to {millimetres(high_m)}"
    return f"{_rounded(low_m * 1e3, last)} to {_rounded(high, last)} mm"


def percent(share: float) -> str:
    """A probability, never 0 % and never 100 %."""
    if share > 1 - SURE:
        return "> 99.9 %"
    return "< 0.1 %" if share < SURE else f"{100 * share:.3g} %"


def times(ratio: float) -> str:
    """A ratio, with one decimal below ten."""
    return f"{ratio:.0f}" if ratio >= 9.5 else f"{ratio:.1f}"


def duration(seconds: float) -> str:
    """Wall time, in the unit a person would use."""
    if seconds >= 1.5 * HOUR:
        return f"{seconds / HOUR:.3g} h"
    if seconds >= 1.5 * MINUTE:
        return f"{seconds / MINUTE:.3g} min"
    if seconds < 1e-3:
        return f"{float(f'{seconds * 1e6:.2g}'):g} µs"
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{seconds * 1e3:.3g} ms"


def rate(share: float) -> str:
    """A share of runs in whole per cent."""
    return f"{100 * share:.0f} %"


def _rounded(value: float, last: int) -> str:
    """Rounded to the digit 10^last."""
    return f"{round(value, -last) + 0.0:.{max(0, -last)}f}"


def _plain(value: float, digits: int) -> str:
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text
    if 1e4 <= abs(value) < 1e7:
        return f"{value:.0f}"
    mantissa, power = text.split("e")
    return f"{mantissa} × 10{_raised(int(power))}"


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
