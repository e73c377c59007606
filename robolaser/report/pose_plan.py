"""Detection limits of planned poses, on a terminal: the smallest sizes, and indistinguishable effects."""

from robolaser.diagnosis.cause_words import spoken
from robolaser.diagnosis.noise_remarks import SHOWN
from robolaser.diagnosis.pose_plan import PosePlan
from robolaser.report.document import Document, Figure, Figures, Section, Text
from robolaser.report.setting import disturbed, limit_table, noise_size

LEAST_SEEING = 0.7  # of the poses: if fewer see it, they were planned for another cell than the guessed one
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
    tried = {one.effect.name for one in plan.candidates}
    untried = [
        Text(f"Not testable: {spoken(name)}: {reason}", "quiet", printed=True)
        for name, reason in plan.untestable.items()
        if name not in tried
    ]
    setting = f"{plan.dataset.format.title}, {poses} poses{seen}"
    doubt = GUESSED if plan.seeing < LEAST_SEEING * poses else ""
    sections = [Section("Smallest sizes", [limit_table(plan.limits), *untried])]
    return Document(plan.dataset.name, "planned", setting, "", doubt, [Figures(noise)] if noise else [], sections)


def _evidence(plan: PosePlan, name: str) -> str:
    evidence = SHOWN.get(plan.noise.origin.get(name, "stated"))
    return f", estimated from the {evidence}" if evidence else ""
