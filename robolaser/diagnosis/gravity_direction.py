"""Arms mounted in another orientation than stated: elastic deflection under another direction of gravity."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.fit import MOST_STEPS
from robolaser.diagnosis.result import Diagnosis, Estimate, WrongInput
from robolaser.diagnosis.summary_text import millimetres
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT
from robolaser.diagnosis.wrong_input import fall_in_sigmas, probability_of, squares, with_fault
from robolaser.estimation.certainty import CERTAIN, EVEN
from robolaser.estimation.solver import SHARE
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_compliance import JointCompliance
from robolaser.model.forward_model import Model, jacobian_matrix


def with_gravity_turned(found: Diagnosis, examine: Callable[[Dataset], Diagnosis]) -> Diagnosis:
    """The diagnosis with another direction of gravity, if compliant joints then explain the gap.

    Args:
        found: The diagnosis with the stated gravity.
        examine: Diagnoses another data set in the same way.
    """
    robot = found.dataset.robot
    if (
        found.verdict != "unexplained"
        or found.hindrance
        or robot is None
        or not JointCompliance.locations(found.observed)
    ):
        return found
    stated, turned = np.array(robot.gravity), _turned(found)
    if turned is None:
        return found
    corrected = examine(replace(found.dataset, robot=robot.under(turned)))
    falls = fall_in_sigmas(squares(found.observed, found.after_m), squares(corrected.observed, corrected.after_m))
    yields = any(one.name == JointCompliance.cause and one.probability >= CERTAIN for one in corrected.classes)
    if corrected.verdict != "explained" or falls < SIGMA_OF_95_PERCENT or not yields:
        return found
    soft = [one for one in corrected.findings if one.candidate_effect.effect is JointCompliance]
    if stated @ turned < 0.0 and len(soft) < 2:  # a lone joint with a reversed deflection may have a spring
        return found
    wrong = WrongInput(
        "gravity_direction",
        "base",
        "base",
        probability_of(found, corrected),
        {axis: Estimate(float(value), None, "m/s²") for axis, value in zip("xyz", turned, strict=True)},
        found.gap.calibrated_m,
        corrected.gap.after_m,
    )
    text = (
        f"Gravity in the base frame is stated as {_vector(stated)} m/s², but the arm deflects as under"
        f" {_vector(turned)} m/s². Correct gravity under [robot] in dataset.toml: the error on new poses is then"
        f" {millimetres(corrected.gap.after_m)} instead of {millimetres(found.gap.after_m)}."
    )
    return with_fault(found, corrected, wrong, text, "gravity torque")


def _turned(found: Diagnosis) -> Array | None:
    """Find the gravity under which compliant joints explain most, (3,); None if the stated one is nearly as good.

    Tilts of five and twenty degrees leave 24 and 4 % of a soft UR5e's squared residuals, seven other causes 94 % and
    more, four real arms 66 % and more.
    """
    robot = found.dataset.robot
    assert robot is not None
    size = float(np.linalg.norm(robot.gravity))
    columns, residuals = _columns(found, size)
    ends = (_descended(columns, residuals, start) for start in (*np.eye(3), *-np.eye(3)))
    direction, left = min(ends, key=lambda one: one[1])
    _, as_stated = _compliances(columns, residuals, np.array(robot.gravity) / size)
    return None if left**2 > EVEN * as_stated**2 else robot.other_gravity(direction)


def _columns(found: Diagnosis, size: float) -> tuple[Array, Array]:
    """Derivatives by the joints' compliances under gravity along x, y and z, (3, j, m k), and residuals, (m k,).

    The part of both that the sensor's parameters explain is removed.
    """
    robot = found.observed.arm[0]
    given = []
    for along in np.eye(3):
        under = replace(found.observed, robot=robot.under(size * along))
        effects = tuple(CandidateEffect(JointCompliance, joint) for joint in JointCompliance.locations(under))
        model = Model(under, effects)
        start = dict(zip(found.model.parameters.names, found.calibrated_x.tolist(), strict=False))
        x = np.array([start.get(item.name, item.nominal) for item in model.parameters.items])
        J = jacobian_matrix(model, x)
        names = list(model.parameters.names)
        given.append(J[:, [names.index(one.key("compliance")) for one in effects]].T)
        own = J[
            :, [names.index(name) for name in model.blocks.free + model.blocks.derived if name not in model.blocks.held]
        ]
        residuals = model.residuals(x[None])[0].reshape(-1)
    basis, _ = np.linalg.qr(own / np.maximum(np.linalg.norm(own, axis=0), np.finfo(float).tiny))
    left = np.concatenate([*given, residuals[None]])
    short = np.linalg.qr((left - left @ basis @ basis.T).T).R.T  # of the same lengths and angles
    return short[:-1].reshape(3, -1, len(short)), short[-1]


def _descended(columns: Array, residuals: Array, direction: Array) -> tuple[Array, float]:
    """Refine a direction (3,) for the least residual with nonnegative compliances; and the norm of that residual."""
    left = np.inf
    for _ in range(MOST_STEPS):
        before = left
        compliances, left = _compliances(columns, residuals, direction)
        if not compliances.any() or before - left < SHARE * left:
            break
        pull = np.linalg.lstsq(np.einsum("j,kjm->mk", compliances, columns), -residuals, rcond=None)[0]
        direction = pull / max(np.linalg.norm(pull), np.finfo(float).tiny)
    return direction, left


def _compliances(columns: Array, residuals: Array, direction: Array) -> tuple[Array, float]:
    """Nonnegative compliances, (j,), with the least residual under gravity along a direction, and its norm."""
    from scipy.optimize import nnls  # noqa: PLC0415 - the import takes a tenth of a second, and few diagnoses need it

    compliances, left = nnls(np.einsum("k,kjm->mj", direction, columns), -residuals)
    return compliances, float(left)


def _vector(gravity: Array) -> str:
    return f"[{', '.join(f'{value + 0.0:.3g}' for value in gravity)}]"
