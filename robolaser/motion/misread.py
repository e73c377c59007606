"""Misread torques: in another unit, of the opposite sign, or under another gravity than the log states."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.misread import BEST, FALLS, MISREAD
from robolaser.estimation.certainty import EVEN
from robolaser.motion.cut_off import cut_rows, cuts
from robolaser.motion.effect import JOINTS, At, MotionEffect, Number
from robolaser.motion.effects.dynamics import TORQUE_CONSTANT
from robolaser.motion.evidence import Fitted, names_of
from robolaser.motion.gap import root_mean_squares
from robolaser.motion.kind_diagnosis import KindDiagnosis
from robolaser.motion.log import OTHER_UNIT, MotionLog
from robolaser.motion.quantities import Quantities, quantities
from robolaser.motion.selection import Estimate, SelectedEffect

SAME_SIZE = 0.1
"""Share by which the estimated gravity may differ from the stated one in size: a larger difference is one of masses. A
judgement."""
ROUNDS = 10  # that alternate between common numbers and weights of joints
OPPOSITE = replace(
    TORQUE_CONSTANT, form="opposite", clause="torques have the wrong sign: read as their opposites they fit",
    remedy="Correct the sign of the torques, or the joint's axis in the URDF.",
)  # fmt: skip
AGAINST = replace(
    OPPOSITE, name="joint_direction", form="", cause="servo", clause="the joint turns the other way than in the URDF",
    remedy="Turn the joint's axis round in the URDF, or the signs of its angles and torques in the log.",
)  # fmt: skip
PER_NM = {"mNm": 1000.0, "Ncm": 100.0}  # units in which servos give torques, per Newton metre


@final
@dataclass(frozen=True, eq=False)
class MisreadTorques:
    """A reading of torques that may be the intended one."""

    factor: Array  # on each joint's torques, (j,)
    side: Array  # sign of each joint's angles, (j,): -1 where it turns against its axis
    gravity: Array  # in the base frame, (3,) [m/s²]
    read: tuple[tuple[At, dict[str, Estimate]], ...]  # the misreadings, each with its numbers
    left: Array  # residuals of each joint's torques after friction and a scale, (j,) [Nm]
    before: Array = field(default_factory=lambda: np.empty(0))  # as recorded, less the rigid arm's, (n, j) [Nm]
    doubted: frozenset[str] = frozenset()  # misreadings that another reading does without
    rivals: tuple[At, ...] = ()  # the misreadings that it has instead

    @property
    def names(self) -> frozenset[str]:
        """Names of the misreadings."""
        return names_of(at for at, _ in self.read)

    def of(self, log: MotionLog) -> MotionLog:
        """The log with its torques read so."""
        turned = {name: self.side * getattr(log, name) for name in ("command", "q", "qd", "load")}
        return replace(log, tau=self.factor * log.tau, robot=log.robot.under(self.gravity), **turned)

    def restated(self, part: KindDiagnosis) -> KindDiagnosis:
        """A diagnosis with the errors of the log as recorded, and the misreadings as its findings."""
        size = root_mean_squares(self.before)
        gained = np.nan_to_num(np.maximum(size**2 - part.gap.after**2, 0.0))
        without = Fitted((), (), (), np.inf, gained)
        found = []
        for at, numbers in self.read:
            sure, rivals = (EVEN, self.rivals) if str(at) in self.doubted else (MISREAD, ())
            estimates = _with_scale(numbers, part.findings, at)
            found.append(SelectedEffect(at, sure, 1.0 - sure, without, rivals, estimates, gained))
        gap = replace(part.gap, nominal=size, calibrated=size)
        return replace(part, gap=gap, before=self.before, findings=tuple(found))


def _with_scale(numbers: dict[str, Estimate], findings: Sequence[SelectedEffect], at: At) -> dict[str, Estimate]:
    """Numbers of a misreading, whose factor includes the scale found for the same torques."""
    scale = next((one.numbers["factor"] for one in findings if one.at.pair == at.pair), None)
    times = 1.0 + numbers["factor"][0] if "factor" in numbers else 1.0
    return {"factor": (times * (1.0 + scale[0]) - 1.0, abs(times) * scale[1], "")} if scale else numbers


def misread(log: MotionLog) -> MisreadTorques | None:
    """The most likely reading of torques; None where that is the log's, or where no reading explains them.

    Each joint's torques, with friction, are compared with the rigid arm's: of either sign, under any gravity.
    """
    of = quantities(log.as_read, "torque")
    if of.lacking:
        return None
    before = of.measured - of.rigid
    of = replace(of, measured=np.where(cut_rows(of, cuts(of)), np.nan, of.measured))
    unit = _unit(of)
    size = PER_NM.get(unit, 1.0)
    of = _times(of, 1.0 / size)
    loaded = _loaded(of)
    as_read = np.minimum(_left(of), _left(loaded))
    ways = _fitting(_ways(of, loaded), as_read)
    if not ways and (FALLS * as_read > root_mean_squares(of.measured)).any():
        ways = _fitting(_against(of), as_read)  # last: most joints do not show which way they turn
    ways.sort(key=lambda way: float(np.log(way.left).sum() + len(way.read) * np.log(BEST)))  # each has to be worth it
    if unit:
        effect = replace(
            TORQUE_CONSTANT, form=unit, site=JOINTS, clause=f"torques are in {unit}, not in Nm: read so they fit",
            remedy=f"Divide the torques by {size:.4g}.",
        )  # fmt: skip
        read = ((At(effect, JOINTS, 0), {"factor": (size - 1.0, np.nan, "")}),)
        own = np.ones(of.q.shape[1])
        ways = ways or [MisreadTorques(own, own, np.array(log.robot.gravity), (), as_read)]
        ways = [replace(way, factor=way.factor / size, read=(*read, *way.read)) for way in ways]
    if not ways:
        return None
    best, falls = replace(ways[0], before=before), FALLS * ways[0].left <= as_read
    near = (way for way in ways if not best.names <= way.names and not (way.left > BEST * best.left)[falls].any())
    if other := next(near, None):
        rivals = tuple(at for at, _ in other.read if str(at) not in best.names)
        best = replace(best, doubted=best.names - other.names, rivals=rivals)
    return best


def _fitting(ways: Iterable[MisreadTorques], as_read: Array) -> list[MisreadTorques]:
    """Readings that fit some joint far better than the log's, and none far worse."""
    return [way for way in ways if (FALLS * way.left <= as_read).any() and (way.left <= BEST * as_read).all()]


def follows_rigid_arm(of: Quantities) -> float:
    """Factor of torques to the rigid arm's, friction apart; 1 where these do not explain most of them."""
    pairs = [_less_friction(of, j, np.stack([of.measured[:, j], of.rigid[:, j]], axis=1)) for j in range(of.q.shape[1])]
    read, rigid = np.concatenate(pairs).T
    both, squares = float(read @ rigid), float(rigid @ rigid)
    return both / squares if both**2 > EVEN * squares * float(read @ read) > 0.0 else 1.0


def _times(of: Quantities, factor: Array | float) -> Quantities:
    return replace(of, measured=factor * of.measured)


def _unit(of: Quantities) -> str:
    """The unit of the torques, if it is not Nm and explains all but a payload's share; else ""."""
    if 1.0 / OTHER_UNIT < abs(follows_rigid_arm(of)) < OTHER_UNIT:
        return ""
    left = {}
    for name, size in PER_NM.items():
        within = _times(of, 1.0 / size)
        _, rest = _common(within, of.payload())
        torques = np.maximum(root_mean_squares(within.measured), 1e-12)
        left[name] = float(np.nanmedian(root_mean_squares(rest) / torques))
    best = min(left, key=left.__getitem__)
    return best if FALLS * left[best] < 1.0 else ""


def _ways(of: Quantities, loaded: Quantities) -> Iterator[MisreadTorques]:
    """Possible readings: other signs, without and with a payload, other gravity, and both."""
    stated, same = np.array(of.log.robot.gravity), np.ones(of.q.shape[1])
    for seen in (of, loaded):
        signs = _signs(seen)
        if (signs < 0.0).any():
            yield _way(seen, signs, same, stated)
    pulls = np.stack([of.log.robot.under(along).gravity_torques(of.q) for along in np.eye(3)], axis=-1)
    one_wrong = [same, *(1.0 - 2.0 * np.eye(len(same)))]
    for begun in (*one_wrong, *(-each for each in one_wrong)):
        gravity = _other_gravity(_times(of, begun), pulls)
        if gravity is not None:
            under = replace(of, rigid=of.rigid + pulls @ (gravity - stated))
            for signs in np.unique([begun, begun * _signs(_times(under, begun))], axis=0):
                yield _way(under, signs, same, gravity)


def _against(of: Quantities) -> Iterator[MisreadTorques]:
    """Readings with joints that turn the other way."""
    for side in 1.0 - 2.0 * np.eye(of.q.shape[1]):
        turned = quantities(replace(of.log, q=side * of.log.q, load=side * of.log.load), "torque")
        turned = _loaded(replace(turned, measured=of.measured))
        yield _way(turned, _signs(turned), side, np.array(of.log.robot.gravity))


def _loaded(of: Quantities) -> Quantities:
    """Quantities with a payload if torques show one; not its centre, which a joint of the wrong sign would falsify."""
    mass = of.payload()[..., :1]
    return replace(of, rigid=of.rigid + mass @ _common(of, mass)[0])


def _way(of: Quantities, signs: Array, side: Array, gravity: Array) -> MisreadTorques:
    names = of.log.joints
    read: list[tuple[At, dict[str, Estimate]]] = [
        (At(AGAINST, names[j], j), {"factor": (-2.0, np.nan, "")}) for j in np.flatnonzero(side < 0.0).tolist()
    ]
    # reversing an axis reverses the sign of its torque
    where = [At(OPPOSITE, names[j], j) for j in np.flatnonzero(signs * side < 0.0).tolist()]
    where = [At(replace(OPPOSITE, site=JOINTS), JOINTS, 0)] if len(where) == len(names) else where
    read += [(at, {"factor": (-2.0, np.nan, "")}) for at in where]
    stated = np.array(of.log.robot.gravity)
    if not np.array_equal(gravity, stated):
        was, now = (f"[{', '.join(f'{value + 0.0:.3g}' for value in one)}]" for one in (stated, gravity))
        effect = MotionEffect(
            name="gravity_direction", cause="base", rows="torque", site="base",
            clause=f"gravity in the base frame is stated as {was} m/s², but torques are as under {now} m/s²",
            numbers=tuple(Number(axis, "m/s²", float(np.linalg.norm(stated))) for axis in "xyz"),
            remedy="Correct gravity under [robot] in dataset.toml.",
            reference="Siciliano et al. 2009, Robotics, ch. 7.2: gravity in the equations of motion",
        )  # fmt: skip
        numbers = {axis: (float(value) + 0.0, np.nan, "m/s²") for axis, value in zip("xyz", gravity, strict=True)}
        read.append((At(effect, "base", 0), numbers))
    return MisreadTorques(signs, side, gravity, tuple(read), _left(_times(of, signs)))


def _left(of: Quantities) -> Array:
    """Residuals of each joint's torques after friction and a scale that is not negative, (j,) [Nm]."""
    left = np.ones(of.q.shape[1])
    for joint in range(len(left)):
        torques = _less_friction(of, joint, np.stack([of.measured[:, joint], of.rigid[:, joint]], axis=1))
        if len(torques):
            read, rigid = torques.T
            scale = max(0.0, float(rigid @ read) / max(float(rigid @ rigid), np.finfo(float).tiny))
            left[joint] = root_mean_squares(read - scale * rigid)
    return np.maximum(left, np.finfo(float).eps)


def _less_friction(of: Quantities, joint: int, columns: Array) -> Array:
    """Columns (n, k) at the rows that have a torque, less their fit by friction."""
    there = np.isfinite(of.measured[:, joint])
    direction = of.direction[there, joint]
    friction = np.stack([direction, of.speed[there, joint]], axis=1)
    return np.asarray(columns[there] - friction @ np.linalg.lstsq(friction, columns[there])[0])


def _signs(of: Quantities) -> Array:
    """Signs of each joint's torques, (j,): -1 where the opposite fits; at all joints if it fits all known ones."""
    as_read, turned = _left(of), _left(_times(of, -1.0))
    wrong, right = FALLS * turned <= as_read, FALLS * as_read <= turned
    return np.where(wrong | (wrong.sum() > 1 and not right.any()), -1.0, 1.0)


def _common(of: Quantities, columns: Array) -> tuple[Array, Array]:
    """Numbers of columns (n, j, k) by which torques differ from the rigid arm's, (k,), and residuals, (n, j).

    Friction apart; joints that fit badly count little.
    """
    there = np.isfinite(of.measured)
    short = of.measured - of.rigid
    rows = [_less_friction(of, j, np.column_stack([columns[:, j], short[:, j]])) for j in range(of.q.shape[1])]
    change, left = np.zeros(columns.shape[2]), [each[:, -1] for each in rows]
    for _ in range(ROUNDS if any(each.any() for each in rows) else 0):
        scale = [max(float(np.nan_to_num(root_mean_squares(each))), np.finfo(float).eps) for each in left]
        whole = np.concatenate([each / s for each, s in zip(rows, scale, strict=True) if each.any()])
        change = np.linalg.lstsq(whole[:, :-1], whole[:, -1])[0]
        left = [each[:, -1] - each[:, :-1] @ change for each in rows]
    out = np.full(of.measured.shape, np.nan)
    for j, each in enumerate(left):
        out[there[:, j], j] = each
    return change, out


def _other_gravity(of: Quantities, pulls: Array) -> Array | None:
    """The gravity that explains the torques of all joints best, if it is another one of the stated size, (3,).

    By the torques of gravity along each axis, (n, j, 3).
    """
    stated = np.array(of.log.robot.gravity)
    size = float(np.linalg.norm(stated))
    meant = stated + _common(of, pulls)[0]
    found = float(np.linalg.norm(meant))
    if not abs(found - size) < SAME_SIZE * size:
        return None
    return of.log.robot.other_gravity(meant)
