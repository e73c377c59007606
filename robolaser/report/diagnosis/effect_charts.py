"""Each effect against what it depends on: the error that it explains, and what it leaves."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import FITTED, HELD_OUT, INK, LINES, Chart, chart, colours, hover, layer, quantity, records
from robolaser.report.diagnosis.explained_errors import FORESEEN, ExplainedError, explained_errors
from robolaser.report.digits import human

MOST: Final = 6
"""Effects with a chart on the page, the first findings."""
SIDES: Final = (-1.3, 1.3)
"""Of an axis that has -1 and 1 only."""
BEFORE, AFTER, EFFECT = "without it", "left with it", "the effect"


def effect_charts(diagnosis: Diagnosis) -> Iterator[Chart]:
    """Of the effects that were found."""
    if diagnosis.weighed is None:
        return
    wanted = [one.candidate_effect for one in diagnosis.findings[:MOST]]
    found = {one.candidate_effect: one for one in explained_errors(diagnosis.weighed, wanted)}
    names = diagnosis.weighed.final.model.dataset.poses.names
    yield from (_chart(found[one], names) for one in wanted if one in found)


def _chart(one: ExplainedError, names: tuple[str, ...]) -> Chart:
    scale, unit = human(1.0, one.unit)
    is_sign = one.coordinate.unit == "sign"
    length, per, second = one.coordinate.unit.partition("/s")
    along, of = human(1.0, "" if is_sign else length)
    x, y = along * one.x, scale * one.moves
    series = {BEFORE: y + scale * one.left, EFFECT: y, AFTER: scale * one.left}
    looks = {BEFORE: (HELD_OUT, 40, False), EFFECT: (INK, 26, True), AFTER: (FITTED, 26, True)}
    if one.rival is not None:
        rival, left = one.rival
        name = f"left with {named(rival)}"
        series[name], looks[name] = scale * left, (LINES[3], 26, False)
    pose = [names[i] for i in one.pose]
    across = quantity(
        "x", f"{one.coordinate.name}{f' [{of}{per}{second}]' if of else ''}", domain=SIDES if is_sign else None
    )
    up = quantity("error", f"error of {one.of} [{unit}]")
    colour = colours({name: looks[name][0] for name in series})
    said = hover("pose", "series", error=f"error [{unit}]")
    before, after = (float(np.sqrt(np.square(series[name]).mean())) for name in (BEFORE, AFTER))
    title = named(one.candidate_effect)
    no_other = one.coordinate.name == FORESEEN
    return chart(
        title[:1].upper() + title[1:],
        f"The error of {one.of} that each {'pose' if one.of == one.candidate_effect.where else 'row'} shows, with"
        " everything else in the model: without this effect, and what is left with it. If the dots follow those of"
        " the effect, and nothing of that shape is left, the effect has the right form."
        + (" It depends on no coordinate alone, so the axis is the effect itself." if no_other else "")
        + (" The other effect cannot be distinguished from it with these poses." if one.rival is not None else ""),
        f"The error of {one.of} falls from {before:.2g} {unit} to {after:.2g} {unit} RMS over {len(pose)} of them.",
        [
            layer({"type": "point", "size": size, "filled": filled, "strokeWidth": 1.4},
                  records(x=x, error=series[name], pose=pose, series=name), tooltip=said, x=across, y=up, color=colour)
            for name, (_, size, filled) in looks.items()
        ],
    )  # fmt: skip
