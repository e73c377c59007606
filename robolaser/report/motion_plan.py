"""What planned motions could tell, as text and as a page."""

from collections.abc import Sequence

from robolaser.motion.plan import MotionLimit, MotionPlan
from robolaser.report.document import Column, Document, Notes, Section, Table
from robolaser.report.motion import headline, shown_in
from robolaser.report.setting import untestable

ROWS = {"tracking": "readings", "torque": "torques", "load": "second encoder"}


def document(plan: MotionPlan, *, command: str = "") -> Document:
    """The report.

    Args:
        plan: What it shows.
        command: What to type to repeat it.
    """
    log = plan.log
    shown = [one for one in plan.limits if one.size is not None]
    alone = sum(not one.alike for one in shown)
    columns = [
        Column("Effect", "name", brief="effect"),
        Column("Where", brief="where"),
        Column("Rows", brief="shown by"),
        Column("Detectable from", brief="detectable from"),
        Column("Not distinguished from", "wide", brief="not distinguished from"),
    ]
    untried = dict(sorted(plan.untestable.items()))
    return Document(
        log.name,
        "planned",
        headline(log),
        f"Of {len(plan.limits)} faults that could be looked for, these motions would show {len(shown)}, and distinguish"
        f" {alone} of them from the others.",
        "",
        [],
        [
            Section(
                "Smallest sizes", [Table(columns, [_row(group, log.joints) for group in _groups(plan)], printed=1000)]
            ),
            Section("Motions to add", [Notes(plan.next_motions, "steps", 8)] if plan.next_motions else []),
            Section("What these motions cannot test", [untestable(untried)] if untried else []),
        ],
        command=command,
        prints_lead=True,
    )


def _groups(plan: MotionPlan) -> list[list[MotionLimit]]:
    """What is planned, effect by effect; where another number of one acts, apart."""
    groups: dict[tuple[str, str, str], list[MotionLimit]] = {}
    for one in plan.limits:
        groups.setdefault((one.at.effect.name, one.at.effect.rows, one.number.name), []).append(one)
    return list(groups.values())


def _row(group: Sequence[MotionLimit], joints: Sequence[str]) -> tuple[str, ...]:
    """An effect at all of its places: from which size it shows at the best and at the worst of them."""
    effect = group[0].at.effect
    places = [one.at.where for one in group]
    where = "all joints" if list(joints) == places else ", ".join(places)
    never = [one.at.where for one in group if one.size is None]
    sizes = sorted((one.size for one in group if one.size is not None), reverse=effect.name == "speed_limit")
    number = group[0].number
    scale, unit = shown_in(number.unit)
    shown = list(dict.fromkeys(f"{float(f'{scale * size:.2g}'):g}" for size in (*sizes[:1], *sizes[-1:])))
    below = "below " if effect.name == "speed_limit" else ""
    size = f"{below}{' to '.join(shown)}{unit}".rstrip() if shown else "never"
    size += f"; never at {', '.join(never)}" if never and shown else ""
    alike: dict[str, list[str]] = {}
    for one in group:
        for rival in one.alike:
            alike.setdefault(rival.effect.name.replace("_", " "), []).append(one.at.where)
    rivals = [name if at == places else f"{name} at {', '.join(at)}" for name, at in alike.items()]
    name = effect.name.replace("_", " ") + (f" ({number.name})" if number is not effect.numbers[0] else "")
    return name, where, ROWS[effect.rows], size, "; ".join(rivals)
