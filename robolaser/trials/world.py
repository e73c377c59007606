"""A blind world: a true cell, what chance adds to its readings, and the data set that these go into."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.trials.synthetic.cell import ScannerCell, TrackerCell
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joints import PoseScatter


@final
@dataclass(frozen=True)
class World:
    """A cell and all that is not ideal in it, beside its faults."""

    cell: ScannerCell | TrackerCell  # where everything truly is
    blank: Dataset  # the data set without points
    noise: Noise  # of the readings, stated or not
    repeats: int = 1  # images at each pose
    scatter: PoseScatter | None = None  # how well the arm repeats; None: exactly
    image_px: float = 0.0  # by how much an image is off as a whole, one standard deviation [px]
    growth: float = 0.0  # power of the range with which the noise of a pixel, or of a tracker's point, grows
    background: tuple[FaultModel, ...] = ()  # what is off a little, whatever else is wrong

    def exact(self, faults: Sequence[FaultModel]) -> Dataset:
        """One row a point, without noise."""
        return replace(self.blank, points=self.cell.seen(faults))

    def read(self, faults: Sequence[FaultModel], rng: np.random.Generator) -> Dataset:
        """All shots of the arm as it repeats, with its small errors, noise and gross errors."""
        scatter = [] if self.scatter is None else [self.scatter]
        points = self.cell.seen([*scatter, *self.background, *faults])
        noise, m = self.noise, len(points)
        farther = self.cell.ranges(points) ** self.growth
        farther = farther[:, None] / np.sqrt(np.nanmean(np.square(farther)))  # its mean square is one
        if points.pixel is None:
            xyz = points["xyz"] + (noise.point_m or 0.0) * farther * rng.normal(size=(m, 3))
            return replace(self.blank, points=replace(points, xyz=xyz))
        xyz = points["xyz"] + (noise.target_m or 0.0) * rng.normal(size=(m, 3))
        shot, repeat = np.repeat(np.arange(m), self.repeats), np.tile(np.arange(self.repeats), m)
        shots = replace(points, xyz=xyz).take(shot)
        pixel = shots["pixel"] + (noise.pixel_px or 0.0) * farther[shot] * rng.normal(size=(len(shot), 2))
        if self.image_px:
            of_image = self.image_px * rng.normal(size=(len(self.cell.run.q), self.repeats, 2))
            pixel = pixel + of_image[shots.pose, repeat]
        for fault in faults:
            pixel = fault.shots(pixel, shot, rng)
        return replace(self.blank, points=self._shown(replace(shots, pixel=pixel, repeat=repeat)))

    def _shown(self, points: Points) -> Points:
        """The rows whose pixel is in the image."""
        assert self.blank.image_px is not None  # the data set is a scanner's
        with np.errstate(invalid="ignore"):
            shown = (points["pixel"] >= -0.5) & (points["pixel"] <= np.array(self.blank.image_px) - 0.5)
        return points.take(np.asarray(shown.all(axis=1)))

    def sigmas(self, *, of_row: bool) -> dict[str, float]:
        """Standard deviations of the sources of noise, repeats averaged.

        Args:
            of_row: Count an image that is off as a whole as an error of its rows' mean.
        """
        shared = self.image_px
        if shared and of_row:
            shared *= float(np.sqrt(np.bincount(self.cell.seen(()).pose).max()))
        return {
            "pixel": float(np.hypot(self.noise.pixel_px or 0.0, shared) / np.sqrt(self.repeats)),
            "target": self.noise.target_m or 0.0,
            "point": self.noise.point_m or 0.0,
            "joint": 0.0 if self.scatter is None else self.scatter.sigma(self.cell.run),
        }


def rounded(value: float) -> float:
    """Three digits, as people state noise."""
    return float(f"{value:.3g}")
