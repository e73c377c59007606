"""The smallest size of each effect that the data would have shown."""

from collections.abc import Iterable

import numpy as np

from robolaser.diagnosis.refits import penalty
from robolaser.diagnosis.result import DetectionLimit
from robolaser.diagnosis.score_tests import NEGLIGIBLE, ScoreTest, prior_scales
from robolaser.diagnosis.thresholds import DETECTION_SIGMA


def detection_limits(tests: Iterable[ScoreTest], spread: float) -> tuple[DetectionLimit, ...]:
    """For each effect that is not in the model, the size of its principal parameter that is found nine times in ten.

    A size δ explains δ² |s|², s being its column without what the fitted parameters imitate. The square root of what is
    measured of that scatters by one standard deviation, and it must exceed the effect's complexity penalty.

    Args:
        tests: Against the final model.
        spread: The dispersion: by how much whole poses scatter more than noise.
    """
    limits = []
    for test in tests:
        name, unit, *_ = test.candidate_effect.effect.amplitudes()[0]
        length = float(np.linalg.norm(test.columns[:, 0]))
        imitated = length**2 < NEGLIGIBLE * max(float((test.white[:, 0] ** 2).sum()), 1e-12)
        needed = (np.sqrt(penalty(test)) + DETECTION_SIGMA) * np.sqrt(spread)
        size = None if imitated else float(needed / length * prior_scales(test.candidate_effect)[0])
        limits.append(DetectionLimit(test.candidate_effect, name, size, unit))
    return tuple(sorted(limits, key=lambda limit: (limit.candidate_effect.effect.name, limit.candidate_effect.where)))
