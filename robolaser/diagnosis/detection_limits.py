"""The smallest size of each effect that the data could have shown."""

from collections.abc import Iterable

import numpy as np

from robolaser.diagnosis.result import DetectionLimit
from robolaser.diagnosis.score_tests import SEEN, Signature, typical
from robolaser.diagnosis.verdict import DETECTED, price


def limits(signatures: Iterable[Signature], spread: float) -> tuple[DetectionLimit, ...]:
    """For each effect that is not in the model, the size of its principal number that is found nine times in ten.

    The squared signature of a size δ is δ² |s|², s being what the fitted parameters cannot imitate of it. What is
    seen of its length scatters by one standard deviation: it must exceed the effect's price by as much as nine times
    in ten need.

    Args:
        signatures: Against the final model.
        spread: By how much whole poses scatter more than noise.
    """
    found = []
    for signature in signatures:
        candidate_effect = signature.candidate_effect
        name, unit, *_ = candidate_effect.kind.declared()[0]
        length = float(np.linalg.norm(signature.columns[:, 0]))
        unseen = length**2 < SEEN * max(float((signature.white[:, 0] ** 2).sum()), 1e-12)
        needed = (np.sqrt(price(candidate_effect, signature.tried)) + DETECTED) * np.sqrt(spread)
        size = None if unseen else float(needed / length * typical(candidate_effect)[0])
        found.append(DetectionLimit(candidate_effect, name, size, unit))
    return tuple(sorted(found, key=lambda limit: (limit.candidate_effect.kind.name, limit.candidate_effect.where)))
