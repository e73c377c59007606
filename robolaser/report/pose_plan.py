"""Detection limits of planned poses, on a terminal: the smallest sizes, and indistinguishable effects."""

from robolaser.diagnosis.cause_words import named, place, spoken
from robolaser.diagnosis.noise_remarks import SHOWN
from robolaser.diagnosis.pose_plan import PosePlan
from robolaser.diagnosis.result import DetectionLimit
from robolaser.report.digits import millimetres, plain
from robolaser.report.document import Column, Document, Figure, Figures, Section, Table, Text
from robolaser.report.setting import disturbed, noise_size

DIGITS = 2
LEAST_SEEING = 0.7  # of the poses: if fewer see it, they were planned for another cell than the guessed one
COLUMNS = ("effect", "where", "detectable from", "distinguishable from", "at the tool", "nearest other")
GUESSED = (
    "The poses of sensor and target are guesses, and too few of these poses see the target. Measure once in some"
    " of them, and plan from that data set."
)


def document(plan: PosePlan) -> Document:
    """The report."""
    poses = len(plan.dataset.poses)
    seen = "" if plan.seeing == poses else f", {plan.seeing} of them see something"
    units = {source.name: source.unit for source in plan.noise.sources}
    noise = [
        Figure("", name.replace("_", " "), noise_size(sigma, units[name]), disturbed(name) + _evidence(plan, name))
        for name, sigma in plan.noise.sigmas.items()
        if sigma > 0 or name in plan.silent
    ]
    columns = [Column(title, brief=title) for title in COLUMNS]
    sizes = Table(columns, [_row(limit) for limit in plan.limits], printed=len(plan.limits))
    tried = {one.effect.name for one in plan.candidates}
    untried = [
        Text(f"Not testable: {spoken(name)}: {reason}", "quiet", printed=True)
        for name, reason in plan.untestable.items()
        if name not in tried
    ]
    setting = f"{plan.dataset.format.title}, {poses} poses{seen}"
    doubt = GUESSED if plan.seeing < LEAST_SEEING * poses else ""
    sections = [Section("Smallest sizes", [sizes, *untried])]
    return Document(plan.dataset.name, "planned", setting, "", doubt, [Figures(noise)] if noise else [], sections)


def _evidence(plan: PosePlan, name: str) -> str:
    evidence = SHOWN.get(plan.noise.origin.get(name, "stated"))
    return f", estimated from the {evidence}" if evidence else ""


def _row(limit: DetectionLimit) -> tuple[str, ...]:
    one, rival = limit.candidate_effect, limit.rival
    size = "never" if limit.size is None else plain(limit.size, limit.unit, DIGITS)
    distinguishable = "never" if limit.identifiable is None else plain(limit.identifiable, limit.unit, DIGITS)
    at_tool = "" if limit.at_tool_m is None else millimetres(limit.at_tool_m)
    nearest = "" if rival is None else named(rival)
    return spoken(one.effect.name), place(one.where), size, distinguishable, at_tool, nearest
