"""Torques that do not mean what the log says: of the opposite sign, or under another gravity than stated."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.misread import BEST, FALLS
from robolaser.motion.cut_off import cut_rows, cuts
from robolaser.motion.effect import JOINTS, At, MotionEffect, Number
from robolaser.motion.effects.dynamics import TORQUE_CONSTANT
from robolaser.motion.evidence import Fitted
from robolaser.motion.gap import root_mean_squares
from robolaser.motion.kind_diagnosis import EVEN, KindDiagnosis
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import Quantities, quantities
from robolaser.motion.selection import Estimate, SelectedEffect

MISREAD = 0.99
"""Probability of a reading that fits as much better than the log as it is, and than any other, as `FALLS` and `BEST` of
poses that are misread ask. A judgement."""
NEAR_AXIS = np.cos(np.radians(2.0))
"""Within two degrees of an axis of the base, gravity is taken to be along it: bases are mounted so. A judgement."""
SAME_SIZE = 0.1
"""Share by which gravity that is found may differ from the stated one in size: what differs by more are masses. A
judgement."""
ROUNDS = 10  # of gravity by the weights of joints, and of these by it
OPPOSITE = replace(
    TORQUE_CONSTANT, form="opposite", clause="torques have the wrong sign: read as their opposites they fit",
    remedy="Correct the sign of the torques, or the joint's axis in the URDF.",
)  # fmt: skip


@final
@dataclass(frozen=True, eq=False)
class MisreadTorques:
    """A log whose torques are read otherwise, as they seem to be meant."""

    log: MotionLog
    ats: tuple[At, ...]  # what is misread, and where
    numbers: dict[str, Estimate]
    left: Array  # of each joint's torques, beside friction and a scale, (j,) [Nm]
    probability: float = MISREAD
    rivals: tuple[At, ...] = ()

    def restated(self, part: KindDiagnosis, as_read: MotionLog) -> KindDiagnosis:
        """Torques that are read otherwise, with the errors of the log as it is, and their reading for what is found."""
        of = quantities(as_read, "torque")
        before = of.measured - of.rigid
        size = root_mean_squares(before)
        gained = np.nan_to_num(np.maximum(size**2 - part.gap.after**2, 0.0))
        without = Fitted((), (), (), np.inf, gained)
        sure, none = self.probability, 1.0 - self.probability
        found = tuple(
            SelectedEffect(at, sure, none, without, self.rivals, self._beside(part.findings, at), gained)
            for at in self.ats
        )
        gap = replace(part.gap, nominal=size, calibrated=size)
        return replace(part, gap=gap, before=before, findings=found)

    def _beside(self, findings: Sequence[SelectedEffect], at: At) -> dict[str, Estimate]:
        """Its numbers; a scale of torques that have the wrong sign, too, is one number with it."""
        scale = next((one.numbers["factor"] for one in findings if one.at.pair == at.pair), None)
        return {"factor": (-2.0 - scale[0], *scale[1:])} if scale else self.numbers


def misread(log: MotionLog) -> MisreadTorques | None:
    """How torques seem to be meant; None where that is as they are read, or where nothing explains them.

    Each joint's are held against the rigid arm's, beside friction: of either sign, and under any gravity.
    """
    of = quantities(log, "torque")
    if of.lacking:
        return None
    of = replace(of, measured=np.where(cut_rows(of, cuts(of)), np.nan, of.measured))
    as_read = _left(of)
    ways = [
        way
        for way in (*_opposite(of, as_read), *_under_other_gravity(of))
        if (FALLS * way.left <= as_read).any() and (way.left <= BEST * as_read).all()
    ]
    ways.sort(key=lambda way: float(np.log(way.left).sum()))
    if len(ways) < 2:
        return ways[0] if ways else None
    best, other = ways
    falls = FALLS * best.left <= as_read
    if np.log(other.left / best.left)[falls].mean() > np.log(BEST):
        return best
    return replace(best, probability=EVEN, rivals=other.ats)


def _left(of: Quantities) -> Array:
    """What friction and a scale that is not negative leave of the torques of each joint, (j,) [Nm]."""
    left = np.ones(of.q.shape[1])
    for joint in range(len(left)):
        torques = _beside_friction(of, joint, np.stack([of.measured[:, joint], of.rigid[:, joint]], axis=1))
        if len(torques):
            read, rigid = torques.T
            scale = max(0.0, float(rigid @ read) / max(float(rigid @ rigid), np.finfo(float).tiny))
            left[joint] = root_mean_squares(read - scale * rigid)
    return np.maximum(left, np.finfo(float).eps)


def _beside_friction(of: Quantities, joint: int, columns: Array) -> Array:
    """Columns (n, k) at the rows that have a torque, less what friction explains of them."""
    there = np.isfinite(of.measured[:, joint])
    direction = of.direction[there, joint]
    friction = np.stack([direction, of.speed[there, joint]], axis=1)
    return np.asarray(columns[there] - friction @ np.linalg.lstsq(friction, columns[there])[0])


def _opposite(of: Quantities, as_read: Array) -> Iterator[MisreadTorques]:
    """With the other sign at joints where that fits; at all where it does wherever torques say anything of it."""
    turned = _left(replace(of, measured=-of.measured))
    wrong, right = FALLS * turned <= as_read, FALLS * as_read <= turned
    if not wrong.any():
        return
    where = [At(OPPOSITE, of.log.joints[j], j) for j in np.flatnonzero(wrong).tolist()]
    if wrong.sum() > 1 and not right.any():
        where, wrong = [At(replace(OPPOSITE, site=JOINTS), JOINTS, where[0].joint)], np.ones_like(wrong)
    log = replace(of.log, tau=np.where(wrong, -of.log.tau, of.log.tau))
    yield MisreadTorques(log, tuple(where), {"factor": (-2.0, np.nan, "")}, np.where(wrong, turned, as_read))


def _under_other_gravity(of: Quantities) -> Iterator[MisreadTorques]:
    """Under the gravity that explains the torques of all joints best, where it is another one of the stated size."""
    robot, stated = of.log.robot, np.array(of.log.robot.gravity)
    size = float(np.linalg.norm(stated))
    pulls = np.stack([robot.under(along).gravity_torques(of.q) for along in np.eye(3)], axis=-1)
    rows = [
        _beside_friction(of, j, np.column_stack([pulls[:, j], of.measured[:, j] - of.rigid[:, j]]))
        for j in range(of.q.shape[1])
    ]
    rows = [each for each in rows if each.any()]
    change, left = np.zeros(3), [each[:, -1] for each in rows]
    for _ in range(ROUNDS if rows else 0):
        scale = [max(float(root_mean_squares(each)), np.finfo(float).eps) for each in left]
        whole = np.concatenate([each / s for each, s in zip(rows, scale, strict=True)])
        change = np.linalg.lstsq(whole[:, :3], whole[:, 3])[0]
        left = [each[:, 3] - each[:, :3] @ change for each in rows]
    found = float(np.linalg.norm(stated + change))
    if not abs(found - size) < SAME_SIZE * size:
        return
    along = (stated + change) / found
    axis = int(np.argmax(np.abs(along)))
    along = np.sign(along[axis]) * np.eye(3)[axis] if abs(along[axis]) > NEAR_AXIS else along
    if along @ stated > NEAR_AXIS * size:
        return
    log = replace(of.log, robot=robot.under(size * along))
    under = replace(quantities(log, "torque"), measured=of.measured)
    numbers = {axis: (float(value) + 0.0, np.nan, "m/s²") for axis, value in zip("xyz", size * along, strict=True)}
    was, now = (f"[{', '.join(f'{value + 0.0:.3g}' for value in one)}]" for one in (stated, size * along))
    effect = MotionEffect(
        name="gravity_direction", cause="base", rows="torque", site="base",
        clause=f"gravity in the base frame is stated as {was} m/s², but torques are as under {now} m/s²",
        numbers=tuple(Number(axis, "m/s²", size) for axis in "xyz"),
        remedy="Correct gravity under [robot] in dataset.toml.",
        reference="Siciliano et al. 2009, Robotics, ch. 7.2: gravity in the equations of motion",
    )  # fmt: skip
    yield MisreadTorques(log, (At(effect, "base", 0),), numbers, _left(under))
