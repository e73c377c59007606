"""Joints that turn a little with another one: wrist gears, belts and cables that pass a joint."""

from dataclasses import dataclass
from itertools import product
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Run, Stage, nonlinear, parameter
from robolaser.model.effects.joints import add_to_joint, moving_joints
from robolaser.model.effects.mechanism import MechanismPart, MimicJoint
from robolaser.robot.kinematics import Robot
from robolaser.robot.reading import MOST_JOINTS

FARTHEST = 2  # joints between which gears and cables are led along
TURN = 2.0 * np.pi  # of the other joint, from where it reads zero
HOMES = (0.0, -2.0, 2.0, -5.0, 5.0)  # tried; a fit goes on from there


@final
@dataclass(frozen=True)
class JointCoupling(Effect):
    """The joint follows another one: q' = q + ratio (q_other - home).

    The drive of a wrist passes the joints before it: if a gear, belt or cable runs along another joint, that joint's
    motion turns this one too, unless the controller compensates it with the right ratio. `other` is the number of the
    other joint, counted from the base and from one, at most two joints away. `home` is its reading where the joints
    were homed: within a turn, so that it does not replace a wrong zero of the joint.
    """

    name = "joint_coupling"
    title = "the joint follows another one (wrist gears, cables)"
    clause = "{where} follows another joint"
    caveat = "the other joint, `other`, is counted from the base, beginning with one"
    remedy = "Check the coupling ratio of {where} in its controller, and belts and cables that pass the joint."
    reference = "Paul 1981, Robot Manipulators, on coupled wrists; Schröer 1993, Theory of kinematic modelling"
    stage = Stage.JOINTS
    cause = "transmission"

    ratio: Array = parameter(unit="", bound=0.05, prior_scale=5e-4)
    other: Array = nonlinear(unit="", lower=1.0, upper=float(MOST_JOINTS), nominal=1.0)
    home: Array = nonlinear(unit="rad", lower=-TURN, upper=TURN, nominal=0.0)

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """Every moving joint of an arm that has another one."""
        joints = moving_joints(robot)
        return joints if len(joints) > 1 else ()

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Each neighbour up to two joints away, and homes all over a turn."""
        joints = moving_joints(dataset.robot)
        own = joints.index(where)
        others = [i + 1.0 for i in range(len(joints)) if 0 < abs(i - own) <= FARTHEST]
        return np.array(list(product(others, HOMES)))

    @classmethod
    def usual_shape(cls, dataset: Dataset, where: str) -> dict[str, float]:
        """The first joint whose drive can pass this one."""
        return {"other": float(cls.grid(dataset, where)[0, 0])}

    def apply(self, q: Array, run: Run, /) -> Array:
        column = self._column(run)
        other = np.broadcast_to(q, (len(column), *q.shape[1:]))[np.arange(len(column)), :, column]
        return add_to_joint(q, run, self.where, self.ratio[:, None] * (other - self.home[:, None]))

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        other = run.robot.joints[self._column(run)[0]]
        ratio = float(self.ratio[0])
        return (MimicJoint(self.where, other, ratio, -ratio * float(self.home[0])),)

    def _column(self, run: Run) -> Ints:
        """The column of the other joint, (c,)."""
        chain = np.array(run.robot.chain)
        return np.asarray(chain[np.clip(np.rint(self.other).astype(np.int64), 1, len(chain)) - 1])
