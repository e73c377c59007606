"""How far the gap shrinks: step by step, from the nominal model down to the noise."""

from dataclasses import dataclass
from typing import final

from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    INK,
    MUTED,
    NOISE,
    Channel,
    Chart,
    chart,
    colours,
    hover,
    layer,
    named_rows,
    quantity,
    records,
    rule,
)
from robolaser.report.digits import millimetres

MOST = 7
"""Effects with a step of their own."""
WIDE = 6.0
"""Ratio of the largest gap to the smallest, from which on the axis is logarithmic."""
LEAST = 1e-6
"""Gaps below this are drawn as this [mm]."""
ROOM = 0.15
"""Share of a logarithmic axis that is left free beside the smallest and the largest gap, for their numbers."""
STEP_PX, AROUND_PX = 34, 70

LEFT = "left on new poses"


@final
@dataclass(frozen=True)
class Step:
    """A dot: from one gap to another [mm], or a gap by itself."""

    label: str
    colour: str
    before: float | None
    after: float


def steps(diagnosis: Diagnosis) -> list[Step]:
    """The dots, from the top."""
    gap = diagnosis.gap
    calibrated, after, floor = (
        max(LEAST, 1e3 * length) for length in (gap.calibrated_m, gap.after_m, gap.noise_floor_m)
    )
    nominal = None if gap.nominal_m is None else max(LEAST, 1e3 * gap.nominal_m)
    found = [] if nominal is None else [Step("nominal model", MUTED, None, nominal)]
    found.append(Step("parameters fitted", MUTED, nominal, calibrated))
    for finding in diagnosis.findings[:MOST]:
        label = named(finding.candidate_effect)
        found.append(Step(label, FITTED, max(LEAST, 1e3 * finding.gap_before_m), max(LEAST, 1e3 * finding.gap_after_m)))
    more = len(diagnosis.model.effects) - len(diagnosis.findings[:MOST])
    if more > 0:
        found.append(Step(f"and {more} more", FITTED, found[-1].after, after))
    return [*found, Step(LEFT, HELD_OUT, None, after), Step("noise alone", NOISE, None, floor)]


def gap_axis(field: str, *, log: bool, domain: tuple[float, float] | None = None) -> Channel:
    """Along which gaps are drawn, beside names of steps."""
    x = quantity(field, "error on new poses, RMS [mm]", log=log, domain=domain)
    x["axis"] |= {"titleAnchor": "end"}  # beside long names there is little room
    return x


def waterfall(diagnosis: Diagnosis) -> Chart:
    """Each step's dot stands at the gap after it; a line leads there from the gap before."""
    rows = steps(diagnosis)
    everything = [value for row in rows for value in (row.before, row.after) if value is not None]
    low, high = min(everything), max(everything)
    logarithmic = high > WIDE * low
    start, end = (
        (low / (high / low) ** ROOM, high * max(2.2, (high / low) ** ROOM)) if logarithmic else (0.0, 1.18 * high)
    )
    ci = [max(1e3 * length, start) for length in diagnosis.gap.after_ci95_m]
    data = records(
        step=[row.label for row in rows],
        series=[row.label for row in rows],
        after=[row.after for row in rows],
        before=[row.after if row.before is None else row.before for row in rows],
        said=["< 1 nm" if row.after == LEAST else millimetres(row.after / 1e3) for row in rows],
    )
    x = gap_axis("after", log=logarithmic, domain=(start, end))
    y = named_rows("step")
    colour = colours({row.label: row.colour for row in rows}, shows_legend=False)
    tooltip = hover("step", before="gap before [mm]", after="gap after [mm]")
    interval = records(step=LEFT, low=ci[0], high=ci[1])
    gap = diagnosis.gap
    first, begin = (
        ("There is no nominal model: from the ordinary parameters fitted, through", gap.calibrated_m)
        if gap.nominal_m is None
        else ("From the nominal model, through the ordinary parameters fitted and", gap.nominal_m)
    )
    scale = " The axis is logarithmic." if logarithmic else ""
    return chart(
        "How far the gap shrinks",
        f"{first} each effect added, to what is left on poses that were not fitted; the number is the gap after the"
        f" step. Black line: its 95 % interval. Dashed: what noise alone would give.{scale}",
        f"The gap falls from {millimetres(begin)} to {millimetres(diagnosis.gap.after_m)}; noise"
        f" alone gives {millimetres(diagnosis.gap.noise_floor_m)}.",
        [
            layer({"type": "rule", "strokeWidth": 3, "opacity": 0.45}, data, tooltip=tooltip,
                  x=x | {"field": "before"}, x2={"field": "after"}, y=y, color=colour),
            layer(rule(color=NOISE), records(after=rows[-1].after), x=x),
            layer({"type": "point", "size": 110, "opacity": 1}, data, tooltip=tooltip, x=x, y=y, color=colour),
            layer({"type": "rule", "color": INK, "strokeWidth": 1.6}, interval,
                  tooltip=hover(low="95 % from [mm]", high="to [mm]"),
                  x=x | {"field": "low"}, x2={"field": "high"}, y=y),
            layer({"type": "text", "dy": -13}, data, x=x, y=y, text={"field": "said"}),
        ],
        height=AROUND_PX + STEP_PX * len(rows),
        zoomable=False,
    )  # fmt: skip
