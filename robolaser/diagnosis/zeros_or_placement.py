"""Wrong zeros of two neighbouring joints against the placement of the second: its six parameters imitate both zeros.

Marginal likelihoods decide between them: the four further parameters cost the logarithm of the ratio of their prior to
their posterior variance, since the data narrow them although they are not needed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.special import expit

from robolaser.diagnosis.arm_geometry import placements_of_arm
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.profile_likelihood import SIZES
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.thresholds import CHI2_PER_EFFECT
from robolaser.estimation.certainty import LIKELY
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.link_geometry import LinkGeometry


@final
@dataclass(frozen=True)
class SetRival:
    """A model with zeros instead of a placement, or a placement instead of zeros."""

    effects: tuple[CandidateEffect, ...]  # its effects that the other model lacks
    fit: Fit
    probability: float  # its probability against the other model


def set_rivals(refits: Refits, fit: Fit, one: CandidateEffect, held_out: HeldOut) -> Iterator[SetRival]:
    """Yield the rivals of a placement in a model, or of a zero with that of a neighbouring joint.

    Neither is certain unless it predicts held-out poses certainly better.
    """
    joints = moving_joints(fit.model.dataset.robot)
    if one.effect not in (JointOffset, LinkGeometry) or one.where not in joints or placements_of_arm(fit.effects):
        return
    at = joints.index(one.where)
    for number in [at] if one.effect is LinkGeometry else [at, at + 1]:
        if not 0 < number < len(joints):
            continue
        placement = CandidateEffect(LinkGeometry, joints[number])
        zeros = [CandidateEffect(JointOffset, joint) for joint in joints[number - 1 : number + 1]]
        held = [zero for zero in zeros if zero in fit.effects]
        if one == placement and held != zeros:
            here, there = [placement, *held], zeros
        elif held == zeros and placement not in fit.effects:
            here, there = zeros, [placement]
        else:
            continue
        new = tuple(each for each in there if each not in here)
        rival = _exchanged(refits, fit, [each for each in here if each not in there], new)
        if rival is not None:
            probability = expit(0.5 * (_evidence(fit, here) - _evidence(rival, there)))
            yield SetRival(new, rival, float(np.clip(probability, *_limits(fit, rival, held_out))))


def _limits(fit: Fit, rival: Fit, held_out: HeldOut) -> tuple[float, float]:
    """The least and the largest probability of a rival, from both models' held-out errors."""
    least = 0.0 if held_out.lowers(rival, fit) else 1.0 - LIKELY
    return least, 1.0 if held_out.lowers(fit, rival) else LIKELY


def _exchanged(
    refits: Refits, fit: Fit, removed: Sequence[CandidateEffect], added: Sequence[CandidateEffect]
) -> Fit | None:
    """The fit with some effects instead of others; None if they are no candidates."""
    fit = refits.without(fit, removed)
    tests = {test.candidate_effect: test for test in refits.score_tests(fit)}
    if not all(one in tests for one in added):
        return None
    return refits.refit(fit, [tests[one] for one in added])


def _evidence(fit: Fit, effects: Sequence[CandidateEffect]) -> float:
    """Minus twice the logarithm of the marginal likelihood, each effect with the size of maximum likelihood."""
    cost, names = fit.deviance, fit.problem.parameters.names
    for one in effects:
        own = [names.index(one.key(each.name)) for each in one.effect.amplitudes()]
        usual = np.array([each.prior_scale for each in one.effect.amplitudes()])
        variances, V = np.linalg.eigh(fit.at.covariance[np.ix_(own, own)] / np.outer(usual, usual))
        along = np.square(V.T @ (fit.x[own] / usual))
        variances = np.maximum(variances, np.finfo(float).tiny)
        wide = SIZES[:, None] ** 2
        widened = variances + wide
        cost += CHI2_PER_EFFECT + float((np.log(widened) - np.log(variances) + along / widened).sum(axis=1).min())
    return cost
