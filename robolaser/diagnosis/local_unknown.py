"""Functions of unknown form at one joint or several: the rivals of the library's effects there.

A parametric form is accepted if it explains the residuals better, after all penalties, than any function of the same
joint. Both are penalised for being one of many causes, and the unknown for being outside the library; an effect is
penalised for its parameters, a random function for its freedom, by the marginal likelihood. A form is wrong if such a
function still explains much beside it.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import of_leaning, of_several_joints, sites
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.gaussian_process_basis import rough, smooth
from robolaser.diagnosis.localization import chance_ratio, function_ratio, likelihood_ratio
from robolaser.diagnosis.penalties import posterior_weights
from robolaser.diagnosis.pose_coordinates import TIME, angle_of, of_run, torque_of
from robolaser.diagnosis.random_functions import RandomFunctions
from robolaser.diagnosis.score_tests import normal_equations
from robolaser.diagnosis.stage_derivatives import stage_derivatives
from robolaser.diagnosis.thresholds import CHI2_OF_UNMODELLED_CAUSE, CHI2_PER_EFFECT, FINE, SMALL_SHARE
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.run import Run
from robolaser.model.stages import Stage

GEOMETRY: Final = "arm_geometry"  # the class of effects that are constants of the arm
TARGET: Final = "target"


def has_form(fit: Fit, candidate_effect: CandidateEffect) -> bool:
    """Whether an effect at a joint or in a target has a form that may be wrong: a placement has none.

    A wrong zero may be a part of a varying error there. An effect that begins at a moment, at any location, may be a
    slipped joint.
    """
    effect, joints = candidate_effect.effect, moving_joints(fit.model.dataset.robot)
    return (effect.cause != GEOMETRY or effect is JointOffset) and (
        candidate_effect.where in (*joints, TARGET) or (effect.begins and bool(joints))
    )


def local_unknown_chi2(fit: Fit, site: str) -> float:
    """Chi-squared that a rough function of a joint's coordinate, or chance there, explains beyond its freedom's cost.

    Args:
        fit: The model.
        site: A moving joint; or another site, which itself or any joint instead may drift in time.
    """
    joints = moving_joints(fit.model.dataset.robot)
    if site == TARGET:
        return 0.0  # `unmodelled_chi2` includes functions of the position on it
    if site in joints:
        sums = joint_equations(fit, site)
        return max(chance_ratio(*sums), *(_ratio(rough(one[:, 0]), *sums) for one in _coordinates(fit.model.run, site)))
    in_time, functions = rough(fit.model.run.progress), RandomFunctions(fit)
    drifts = (replace(one, basis=in_time) for one in sites(fit) if (one.site, one.coordinate) == (site, TIME))
    by_site = (function_ratio(functions, one) for one in drifts)
    return max(*by_site, *(_ratio(in_time, *joint_equations(fit, joint)) for joint in joints))


def chance_chi2(fit: Fit, joint: str) -> float:
    """Chi-squared that pose-to-pose scatter of a joint explains beyond the cost of its freedom; 0 at other sites."""
    if joint not in moving_joints(fit.model.dataset.robot):
        return 0.0
    return chance_ratio(*joint_equations(fit, joint))


def fine_chi2(fit: Fit, joint: str) -> float:
    """Chi-squared that a function of a joint's coordinate with several waves explains beyond its freedom's cost."""
    sums = joint_equations(fit, joint)
    return max(_ratio(smooth(one, FINE), *sums) for one in _coordinates(fit.model.run, joint))


def joint_equations(fit: Fit, joint: str) -> tuple[Array, Array, Array]:
    """Normal equations of independent motions of a joint at each pose, see `normal_equations`."""
    by_joint = stage_derivatives(fit).by_motion(Stage.JOINTS, joint)[:, 0]
    return normal_equations(fit, by_joint, fit.pose_of_number, len(fit.model.dataset.poses))


def _ratio(basis: Array, gradient: Array, own: Array, shared: Array) -> float:
    """Twice the logarithm of the likelihood ratio of a function with a basis (n, p), by a joint's normal equations."""
    along = basis.T @ shared
    return likelihood_ratio((basis.T * own) @ basis - along @ along.T, basis.T @ gradient)[0]


def posture_unknown_chi2(fit: Fit) -> float:
    """Chi-squared that a single smooth cause of the whole arm explains beyond the cost of its freedom.

    It is a function of the posture for each of several joints, all of one size; or a force at the flange; or a stand
    that leans, which, as any cause at one place, is penalised for being outside the library.
    """
    prices = (of_several_joints, 0.0), (of_leaning, CHI2_OF_UNMODELLED_CAUSE)
    priced = [(site, price) for sites_of, price in prices for site in sites_of(fit)]
    functions = RandomFunctions(fit)
    return max((function_ratio(functions, site) - price for site, price in priced), default=0.0)


def probability_of_local_unknown(final: float, left: float, without: float, instead: float) -> float:
    """Probability of a function of unknown form at a joint, instead of the effects there or beside them.

    A small part that it explains beyond the effects, or beside them, may be an inexact form of the effects.

    Args:
        final: Cost of the model with the effects.
        left: Chi-squared that such a function explains beside them.
        without: Cost of the model without the effects.
        instead: Chi-squared that such a function explains in it.
    """
    explained, price = without - final, CHI2_PER_EFFECT + CHI2_OF_UNMODELLED_CAUSE
    beside = final - left + price if left > SMALL_SHARE * explained else np.inf
    alone = without - instead + price if instead > (1.0 + SMALL_SHARE) * explained else np.inf
    weights = posterior_weights(np.array([final, beside, alone]))
    return float(weights[1:].sum())


def _coordinates(run: Run, joint: str) -> Iterator[Array]:
    """The joint's angle, its gravity torque, and time at each pose, (n, 1) each."""
    in_time = (one for one in of_run(run) if one.name == TIME)
    return (one.values for one in (angle_of(run, joint), *torque_of(run, joint), *in_time))
