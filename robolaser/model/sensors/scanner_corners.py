"""Corners of a board in the images of a stripe scanner: its camera with the scanner's parameters."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, SensorData
from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat
from robolaser.geometry.rigid_motion import carry, inverse
from robolaser.model.error_source import ErrorSource, errors_in_image
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.sensors.placements import six_names
from robolaser.model.sensors.scanner_start import camera_start, spans, target_by_corners
from robolaser.model.sensors.sensor import Perturbation, Sensor, SensorParameters, Stage, Values
from robolaser.model.sensors.stripe import Stripe, gauge

CAMERA = ("f", "s_u", "s_v", "u_0", "v_0", "k", "w", "phi", "psi", "t_x", "t_y", "t_z")


def scanner_of(sensors: Sequence[SensorData], camera: SensorData) -> Dataset | None:
    """The stripe scanner of a camera; None where there is none."""
    own = (one.data for one in sensors if one.data.kind == Stripe.format.kind and one.camera == camera.camera)
    return next(own, None)


def seen_by(scanner: Dataset, corners: Dataset) -> Dataset:
    """Corners seen by a scanner's camera: its axes and its bracket."""
    return replace(
        corners, stripe_axis=scanner.stripe_axis, bracket_quat=scanner.bracket_quat, angles=scanner.angles, options=None
    )


@final
class ScannerCorners(Sensor, registered=False):
    """Measured corners in a scanner's images less predicted ones: pixels with the distortion removed.

    So effects of the lens move corners and stripe alike. OpenCV's fx is f / s_u, its fy f / s_v, and its k1 to first
    order -k f².
    """

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="camera",
        title="camera",
        task="the camera places corners",
        columns={"pixel": PIXEL, "xyz": XYZ},
        numbers=2,
        unit="px",
        units=Stripe.format.units,
        positive=Stripe.format.positive,
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.MOUNT, Stage.PIXELS, Stage.IMAGE, Stage.TARGET}

    @cached_property
    def parameters(self) -> SensorParameters:
        """The scanner's camera parameters, whose gauge the scanner fixes; T_base_target of an unplaced target."""
        return SensorParameters(
            free=CAMERA,
            derived=() if self.dataset.placed else six_names("target"),
            fixed=gauge(self.dataset),
            closed_form="the board's corners",
            spans=partial(spans, image_px=self.dataset.image_px),
        )

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Known values, as from the scanner's stripe; else by the boards in the images.

        Missing free parameters by OpenCV's closed forms in the scanner's terms, with the target's placement.
        """
        if any(name not in values for name in CAMERA):
            return camera_start(self.dataset, values, T_base_flange[:1])
        if all(name in values for name in self.parameters.derived):
            return {name: values[name] for name in self.parameters.derived}
        return target_by_corners(self.dataset, values, T_base_flange)

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured less predicted, (c, m, 2) [px]; NaN behind the camera."""
        seen = scanner_geometry.in_image(self.dataset.points["pixel"][None], values, perturb)
        return seen / self._pitch(values) - self._pixels_of(self._in_camera(values, T_base_flange, perturb), values)

    def _in_camera(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The corners, in the camera frame, (c, m, 3) [m]."""
        T_camera_base = inverse(T_base_flange @ scanner_geometry.mount(self.dataset, values, perturb))
        return carry(T_camera_base, self.dataset.points.pose, self.known(values, T_base_flange, perturb))

    def _pixels_of(self, point: Array, values: Values) -> Array:
        """Points in the camera frame as pixels from the image's middle, without distortion, (c, m, 2) [px]."""
        x, y = point[..., 0], point[..., 1]
        across = np.stack([-y, x] if self.dataset.stripe_axis == "u" else [x, y], axis=-1)
        depth = np.where(point[..., 2] > 0.0, point[..., 2], np.nan)
        return across * (values["f"][:, None] / depth)[..., None] / self._pitch(values)

    @staticmethod
    def _pitch(values: Values) -> Array:
        return np.stack([values["s_u"], values["s_v"]], axis=-1)[:, None]

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The corners, in the base frame, (c or 1, m, 3) [m]."""
        return scanner_geometry.target(self.dataset, values, perturb)

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Across the view, at the corner's distance, (c, m, 2) [m]."""
        depth = self._in_camera(values, T_base_flange, perturb)[..., 2]
        return np.asarray(residuals * self._pitch(values) * (depth / values["f"][:, None])[..., None])

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`pixel` [px], each row's own; `target` [m], shared by the repeats of a point, where it is stated."""
        seen = self._in_camera(values, T_base_flange, perturb)
        return errors_in_image(self.dataset, lambda point: self._pixels_of(point, values), seen)

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """The scanner's camera; frames by name are the scanner's."""
        mount = scanner_geometry.mount(self.dataset, values, perturb)
        return InCell(mount=mount, camera=scanner_geometry.camera_view(values, perturb))
