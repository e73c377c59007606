"""A source of measurement error, and its effect on each row per unit."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, cast, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.duals import Dual


@final
@dataclass(frozen=True)
class ErrorSource:
    """One source of measurement error: residuals are e = e₀ + Σ σ_i A_i ξ_i with independent standard normal ξ_i."""

    name: str  # such as `pixel`, `target`, `point`, `joint`, `flange`
    effect: Array  # A, the move of each row by each of q independent unit errors, (m, k, q) [row's unit per unit]
    group: Ints  # rows with one number share their q errors, (m,); a group never reaches beyond one pose
    unit: str = "m"  # of σ
    # whether every shot draws the error anew, all shots of a point share it, or all rows of a pose
    level: Literal["shot", "point", "pose"] = "shot"
    stated: float | None = None  # σ where the data set states it
    least: float = 0.0  # least estimate of σ,
    most: float = np.inf  # and largest

    @property
    def isotropic(self) -> bool:
        """Whether a unit error moves every row by a unit along each axis."""
        return self.effect.strides[0] == 0 and np.array_equal(self.effect[0], np.eye(self.effect.shape[1]))


def along_each_axis(rows: int, axes: int) -> Array:
    """The effect of errors that move each of a row's numbers by themselves, (rows, axes, axes); takes no memory."""
    return np.broadcast_to(np.eye(axes), (rows, axes, axes))


def errors_in_image(dataset: Dataset, image_of: Callable[[Array], Array], seen: Array) -> list[ErrorSource]:
    """`pixel` [px], each row's own; `target` [m], shared by the repeats of a point, where it is stated.

    Args:
        dataset: Whose rows are target points in images.
        image_of: Pixels of points in the camera frame, (1, m, 3) [m] -> (1, m, 2) [px].
        seen: Where the target points are there, (1, m, 3) [m].
    """
    m, noise = len(dataset.points), dataset.noise
    sources = [ErrorSource("pixel", along_each_axis(m, 2), np.arange(m), "px", stated=noise.pixel_px)]
    if noise.target_m is not None:
        by_axis = np.broadcast_to(np.eye(3)[:, None, None], (3, *seen.shape))
        moved: Any = image_of(cast("Array", Dual(seen, by_axis, (0, 1, 2))))
        effect, place = -np.moveaxis(moved.slopes[:, 0], 0, -1), dataset.points.place
        sources.append(ErrorSource("target", effect, place, level="point", stated=noise.target_m))
    return sources
