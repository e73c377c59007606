"""The placements of a calibrated arm written into a user's MJCF, whose bodies and base have frames of their own.

With all joints at zero, a calibration moves each link as a whole. The body of that link moves alike, wherever its frame
is on it: so what it carries stays in place on it, and the zero of its joint is corrected too.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.bounded_reading import ROBOT_BYTES
from robolaser.data.importers.robots.mjcf import compiled_mjcf, placement
from robolaser.errors import RobotError
from robolaser.export.into import OF_PLACEMENTS, Written
from robolaser.export.mjcf import placement_attributes
from robolaser.geometry.rigid_motion import exp_so3, inverse, nearest_rotation, pose
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf import markup

SAME_M, SAME_RAD = 2e-3, 0.01  # between axes in two files of one arm: 0.4 mm by rounding, 10 mm from UR10 to UR10e
PARALLEL: Final = 1e-3  # least eigenvalue of the hinges' summed projections, which is zero if all are parallel
UNMOVED: Final = 1e-9  # [m, rad] of a body whose text stays
ORIENTATIONS: Final = ("quat", "axisangle", "xyaxes", "zaxis", "euler")


@final
@dataclass(frozen=True, eq=False)
class _Chain:
    """The joints of an arm from base to flange, all at zero."""

    names: tuple[str, ...]
    slides: Bools  # (j,)
    at: Array  # a point on each axis, (j, 3) [m]
    along: Array  # unit axes, (j, 3)
    T: Array  # the links that they move, (j, 4, 4)
    T_carriers: Array  # the links that carry these, (j, 4, 4)

    @property
    def across(self) -> Array:
        """Projections across the hinges, (j, 3, 3); zero for slides, whose axes have no location."""
        planes: Array = np.eye(3) - self.along[:, :, None] * self.along[:, None]
        return planes * ~self.slides[:, None, None]


def placements_into_mjcf(
    path: Path, text: str, nominal: Robot, corrected: Robot, effects: Sequence[Mapping[str, Any]]
) -> Written:
    """Move the bodies of a user's MJCF as the calibration moves the links of the nominal arm.

    Joints are matched by name, or by their axes if the file has none of the names; the axes also show where the base
    is. Those of the copy are the calibrated arm's, even if the file had rounded them.

    Raises:
        RobotError: MuJoCo does not read the file; it is another arm; its hinges are all parallel; or bodies of the arm
            are in other files or in frames, or have several joints.
        DependencyMissing: MuJoCo is not installed.
    """
    root, arm = markup.read(text, path.name, ROBOT_BYTES), _of_robot(nominal)
    mine, base, onto = _matched(path.name, arm, _chains(path, arm))
    moved = base @ _of_robot(corrected).T @ inverse(arm.T) @ inverse(base) @ onto
    before = np.concatenate([np.eye(4)[None], moved[:-1]])
    placed = inverse(before @ mine.T_carriers) @ moved @ mine.T
    elements = _bodies(root, mine.names, path.name)
    for one in np.flatnonzero(np.abs(moved - before).max(axis=(1, 2)) > UNMOVED):
        kept = {key: value for key, value in elements[one].attrib.items() if key not in ORIENTATIONS}
        elements[one].attrib = kept | placement_attributes(placed[one])
    pairs = [(one["effect"], one["where"]) for one in effects]
    written = tuple(pair for pair in pairs if pair[0] in OF_PLACEMENTS and pair[1] in (*arm.names, "base"))
    renamed = ", ".join(f"{own} is {name}" for own, name in zip(mine.names, arm.names, strict=True) if own != name)
    remarks = [f"{path.name} has other names of joints, which were matched by their axes: {renamed}."]
    lacking = tuple(pair for pair in pairs if pair not in written)
    return Written(markup.with_changes(text, root), written, lacking, tuple(remarks) if renamed else ())


def _of_robot(robot: Robot) -> _Chain:
    arm = robot.by_pinocchio
    on = np.flatnonzero(arm.way)
    T = np.array(list(accumulate(arm.placements[on], np.matmul, initial=np.eye(4))))
    along = np.einsum("jab,jb->ja", T[1:, :3, :3], arm.axes[on])
    return _Chain(tuple(arm.moving[one] for one in on), arm.slides[on], T[1:, :3, 3], along, T[1:], T[:-1])


def _chains(path: Path, arm: _Chain) -> list[_Chain]:
    """All chains of such joints in a user's MJCF, one in a body; of the arm's names, if it has any of these."""
    model, mujoco = compiled_mjcf(path)
    kinds = np.where(arm.slides, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)
    state, names = mujoco.MjData(model), [model.joint(one).name for one in range(model.njnt)]
    state.qpos[model.jnt_qposadr[np.isin(model.jnt_type, kinds)]] = 0.0
    mujoco.mj_kinematics(model, state)
    X = pose(state.xmat.reshape(-1, 3, 3), state.xpos)
    shared, found, ways = set(names) & set(arm.names), list[_Chain](), list[list[int]]([[]])
    for body in range(1, model.nbody):
        own = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        ways.append([*ways[model.body_parentid[body]], *own])
        way = ways[body][-len(kinds) :]
        bodies, called = model.jnt_bodyid[way], tuple(names[one] for one in way)
        if not own or not np.array_equal(model.jnt_type[way], kinds) or (model.body_jntnum[bodies] > 1).any():
            continue
        if called == arm.names or not shared:
            carriers = X[model.body_parentid[bodies]]
            T = carriers @ placement(model.body_pos[bodies], model.body_quat[bodies])
            found.append(_Chain(called, arm.slides, state.xanchor[way], state.xaxis[way], T, carriers))
    if not found:
        has = f" It has {', '.join(sorted(shared))}." if shared else ""
        raise RobotError(
            f"{path.name} has no chain of joints like those of the arm: {', '.join(arm.names)}, each alone in its body,"
            f" and none between them.{has}"
        )
    return found


def _matched(source: str, arm: _Chain, chains: Sequence[_Chain]) -> tuple[_Chain, Array, Array]:
    """The chain with the arm's axes; the arm's base, (4, 4), and the motions onto its axes, (j, 4, 4), there."""
    spread = [np.linalg.eigvalsh(across)[0] for across in np.cumsum(arm.across, axis=0)]
    if spread[-1] < PARALLEL:
        raise RobotError(
            f"The hinges of the arm are all parallel, so that they do not show where its base is in {source}. For"
            " MuJoCo, the result has robot_corrected.xml."
        )
    fits = [_fitted(chain, arm) for chain in chains]
    misfits = [float(np.max([shift / SAME_M, turn / SAME_RAD])) for _, _, shift, turn in fits]
    best = int(np.argmin(misfits))
    if misfits[best] > 1.0:
        *_, shift, turn = _fitted(chains[best], arm, int(np.argmax(np.array(spread) >= PARALLEL)) + 1)
        one = int(np.argmax(np.clip(np.maximum(shift / SAME_M, turn / SAME_RAD), 0.0, 1.0)))  # the first that is off
        raise RobotError(
            f"{source}: with all joints at zero, the axis of {chains[best].names[one]} is {1e3 * shift[one]:.1f} mm and"
            f" {np.degrees(turn[one]):.2f}° off its place in the nominal arm. Is it another robot, or does it count its"
            " joints from other zeros or in other directions?"
        )
    if sum(misfit <= 1.0 for misfit in misfits) > 1:
        raise RobotError(
            f"{source} has several chains with the axes of the arm. Give the joints of the calibrated one their names"
            f" in the data set: {', '.join(arm.names)}."
        )
    return chains[best], *fits[best][:2]


def _fitted(mine: _Chain, arm: _Chain, count: int | None = None) -> tuple[Array, Array, Array, Array]:
    """An arm's base (4, 4) by its first axes, and the smallest motions of the user's axes onto its, (j, 4, 4).

    With their shifts (j,) [m] and turns (j,) [rad].
    """
    R, _ = nearest_rotation(mine.along[:count].T @ arm.along[:count])
    across, along, to = R @ arm.across @ R.T, arm.along @ R.T, arm.at @ R.T - mine.at
    way = np.linalg.solve(across[:count].sum(axis=0), -np.einsum("jab,jb->a", across[:count], to[:count]))
    shift, normal = np.einsum("jab,jb->ja", across, to + way), np.cross(mine.along, along)
    turn = np.arctan2(np.linalg.norm(normal, axis=1), (mine.along * along).sum(axis=1))
    turned = pose(exp_so3(normal / np.sinc(turn / np.pi)[:, None]), mine.at + shift)
    return pose(R, way), turned @ pose(np.eye(3), -mine.at), np.linalg.norm(shift, axis=1), turn


def _bodies(root: ET.Element, joints: Sequence[str], source: str) -> list[ET.Element]:
    """The elements of the bodies that these joints move."""
    carriers = {body: carrier for carrier in root.iter() for body in carrier.findall("body")}
    named = {joint.get("name"): body for body in carriers for joint in body.findall("joint")}
    for joint in joints:
        if joint not in named:
            raise RobotError(
                f"{source} has no <body> with a <joint name='{joint}'> in its own text. Name the file that it includes,"
                " and give each joint of the arm a name."
            )
        if carriers[named[joint]].tag not in ("body", "worldbody"):
            raise RobotError(
                f"{source}: the body of {joint} is in a <{carriers[named[joint]].tag}>, which robolaser does not"
                " change. Give its placement to the body itself."
            )
    return [named[joint] for joint in joints]
