"""How effects are sought: a few, one by one; and where that does not do, out of the geometry of a whole arm."""

from robolaser.diagnosis.localization import explained
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import dispersion
from robolaser.model.effects.link_geometry import LinkGeometry

FEW = 3
"""Effects that explain an arm, beyond which its whole geometry is suspected: joints hide each other's errors."""
BESIDE = 4
"""Effects beside the geometry of a whole arm, at most."""


def sought(search: Search, begin: Fitted | None = None) -> Fitted:
    """The set of effects that explains the most for its price.

    Of stripe scanners the geometry is never asked as a whole: their own parameters take part in too much.

    Args:
        search: Fits sets of effects.
        begin: A set that was found before, on slightly other rows.
    """
    if begin is not None or search.start.problem.model.dataset.kind == "stripe":
        return search.best(begin)
    few = search.best(most=FEW)
    geometry = [s for s in search.signatures(search.start) if s.candidate_effect.effect is LinkGeometry]
    if (len(few.effects) < FEW and dispersion(few) <= 1.0 and explained(few) <= 0.0) or not geometry:
        return few
    arm = search.fit(search.start, geometry)
    spread = min(map(dispersion, (few, arm)))
    while arm.effects:
        less = min(
            (search.fit(arm, removed=candidate_effect) for candidate_effect in arm.effects),
            key=lambda f: search.cost(f, spread),
        )
        if search.cost(less, spread) > search.cost(arm, spread):
            break
        arm = less
    arm = search.best(arm, most=len(arm.effects) + BESIDE)
    spread = min(map(dispersion, (few, arm)))
    return min(few, arm, key=lambda fit: search.cost(fit, spread))
