"""All noise sources of a model's residuals: errors of its rows, of joint readings and of flange poses.

Poses are independent of each other; an error of a whole pose is shared by all its rows.
"""

from dataclasses import replace
from typing import Any, cast

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.duals import Dual
from robolaser.model.blocks.errors import moved_with_pose, row_errors
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

ROUNDING = 1e-9
"""[row's unit per rad] Turns that move no row by more than this move none: the rest is rounding, from which their size
would be estimated as thousands of radians."""


def error_sources(
    model: Model, x: Array, shots: Ints | None = None, *, shared: bool | None = None
) -> tuple[ErrorSource, ...]:
    """The sources of error of a model's residuals at x (d,), rows averaged over so many shots (m,); over 1 when absent.

    Where the model is of some rows only, `shared` says whether poses have several rows in all of them.

    - The sensor's errors of rows: `pixel`, `target`, `board`, `point`, `angle`, `seat`.
    - `joint` [rad], where joint angles were read: an independent error on each reading, carried through the chain,
      shared by the pose's rows. A linear axis has the same number in metres: equal at arm's length.
    - `probe` [m] and `probe_turn` [rad], shared by the pose's rows, where the sensor's error may be a motion of the
      whole pose: several points may come from one six-dimensional measurement. Of a pose with a single row, where the
      noise of rows is stated: else it would be that noise under another name.
    - `flange` [m] and `flange_turn` [rad], likewise, where flange poses were measured, and for other sensors where
      `joint_rad` is stated. Turns only where they move a row, not where a pose sees only the point that it turns about.

    So at the level of the pose there is always an unstated source, which the residuals can estimate.
    """
    dataset, blocks, at = model.dataset, model.blocks, model.at(x)
    rows = row_errors(blocks, *at)
    found = [*rows]
    of_pose = dataset.points.pose
    has_joints = dataset.robot is not None and dataset.poses.q is not None
    if has_joints:
        effect = _joint_effect(model, at[0], at[2])
        found.append(ErrorSource("joint", effect, of_pose, "rad", level="pose", stated=dataset.noise.reading_rad))
    if shared is None:
        shared = shared_by_rows(model)
    tracked = has_joints and any(block.sensor.format.tracker for block in blocks)
    whole = "probe" if tracked else "flange"
    is_apart = shared or all(source.stated is not None for source in rows)
    if is_apart and (tracked or not has_joints or dataset.noise.joint_rad is not None):
        shifts, turns = moved_with_pose(blocks, *at)
        found.append(ErrorSource(whole, shifts, of_pose, level="pose"))
        if (shared or dataset.format.angles) and np.abs(turns).max(initial=0.0) > ROUNDING:
            found.append(ErrorSource(f"{whole}_turn", turns, of_pose, "rad", level="pose"))
    return tuple(found if shots is None else (_averaged(source, shots) for source in found))


def shared_by_rows(model: Model) -> bool:
    """Whether some pose has several rows, which share its errors."""
    return bool(np.bincount(model.dataset.points.pose).max() > 1)


def _averaged(source: ErrorSource, shots: Ints) -> ErrorSource:
    """A source of independent errors of shots, for rows averaged over so many (m,); others unchanged."""
    if source.level != "shot" or shots.max(initial=1) == 1:
        return source
    return replace(source, effect=source.effect / np.sqrt(shots)[:, None, None])


def _joint_effect(model: Model, values: Values, perturb: Perturbation) -> Array:
    """Move of each row with each joint of the chain, (m, k, j); loads are kept at the angles read."""
    robot, q = model.dataset.arm
    slopes = np.broadcast_to(np.eye(q.shape[1])[list(robot.chain), None, None], (len(robot.chain), 1, *q.shape))
    moving = cast("Array", Dual(q[None], slopes, tuple(range(len(robot.chain)))))
    flange = model.flange(values, perturb, moving, only_seen=True)
    moved: Any = model.blocks.residuals(values, flange, perturb)
    return np.moveaxis(moved.slopes[:, 0], 0, -1)
