"""Where a gap may lie: at each site, what a departure of any smooth form there would do to the residuals."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.gaussian_process_basis import OfPoses, smooth
from robolaser.diagnosis.penalized_fit import Fit
from robolaser.diagnosis.stage_derivatives import StageDerivatives
from robolaser.model.effects.joints import moving_joints

DENT, DENTS = 0.08, 80
"""Size of dents in a target, as a share of its extent, and how many shapes tell where they are."""
BENT_PX = 0.1
"""A lens is not bent by more than about this beyond the model's distortion, as a standard deviation over the image."""
LEVER_M = 0.3
"""A turn counts as the shift that it makes at this distance."""
MISPLACED_M = 0.02
"""Links are not made worse: together, placements could shrink a robot to a point, which fits every socket."""


@final
@dataclass(frozen=True)
class Site:
    """A place, a coordinate, and what smooth functions of that coordinate do there.

    Attributes:
        site: A joint's name, or one of `camera laser hand_eye target base timing image tool`.
        coordinate: For a person.
        columns: Whitened residuals by each shape of the function, (3m, p).
        unknown: Whether the function may be of a form that the library of effects does not have.
        most: Largest standard deviation of the function that is plausible, in its unit.
    """

    site: str
    coordinate: str
    columns: Array
    unknown: bool = True
    most: float = np.inf


def sites(fitted: Fit) -> Iterator[Site]:
    """Every site that the data set has, with every coordinate that it may depend on there."""
    model = fitted.problem.model
    dataset, scene = model.dataset, model.run
    probe, of_poses = StageDerivatives(fitted), OfPoses(dataset, scene)
    pose = dataset.points.pose

    def over_poses(columns: Array, shapes: Array) -> Array:
        """Each column times each shape of its row's pose, (3m, k p)."""
        rows = np.repeat(shapes[pose], 3, axis=0)
        return (columns[:, :, None] * rows[:, None]).reshape(len(columns), -1)

    motion = np.r_[np.ones(3), np.full(3, 1.0 / LEVER_M)]
    joints = moving_joints(dataset.robot)
    if joints:
        robot, qd = dataset.robot, dataset.poses.qd
        assert robot is not None
        free = {name: probe.joint(name) for name in joints}
        for name in joints:
            for coordinate, shapes in (
                *of_poses.joint(robot.joints.index(name), name),
                *of_poses.run(),
                *of_poses.posture(),
                *(of_poses.angle(robot.joints.index(other), other) for other in joints if other != name),
            ):
                yield Site(name, coordinate, over_poses(free[name], shapes))
            placement = probe.placement(name)
            yield Site(name, f"placement of {name}", placement * motion, unknown=False, most=MISPLACED_M)
            for coordinate, shapes in of_poses.run():
                yield Site(name, coordinate, over_poses(placement[:, :3], shapes))
        if qd is not None and np.abs(qd).max() > 0:
            speeds = [over_poses(free[name], qd[:, [robot.joints.index(name)]]) for name in joints]
            late = np.sum(speeds, axis=0)
            yield Site("timing", "velocity", late)
            for coordinate, shapes in of_poses.run():
                yield Site("timing", coordinate, over_poses(late, shapes))
    base = probe.base(dataset.flange()[:, :3, 3].mean(axis=0)) * motion
    for coordinate, shapes in of_poses.run():
        yield Site("base", coordinate, over_poses(base, shapes))
    carried = "hand_eye" if dataset.kind == "stripe" else "tool"
    held = probe.tool() * motion
    for coordinate, shapes in (*of_poses.run(), *of_poses.hanging()):
        yield Site(carried, coordinate, over_poses(held, shapes))
    yield from _of_rows(fitted, probe, of_poses)


def _of_rows(fitted: Fit, probe: StageDerivatives, of_poses: OfPoses) -> Iterator[Site]:
    """Sites whose departure differs from row to row of a pose."""
    model = fitted.problem.model
    dataset = model.dataset

    def over_rows(columns: Array, shapes: Array) -> Array:
        return (columns[:, :, None] * np.repeat(shapes, 3, axis=0)[:, None]).reshape(len(columns), -1)

    if dataset.kind == "stripe":
        pixel, xyz = dataset.points.pixel, dataset.points.xyz
        assert pixel is not None
        assert xyz is not None
        place = smooth(pixel)
        seen = probe.pixel()
        yield Site("camera", "image position", over_rows(seen, place), most=BENT_PX)
        sheet = probe.sheet()
        along = 0 if dataset.stripe_axis == "u" else 1
        across = seen[:, [1 - along]]
        yield Site("laser", "position along the stripe", over_rows(sheet, smooth(pixel[:, [along]])))
        yield Site("laser", "place on the sheet", over_rows(sheet, _over_sheet(probe.on_sheet())))
        if np.ptp(model.run.tilt) > 0:
            yield Site("laser", "tilt of the surface", over_rows(across, smooth(model.run.tilt[:, None])))
        for coordinate, shapes in of_poses.run():
            drift = np.concatenate(
                [shapes, shapes * _centred(pixel[:, along], dataset.points.pose, len(shapes))], axis=1
            )
            yield Site("laser", coordinate, over_rows(sheet, drift[dataset.points.pose]))
    if dataset.points.xyz is not None and dataset.kind == "stripe":
        given = probe.target()
        lift = given @ model.run.target.axes[:, 2:]
        yield Site("target", "place on the target", over_rows(given, smooth(dataset.points.xyz)))
        yield Site("target", "place on the target", over_rows(lift, smooth(dataset.points.xyz, DENT, most=DENTS)))


def _over_sheet(places: Array) -> Array:
    """Shapes of what a sheet can be off by, over places (m, 2) on it: turned, twisted, bulged, and anything smooth."""
    across, deep = np.moveaxis((places - places.mean(axis=0)) / np.maximum(np.ptp(places, axis=0) / 2, 1e-9), -1, 0)
    return np.column_stack([across, across * deep, across**2, smooth(places)])


def _centred(values: Array, pose: Ints, n: int) -> Array:
    """Mean of the rows' values in each pose, scaled to ±1, (n, 1)."""
    mean = np.bincount(pose, values, minlength=n) / np.maximum(np.bincount(pose, minlength=n), 1)
    scaled: Array = (2.0 * (mean - mean.min()) / max(float(np.ptp(mean)), 1e-12) - 1.0)[:, None]
    return scaled
