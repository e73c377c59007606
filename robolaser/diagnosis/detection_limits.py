"""The smallest detectable and identifiable size of each effect, and the error at the tool if it is overlooked.

Geodesy calls them minimal detectable bias, minimal separable bias, and external reliability (Baarda 1968, A testing
procedure for use in geodetic networks; Förstner 1983).
"""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.diagnosis.result import DetectionLimit
from robolaser.diagnosis.score_tests import ScoreTest
from robolaser.diagnosis.thresholds import LARGEST_PLAUSIBLE, SEEN
from robolaser.estimation.certainty import CERTAIN
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.model.effects.effect import CandidateEffect


def detection_limits(tests: Sequence[ScoreTest], alone: Sequence[ScoreTest] = ()) -> tuple[DetectionLimit, ...]:
    """For each effect outside the model, the size of its principal parameter that is detected nine times in ten.

    A size δ explains δ² |s|², where s is its column without the part that the fitted parameters imitate. The square
    root of the measured value has a standard deviation of one, and the value must exceed the effect's complexity
    penalty. Beside a rival at an angle c, only (1 - cos² c) of it distinguishes the two. Implausible sizes are omitted.

    Args:
        tests: All against the final model.
        alone: All against the model without effects. An effect that is visible only there, with next to nothing of its
            column left in the final model, is imitated by the effects found.
    """
    seen_alone = {test.candidate_effect: _share_left(test) for test in alone if _size(test) <= _largest(test)}
    limits = []
    for test, (rival, overlap) in zip(tests, _nearest_rivals(tests), strict=True):
        one = test.candidate_effect
        amplitude = one.effect.amplitudes()[0]
        unit = one.parameters_in(test.against.model.dataset.robot).items[0].unit
        size, largest = _size(test), _largest(test)
        identifiable = size / np.sqrt(1.0 - overlap) if overlap < 1.0 else np.inf
        is_seen, is_identified = size <= largest, identifiable <= largest
        limits.append(
            DetectionLimit(
                one,
                amplitude.name,
                float(size) if is_seen else None,
                unit,
                identifiable=float(identifiable) if is_identified else None,
                rival=rival if is_seen else None,
                at_tool_m=_at_tool(test, float(size)) if is_seen else None,
                is_imitated=not is_seen and _share_left(test) < SEEN * seen_alone.get(one, 0.0),
            )
        )
    return tuple(sorted(limits, key=lambda limit: (limit.candidate_effect.effect.name, limit.candidate_effect.where)))


def _size(test: ScoreTest) -> float:
    """Detectable size of an effect's principal parameter; infinite if the fitted parameters imitate the effect."""
    length = float(np.linalg.norm(test.columns[:, 0]))
    needed = np.sqrt(test.penalty) + NormalDist().inv_cdf(CERTAIN)
    scale = test.candidate_effect.effect.amplitudes()[0].prior_scale
    return np.inf if _share_left(test) < NEGLIGIBLE else float(needed / length * scale)


def _largest(test: ScoreTest) -> float:
    """Largest plausible size of that parameter."""
    amplitude = test.candidate_effect.effect.amplitudes()[0]
    return min(amplitude.bound, LARGEST_PLAUSIBLE * amplitude.prior_scale)


def _share_left(test: ScoreTest) -> float:
    """Share of an effect's squared principal column that the fitted parameters do not imitate."""
    left, whole = float((test.columns[:, 0] ** 2).sum()), float((test.white[:, 0] ** 2).sum())
    return left / max(whole, 1e-12)


def _nearest_rivals(tests: Sequence[ScoreTest]) -> list[tuple[CandidateEffect | None, float]]:
    """For each effect the candidate that imitates its principal column best, and cos² of their angle.

    Candidates of a higher penalty are no rivals: they would have to explain more.
    """
    if not tests:
        return []
    shares = _shares(tests)
    prices = np.array([test.penalty for test in tests])
    shares[prices[:, None] > prices] = 0.0
    np.fill_diagonal(shares, 0.0)
    nearest = shares.argmax(axis=0)
    overlap = np.minimum(shares.max(axis=0), 1.0)
    return [
        (tests[j].candidate_effect if share > 0.0 else None, float(share))
        for j, share in zip(nearest.tolist(), overlap.tolist(), strict=True)
    ]


def correlations(tests: Sequence[ScoreTest]) -> Array:
    """|cosine| of the angle between one effect's principal column and another's columns, the larger of both, (e, e)."""
    cosine = np.sqrt(np.minimum(_shares(tests), 1.0))
    return np.asarray(np.maximum(cosine, cosine.T))


def _shares(tests: Sequence[ScoreTest]) -> Array:
    """Share of each effect's squared principal column (second axis) that another one (first axis) imitates, (e, e)."""
    principal = np.stack([test.columns[:, 0] for test in tests], axis=1)
    squares = np.maximum((principal**2).sum(axis=0), np.finfo(float).tiny)
    return np.asarray(np.stack([((test.basis.T @ principal) ** 2).sum(axis=0) for test in tests]) / squares)


def _at_tool(test: ScoreTest, size: float) -> float:
    """Root-mean-square displacement of the rows by an effect of a size, without a refit [m]."""
    fit, scale = test.against, test.candidate_effect.effect.amplitudes()[0].prior_scale
    moved = fit.noise.correlate(test.white[:, 0][None] * (size / scale))
    return rms(fit.in_metres(moved.reshape(fit.at.plain.shape)))
