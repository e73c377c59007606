"""Where a stripe would lie on the target at other poses."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.new_poses import NewPoses
from robolaser.model.sensors.placements import motion
from robolaser.parameters import Values

SEEN_ALONG = 5  # points of the stripe that stand for all of them


@final
class StripeNewPoses(NewPoses):
    """Poses are good where the stripe lies on the target and in the image."""

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """Some points along the stripe on the middle level of the target."""
        view, xyz = scanner_geometry.view_of(self._dataset, values), self._dataset.points["xyz"]
        T_base_target = np.eye(4) if self._dataset.placed else motion(values, "target")[0]
        T_target_camera = inverse(T_base_target) @ T_base_flange @ view.T_flange_camera
        level = float(np.median(xyz[:, 2]))
        lit = view.illuminated(T_target_camera, level, np.linspace(*view.stripe_range(), SEEN_ALONG)[None])
        pixel, shown = view.pixels(lit), apply(T_target_camera[:, None], lit)
        low, high = xyz.min(axis=0), xyz.max(axis=0)
        good = ((shown >= low) & (shown <= high))[..., :2].all(axis=(1, 2)) & view.contains(pixel).all(axis=1)
        poses = len(T_base_flange)
        points = Points(
            np.repeat(np.arange(poses), SEEN_ALONG),
            tuple(map(str, range(SEEN_ALONG))) * poses,
            pixel=pixel.reshape(-1, 2),
            xyz=shown.reshape(-1, 3),
        )
        return points, np.asarray(good)
