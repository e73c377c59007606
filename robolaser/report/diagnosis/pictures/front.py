"""How small the gap gets with how many effects."""

from matplotlib.figure import Figure

from robolaser.diagnosis.result import Diagnosis, ParetoPoint
from robolaser.report.canvas import FITTED, HELD_OUT, MUTED, NOISE, Picture, picture, plain_log

WORTH_A_NAME = 0.9
"""Gap over that of the point before, below which a point is named."""


def front(diagnosis: Diagnosis) -> Picture | None:
    """Gap against complexity; the chosen set is marked."""
    choices = sorted(diagnosis.front, key=lambda choice: len(choice.effects))
    if len(choices) < 2:
        return None
    chosen = frozenset(found.candidate_effect for found in diagnosis.findings)
    counts = [len(choice.effects) for choice in choices]
    gaps = [1e3 * choice.gap_m for choice in choices]

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_yscale("log")
        ax.axhline(1e3 * diagnosis.gap.noise_floor_m, color=NOISE, linestyle=(0, (4, 3)))
        ax.annotate("noise alone", (1.0, 1e3 * diagnosis.gap.noise_floor_m), (-2, 4), ha="right", color=NOISE,
                    xycoords=ax.get_yaxis_transform(), textcoords="offset points")  # fmt: skip
        ax.plot(counts, gaps, "o-", color=FITTED, ms=5)
        for i, choice in enumerate(choices):
            if frozenset(choice.effects) == chosen:
                ax.plot(counts[i], gaps[i], "o", ms=12, mfc="none", mew=1.6, color=HELD_OUT)
            if i == 0 or gaps[i] < WORTH_A_NAME * gaps[i - 1]:
                label = ax.annotate(_newest(choices, i), (counts[i], gaps[i]), (8, 6), textcoords="offset points",
                                    color=MUTED, fontsize=8.5)  # fmt: skip
                label.set_in_layout(False)
        ax.set_xlim(-0.2 + counts[0], counts[-1] + 0.45 * max(1, counts[-1] - counts[0]))
        ax.set_xticks(range(counts[0], counts[-1] + 1))
        ax.set_xlabel("effects in the model")
        ax.set_ylabel("error on new poses, RMS [mm]", color=MUTED)
        plain_log(ax.yaxis)

    ringed = any(frozenset(choice.effects) == chosen for choice in choices)
    return picture(
        "Gap against complexity",
        "No set of as few effects was found that leaves a smaller gap than those drawn."
        + (
            " Ringed: the set that was chosen; another effect would have to close more than it costs." if ringed else ""
        ),
        f"The gap falls from {gaps[0]:.3g} to {gaps[-1]:.3g} mm with {counts[-1]} effects.",
        paint,
    )


def _newest(choices: list[ParetoPoint], i: int) -> str:
    """What a set has that the one before has not."""
    before = set(choices[i - 1].effects) if i else set()
    new = [
        f"+ {candidate_effect.kind.name} {candidate_effect.where}"
        for candidate_effect in choices[i].effects
        if candidate_effect not in before
    ]
    return "\n".join(new) or ("none" if not choices[i].effects else "")
