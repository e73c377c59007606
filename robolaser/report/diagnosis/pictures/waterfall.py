"""From the nominal gap down to the noise floor, step by step."""

from dataclasses import dataclass
from typing import final

from matplotlib.figure import Figure

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.canvas import FITTED, HELD_OUT, INK, MUTED, NOISE, Picture, picture, plain_log
from robolaser.report.digits import millimetres

MOST = 7
"""Effects with a step of their own."""
WIDE = 6.0
"""Ratio of the largest gap to the smallest, from which on steps are drawn on a logarithmic scale."""
LEAST = 1e-6
"""Gaps below this are drawn as this [mm]."""


@final
@dataclass(frozen=True)
class Step:
    """A bar: from one gap to another [mm], or from nothing."""

    label: str
    colour: str
    before: float | None
    after: float


def steps(diagnosis: Diagnosis) -> list[Step]:
    """The bars, from the top."""
    gap = diagnosis.gap
    nominal, calibrated, after, floor = (
        max(LEAST, 1e3 * length) for length in (gap.nominal_m, gap.calibrated_m, gap.after_m, gap.noise_floor_m)
    )
    found = [Step("the sim as given", MUTED, None, nominal), Step("parameters fitted", MUTED, nominal, calibrated)]
    for finding in diagnosis.findings[:MOST]:
        label = f"{finding.candidate_effect.effect.name}\n{finding.candidate_effect.where}"
        found.append(Step(label, FITTED, max(LEAST, 1e3 * finding.gap_before_m), max(LEAST, 1e3 * finding.gap_after_m)))
    more = len(diagnosis.findings) - MOST
    if more > 0:
        found.append(Step(f"and {more} more", FITTED, found[-1].after, after))
    return [*found, Step("left on new poses", HELD_OUT, None, after), Step("noise alone", NOISE, None, floor)]


def waterfall(diagnosis: Diagnosis) -> Picture:
    """Each step's bar hangs between the gap before it and the gap after it."""
    bars = steps(diagnosis)
    everything = [value for bar in bars for value in (bar.before, bar.after) if value is not None]
    low, high = min(everything), max(everything)
    logarithmic = high > WIDE * low
    start = low / 2 if logarithmic else 0.0
    end = 1e3 * diagnosis.gap.after_ci95_m[0], 1e3 * diagnosis.gap.after_ci95_m[1]

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        if logarithmic:
            ax.set_xscale("log")
        for i, bar in enumerate(bars):
            left, right = sorted((start if bar.before is None else bar.before, bar.after))
            ax.barh(
                i, right - left, left=left, height=0.62, color=bar.colour, alpha=0.55 if bar.before is None else 1.0
            )
            if bar.before is not None:
                ax.plot([bar.before] * 2, [i - 1, i], color=MUTED, linewidth=0.7, linestyle=(0, (2, 2)), zorder=0)
            at = max(right, end[1]) if bar.colour == HELD_OUT else right
            ax.annotate(
                millimetres(bar.after / 1e3), (at, i), (5, 0), textcoords="offset points", va="center", color=INK
            )
        left_over = next(i for i, bar in enumerate(bars) if bar.colour == HELD_OUT)
        ax.plot([max(end[0], start), end[1]], [left_over] * 2, color=INK, linewidth=1.2, zorder=3)
        ax.axvline(bars[-1].after, color=NOISE, linestyle=(0, (4, 3)), zorder=0)
        ax.set_yticks(range(len(bars)), [bar.label for bar in bars], color=INK)
        ax.set_ylim(len(bars) - 0.45, -0.55)
        ax.set_xlim(start, high * (1.0 + 0.9 * (high / start) ** 0.12 if logarithmic else 1.22))
        ax.grid(visible=False, axis="y")
        ax.spines["left"].set_visible(False)
        ax.set_xlabel("error on new poses, RMS [mm]")
        if logarithmic:
            plain_log(ax.xaxis)

    scale = " The scale is logarithmic." if logarithmic else ""
    return picture(
        "How far the gap shrinks",
        "From the sim as given, through the ordinary parameters fitted and each effect added, to what is left on poses"
        " that were not fitted; the number is the gap after the step. Black line: its 95 % interval. Dashed: what noise"
        f" alone would give.{scale}",
        f"The gap falls from {millimetres(diagnosis.gap.nominal_m)} to {millimetres(diagnosis.gap.after_m)}; noise"
        f" alone gives {millimetres(diagnosis.gap.noise_floor_m)}.",
        paint,
    )
