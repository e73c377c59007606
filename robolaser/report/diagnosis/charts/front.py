"""How small the gap gets with how many effects."""

from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.result import Diagnosis, ParetoPoint
from robolaser.report.chart import FITTED, HELD_OUT, MUTED, NOISE, Chart, chart, hover, layer, quantity, records, rule

WORTH_A_NAME = 0.9
"""Gap over that of the point before, below which a point is named."""


def front(diagnosis: Diagnosis) -> Chart | None:
    """Gap against complexity; the chosen set is marked."""
    choices = sorted(diagnosis.front, key=lambda choice: len(choice.effects))
    if len(choices) < 2:
        return None
    chosen = frozenset(diagnosis.model.effects)
    counts = [len(choice.effects) for choice in choices]
    gaps = [1e3 * choice.gap_m for choice in choices]
    labelled = [i == 0 or gaps[i] < WORTH_A_NAME * gaps[i - 1] for i in range(len(choices))]
    data = records(
        effects=counts,
        gap=gaps,
        members=[", ".join(named(one) for one in choice.effects) or "none"
                 for choice in choices],
        added=[_added(choices, i) if labelled[i] and 2 * i < len(choices) else "" for i in range(len(choices))],
        last=[_added(choices, i) if labelled[i] and 2 * i >= len(choices) else "" for i in range(len(choices))],
    )  # fmt: skip
    ring = [row for row, choice in zip(data, choices, strict=True) if frozenset(choice.effects) == chosen]
    floor = records(gap=1e3 * diagnosis.gap.noise_floor_m, said="noise alone")
    x = quantity("effects", "effects in the model", domain=(counts[0] - 0.2, counts[-1] + 0.6))
    x["axis"] = {"values": list(range(counts[0], counts[-1] + 1)), "format": "d"}
    y = quantity("gap", "error on new poses, RMS [mm]", log=True)
    tooltip = hover("members", effects="effects", gap="error on new poses [mm]")
    note = {"type": "text", "align": "left", "dx": 8, "dy": -9, "color": MUTED, "fontSize": 11.5}
    aside = {"type": "text", "align": "left", "dx": 4, "dy": -7, "color": NOISE}
    return chart(
        "Gap against complexity",
        "The smallest gap found with each number of effects."
        + (" Ringed: the chosen set; another effect would have to reduce the gap by more." if ring else ""),
        f"The gap falls from {gaps[0]:.3g} to {gaps[-1]:.3g} mm with {counts[-1]} effect{'s' * (counts[-1] != 1)}.",
        [
            layer({"type": "line", "color": FITTED}, data, x=x, y=y),
            layer(rule(color=NOISE), floor, y=y),
            layer(aside, floor, x={"value": 0}, y=y, text={"field": "said"}),
            layer({"type": "point", "size": 70, "color": FITTED, "opacity": 1}, data, tooltip=tooltip, x=x, y=y),
            layer({"type": "point", "filled": False, "size": 260, "color": HELD_OUT, "opacity": 1, "strokeWidth": 2},
                  ring, tooltip=tooltip, x=x, y=y),
            layer(note, data, x=x, y=y, text={"field": "added"}),
            layer(note | {"align": "right", "dx": -12, "dy": 14}, data, x=x, y=y, text={"field": "last"}),
        ],
    )  # fmt: skip


def _added(choices: list[ParetoPoint], i: int) -> str:
    """What a set has that the one before has not."""
    before = set(choices[i - 1].effects) if i else set()
    new = [f"+ {named(one)}" for one in choices[i].effects if one not in before]
    return ", ".join(new)
