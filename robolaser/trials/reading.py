"""What a cell's points look like in a data set, without chance and with it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.trials.building import BlankTrial
from robolaser.trials.synthetic.cell import TrackerCell
from robolaser.trials.synthetic.fault_model import FaultModel


def exact(built: BlankTrial, faults: Sequence[FaultModel]) -> Dataset:
    """One row a point, without noise."""
    seen, pose = built.cell.seen(faults), built.cell.pose
    if isinstance(built.cell, TrackerCell):
        names = tuple(built.cell.reflectors) * len(built.cell.run.q)
        return replace(built.blank, points=Points(pose=pose, names=names, xyz=seen.xyz))
    return replace(built.blank, points=Points(pose=pose, names=_numbered(pose), pixel=seen.pixel, xyz=seen.xyz))


def read(built: BlankTrial, faults: Sequence[FaultModel], rng: np.random.Generator) -> Dataset:
    """All shots of the arm as it repeats, with its small errors, noise and gross errors."""
    scatter = [] if built.scatter is None else [built.scatter]
    dataset = exact(built, [*scatter, *built.background, *faults])
    points, noise, m = dataset.points, built.noise, len(dataset.points)
    if points.pixel is None:
        measured = points["xyz"] + (noise.point_m or 0.0) * _farther(built, points)[:, None] * rng.normal(size=(m, 3))
        return replace(dataset, points=replace(points, xyz=measured))
    drawn = points["xyz"] + (noise.target_m or 0.0) * rng.normal(size=(m, 3))
    shots = replace(points, xyz=drawn).take(np.repeat(np.arange(m), built.repeats))
    shot, repeat = np.repeat(np.arange(m), built.repeats), np.tile(np.arange(built.repeats), m)
    sigma = (noise.pixel_px or 0.0) * _farther(built, points)[shot, None]
    pixel = shots["pixel"] + sigma * rng.normal(size=shots["pixel"].shape)
    if built.image_px:
        pixel = pixel + _of_images(built, rng)[points.pose[shot], repeat]
    for fault in faults:
        pixel = fault.shots(pixel, shot, rng)
    shots = replace(shots, pixel=pixel, repeat=repeat)
    return replace(dataset, points=shots.take(_shown(dataset, shots)))


def _farther(built: BlankTrial, points: Points) -> Array:
    """How much larger the noise of each point is than usual, (m,): its mean square is one."""
    cell = built.cell
    if isinstance(cell, TrackerCell):
        away = points["xyz"]
    else:
        T_base_camera = cell.run.arm.forward(cell.run.q) @ cell.eye.mount
        away = points["xyz"] - T_base_camera[points.pose, :3, 3]
    factor = np.linalg.norm(away, axis=1) ** built.growth
    larger: Array = factor / np.sqrt(np.nanmean(np.square(factor)))
    return larger


def _of_images(built: BlankTrial, rng: np.random.Generator) -> Array:
    """By how much each image is off as a whole, (n, repeats, 2) [px]."""
    return built.image_px * rng.normal(size=(len(built.cell.run.q), built.repeats, 2))


def _numbered(pose: Ints) -> tuple[str, ...]:
    """0, 1, 2 within each pose."""
    number: dict[int, int] = {}
    names = []
    for i in pose.tolist():
        number[i] = number.get(i, -1) + 1
        names.append(str(number[i]))
    return tuple(names)


def _shown(dataset: Dataset, points: Points) -> Bools:
    """Rows whose pixel is in the image."""
    assert dataset.image_px is not None
    with np.errstate(invalid="ignore"):
        shown = (points["pixel"] >= -0.5) & (points["pixel"] <= np.array(dataset.image_px) - 0.5)
    return np.asarray(shown.all(axis=1))
