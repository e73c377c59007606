"""Gearboxes that deflect under the weight of the arm."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import CarryOver, Effect, Run, RunSummary, Stage, nonlinear, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.mechanism import ElasticJoint, MechanismPart
from robolaser.model.effects.requirements import masses

UNSEEN_RAD = 1e-12  # by which rounding may seem to move a joint: a spring for it would be too stiff to be simulated


def hardened(deflection: Array, reference: Array, hardening: Array) -> Array:
    """Deflections d (c, n, k) as d (1 - hardening |d| / max |d|); below zero they soften.

    Args:
        deflection: In proportion to the load, in k directions.
        reference: The same at the calibrated poses, (c, m, k), of which the largest counts.
        hardening: Of each candidate, (c,).
    """
    most = np.linalg.norm(reference, axis=2).max(axis=1)[:, None, None]
    share = np.linalg.norm(deflection, axis=2, keepdims=True) / np.where(most > 0.0, most, 1.0)
    less: Array = deflection * (1.0 - hardening[:, None, None] * share)
    return less


def with_hardening(carried: CarryOver, hardening: Array, unhardened: Effect) -> CarryOver:
    """A hardening effect in another run with another largest load."""
    if carried.effect is None or not hardening.any():
        return carried
    doubt = "its hardening is relative to the largest load of the poses, which differ from the calibrated ones"
    return replace(carried, doubt=doubt, alternatives=(unhardened,))


@final
@dataclass(frozen=True)
class JointCompliance(Effect):
    """A joint deflects behind its encoder under its torque: q' = q - d, d = compliance g + payload g1, hardened.

    g is the gravity torque at the angles read, from the URDF's masses and the stated payload. The true masses scale the
    estimate: a URDF that is 10 % too light makes it 10 % too large. g1 is the torque of one kilogram at the flange,
    where scanner and cables have masses that no URDF states: `payload` is their mass times the compliance. Gears
    stiffen as they wind up: d (1 - hardening |d| / max |d|); below zero they soften.
    """

    name = "joint_compliance"
    title = "elastic deflection under the gravity torque of the URDF's masses"
    clause = "{where} deflects under gravity"
    caveat = "scales with the URDF's masses: an arm 10 % heavier than stated makes it 10 % too large"
    remedy = "Reduce the payload, or correct the angle of {where} for its gravity torque."
    reference = (
        "Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 11; stiffness 1e4-5e4 Nm/rad at a shoulder, 10 at"
        " a hobby servo (ROBOTIS AX-12A: full torque of 1.5 Nm at 9° by its compliance slope)"
    )
    stage = Stage.JOINTS
    cause = "elasticity"
    needs = (masses,)
    depends_on_trajectory = True

    compliance: Array = parameter(unit="rad/Nm", bound=0.1, prior_scale=1e-4, lower=0.0)
    payload: Array = parameter(unit="kg rad/Nm", bound=0.5, prior_scale=1e-4, lower=0.0)
    hardening: Array = nonlinear(unit="", lower=-1.0, upper=1.0, nominal=0.0)

    def apply(self, q: Array, run: Run, /) -> Array:
        wound, reference = (self._wound(each)[:, :, None] for each in (run, run.reference))
        return add_to_joint(q, run, self.where, -hardened(wound, reference, self.hardening)[:, :, 0])

    def _wound(self, run: Run) -> Array:
        column = joint_column(run, self.where)
        g, of_one_kg = run.loads.gravity_torques[:, column], run.loads.torques_of_one_kg[:, column]
        return self.compliance[:, None] * g + self.payload[:, None] * of_one_kg

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        """A spring; none where the joint is unloaded, as one about the vertical."""
        column = joint_column(run, self.where)
        q = np.zeros((1, *run.q.shape))
        sunk = -self.apply(q, run)[0, :, column]
        spring = ElasticJoint(
            self.where, sunk, run.loads.gravity_torques[:, column], run.loads.torques_of_one_kg[:, column]
        )
        return (spring,) if np.abs(sunk).max() > UNSEEN_RAD else ()

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It acts as found, but the largest load of other poses differs."""
        carried, unhardened = super().carried_to(run, found_in), replace(self, hardening=np.zeros(1))
        return with_hardening(carried, self.hardening, unhardened)
