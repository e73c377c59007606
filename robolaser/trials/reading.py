"""What a cell's points look like in a data set, without chance and with it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.trials.building import BlankTrial
from robolaser.trials.synthetic.fault_model import FaultModel


def exact(built: BlankTrial, faults: Sequence[FaultModel]) -> Dataset:
    """One row a point, without noise."""
    seen = built.cell.seen(faults)
    pose = built.cell.pose
    points = Points(pose=pose, names=_numbered(pose), pixel=seen.pixel, xyz=seen.xyz)
    return replace(built.blank, points=points)


def read(built: BlankTrial, faults: Sequence[FaultModel], rng: np.random.Generator) -> Dataset:
    """All shots, with noise and gross errors."""
    dataset = exact(built, faults)
    points = dataset.points
    noise, m = built.noise, len(points)
    drawn = points["xyz"] + (noise.target_m or 0.0) * rng.normal(size=(m, 3))
    shots = replace(points, xyz=drawn).take(np.repeat(np.arange(m), built.repeats))
    pixel = shots["pixel"] + (noise.pixel_px or 0.0) * rng.normal(size=shots["pixel"].shape)
    shot = np.repeat(np.arange(m), built.repeats)
    for fault in faults:
        pixel = fault.shots(pixel, shot, rng)
    shots = replace(shots, pixel=pixel, repeat=np.tile(np.arange(built.repeats), m))
    return replace(dataset, points=shots.take(_shown(dataset, shots)))


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
