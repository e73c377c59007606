"""How small the gap gets with how many effects."""

from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.result import Diagnosis, ParetoPoint
from robolaser.report.chart import FITTED, HELD_OUT, NOISE, Chart, chart, hover, layer, named_rows, records, rule
from robolaser.report.diagnosis.charts.waterfall import STEP_PX, gap_axis

AROUND_PX = 60


def front(diagnosis: Diagnosis) -> Chart | None:
    """Gap against complexity; the chosen set is marked."""
    choices = sorted(diagnosis.front, key=lambda choice: len(choice.effects))
    if len(choices) < 2:
        return None
    chosen = frozenset(diagnosis.model.effects)
    gaps = [1e3 * choice.gap_m for choice in choices]
    data = records(
        step=[f"{len(choice.effects)} {_added(choices, i)}" for i, choice in enumerate(choices)],
        effects=[len(choice.effects) for choice in choices],
        gap=gaps,
        members=[", ".join(named(one) for one in choice.effects) or "none" for choice in choices],
    )
    ring = [row for row, choice in zip(data, choices, strict=True) if frozenset(choice.effects) == chosen]
    x = gap_axis("gap", log=True)
    y = named_rows("step")
    tooltip = hover("members", effects="effects", gap="error on new poses [mm]")
    return chart(
        "Gap against complexity",
        "From the top: the smallest gap found with each number of effects, and what each adds. Dashed: noise alone."
        + (" Ringed: the chosen set; another effect would have to reduce the gap by more." if ring else ""),
        f"The gap falls from {gaps[0]:.3g} to {gaps[-1]:.3g} mm with {len(choices[-1].effects)}"
        f" effect{'s' * (len(choices[-1].effects) != 1)}.",
        [
            layer({"type": "line", "color": FITTED}, data, x=x, y=y, order={"field": "effects"}),
            layer(rule(color=NOISE), records(gap=1e3 * diagnosis.gap.noise_floor_m), x=x),
            layer({"type": "point", "size": 70, "color": FITTED, "opacity": 1}, data, tooltip=tooltip, x=x, y=y),
            layer({"type": "point", "filled": False, "size": 260, "color": HELD_OUT, "opacity": 1, "strokeWidth": 2},
                  ring, tooltip=tooltip, x=x, y=y),
        ],
        height=AROUND_PX + STEP_PX * len(choices),
        zoomable=False,
    )  # fmt: skip


def _added(choices: list[ParetoPoint], i: int) -> str:
    """What a set has that the one before has not; the first has nothing before it."""
    before = set(choices[i - 1].effects) if i else set()
    new = [f"+ {named(one)}" for one in choices[i].effects if one not in before]
    return f"{new[0]} and {len(new) - 1} more" if len(new) > 1 else "".join(new)
