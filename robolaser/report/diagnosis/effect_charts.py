"""Each effect of a joint against what it depends on: the error that it explains, and what it leaves."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.joint_evidence import JointEvidence, joint_evidence
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import FITTED, HELD_OUT, INK, Chart, chart, colours, hover, layer, quantity, records

MOST: Final = 6
"""Effects with a chart on the page, the first findings."""
SIDES: Final = (-1.3, 1.3)
"""Of an axis that has -1 and 1 only."""
BEFORE, AFTER, EFFECT = "without it", "left with it", "the effect"


def effect_charts(diagnosis: Diagnosis) -> Iterator[Chart]:
    """Of the effects that were found, those that move joints by other amounts at other poses."""
    robot = diagnosis.dataset.robot
    if diagnosis.weighed is None or robot is None:
        return
    shown = [one.candidate_effect for one in diagnosis.findings[:MOST]]
    found = {one.candidate_effect: one for one in joint_evidence(diagnosis.weighed)}
    names = diagnosis.weighed.final.model.dataset.poses.names
    slides = dict(zip(robot.joints, robot.prismatic.tolist(), strict=True))
    for one in shown:
        if one in found:
            yield _chart(found[one], names, slides=slides[one.where])


def _chart(one: JointEvidence, names: tuple[str, ...], *, slides: bool) -> Chart:
    scale, unit = (1e3, "mm") if slides else (float(np.degrees(1.0)), "°")
    along, of = (float(np.degrees(1.0)), " [°]") if one.unit == "rad" else (1.0, " [Nm]" if one.unit == "Nm" else "")
    x, y = along * one.x, scale * one.moves
    series = {BEFORE: y + scale * one.left, EFFECT: y, AFTER: scale * one.left}
    looks = {BEFORE: (HELD_OUT, 40, False), EFFECT: (INK, 26, True), AFTER: (FITTED, 26, True)}
    joint, pose = one.candidate_effect.where, [names[i] for i in one.pose]
    across = quantity("x", f"{one.coordinate}{of}", domain=SIDES if one.unit == "1" else None)
    up = quantity("error", f"error of {joint} [{unit}]")
    colour = colours({name: looks[name][0] for name in series})
    said = hover("pose", "series", error=f"error [{unit}]")
    before, after = (float(np.sqrt(np.square(series[name]).mean())) for name in (BEFORE, AFTER))
    title = named(one.candidate_effect)
    return chart(
        title[:1].upper() + title[1:],
        f"The error of {joint} that each pose shows, with everything else in the model: without this effect, and what"
        " is left with it. If the dots follow those of the effect, and nothing of that shape is left, the effect has"
        " the right form.",
        f"The error of {joint} falls from {before:.2g}{unit} to {after:.2g}{unit} RMS over {len(pose)} poses.",
        [
            layer({"type": "point", "size": size, "filled": filled, "strokeWidth": 1.4},
                  records(x=x, error=series[name], pose=pose, series=name), tooltip=said, x=across, y=up, color=colour)
            for name, (_, size, filled) in looks.items()
        ],
    )  # fmt: skip
