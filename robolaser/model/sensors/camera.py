"""A camera that sees points of a target: on the flange with the target in the cell, or the other way round."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat
from robolaser.errors import DataError
from robolaser.geometry.board_views import INTRINSICS, camera_matrix, distortion
from robolaser.geometry.rigid_motion import carry, inverse
from robolaser.model.error_source import ErrorSource, errors_in_image
from robolaser.model.sensors.camera_projection import distort, on_plane, project, straighten, to_pixels
from robolaser.model.sensors.camera_start import CameraStart
from robolaser.model.sensors.in_cell import CameraView, InCell, Mounting, is_static
from robolaser.model.sensors.placements import motion, six_names
from robolaser.model.sensors.sensor import NewPoses, Perturbation, Sensor, SensorParameters, Stage, each_once
from robolaser.parameters import Values, from_batch

SENSOR_WIDTH_M = 4.8e-3
"""Width of an image sensor of 1/3", the commonest: converts pixels to metres for effects of the lens."""
MARGIN = 0.03  # of the image, left free around points that would be seen
SHARE_SEEN = 0.6  # of the target's points that a useful pose shows
OPTICAL = "camera_optical"
LENS_ROUNDS = 8  # of a fixed-point iteration that converges by a factor of ten or more each
UNIT = np.eye(4)[None, None]


@final
class CameraSensor(Sensor):
    """OpenCV's camera: pixels of a target's points."""

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="camera",
        title="camera",
        task="the model predicts points of the target",
        lens=("k2", "k3", "p1", "p2"),
        columns={"pixel": PIXEL, "xyz": XYZ},
        numbers=2,
        unit="px",
        tables=("image", "board"),
        required=("image",),
        options=Mounting,
        units=dict.fromkeys(("fx", "fy", "cx", "cy"), "px"),
        positive=("fx", "fy"),
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.MOUNT, Stage.PIXELS, Stage.IMAGE, Stage.TARGET}

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._rides = not is_static(dataset)
        if not self._rides and dataset.placed:
            raise DataError(
                "dataset.toml, [target] placed: the target of a camera that is fixed in the cell is on the flange, so"
                " that its points cannot be given in the base frame. Write placed = false, and give them in the"
                " target's own frame.",
                file="dataset.toml",
                column="[target] placed",
            )
        self._pixel, self._xyz = dataset.points["pixel"][None], dataset.points["xyz"][None]

    @property
    def image_px(self) -> tuple[int, int]:
        """Width and height of the images."""
        assert self.dataset.image_px is not None  # the format requires it
        return self.dataset.image_px

    @cached_property
    def parameters(self) -> SensorParameters:
        """The intrinsics, the hand-eye, and an unplaced target: all follow from the images."""
        things = ("hand_eye",) if self.dataset.placed else ("hand_eye", "target")
        derived = (*INTRINSICS, *(name for thing in things for name in six_names(thing)))
        return SensorParameters(derived=derived, spans=self._spans)

    @cached_property
    def _closed_form(self) -> CameraStart:
        return CameraStart(self.dataset, self.image_px, rides=self._rides)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Zhang's method for the intrinsics, Shah's for hand-eye and target; known values are kept."""
        derived, given = self.parameters.derived, self.dataset.parameters
        stated = {name: np.array([given[name].nominal]) for name in derived if name in given and given[name].fixed}
        found = self._closed_form.initialize({**stated, **values}, T_base_flange)
        return {name: found[name] for name in derived}

    def _spans(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Of the lens: as far as a lens can bend the image's corner."""
        width, height = self.image_px
        corner = float(np.hypot(width, height)) / 2.0 / values["fx"]
        lens = {f"k{n}": 0.5 / corner ** (2 * n) for n in (1, 2, 3)} | dict.fromkeys(("p1", "p2"), 0.1 / corner)
        pinhole = {"fx": values["fx"] / 2.0, "fy": values["fy"] / 2.0, "cx": width / 2.0, "cy": height / 2.0}
        return {**pinhole, **lens}

    def _hand_eye(self, values: Values, perturb: Perturbation) -> Array:
        """T_flange_camera or T_base_camera, (c, n or 1, 4, 4)."""
        placed = motion(values, "hand_eye")[:, None]
        return perturb(Stage.MOUNT, placed) if self._rides else placed

    def _target(self, values: Values, perturb: Perturbation) -> Array:
        """T_base_target or T_flange_target, (c or 1, n or 1, 4, 4)."""
        placed = UNIT if self.dataset.placed else motion(values, "target")[:, None]
        return placed if self._rides else perturb(Stage.MOUNT, placed)

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The target's points in the base frame, (c, m, 3) [m]."""
        target = self._target(values, perturb)
        T_base_target = target if self._rides else T_base_flange @ target
        return carry(T_base_target, self.dataset.points.pose, perturb(Stage.TARGET, self._xyz))

    def in_camera(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The target's points in the camera frame, (c, m, 3) [m]."""
        hand_eye = self._hand_eye(values, perturb)
        T_base_camera = T_base_flange @ hand_eye if self._rides else hand_eye
        known = self.known(values, T_base_flange, perturb)
        return carry(inverse(T_base_camera), self.dataset.points.pose, known)

    def _metres(self, values: Values) -> Array:
        """Scale of image points from unit focal length to the sensor, (c, 1, 1) [m]."""
        return values["fx"][:, None, None] * SENSOR_WIDTH_M / self.image_px[0]

    def _through_lens(self, straight: Array, values: Values, perturb: Perturbation) -> Array:
        if perturb.touches(Stage.IMAGE):
            metres = self._metres(values)
            straight = perturb(Stage.IMAGE, straight * metres) / metres
        return to_pixels(distort(straight, values), values)

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured pixel less the predicted one, (c, m, 2) [px]."""
        straight = on_plane(self.in_camera(values, T_base_flange, perturb))
        return perturb(Stage.PIXELS, self._pixel) - self._through_lens(straight, values, perturb)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`pixel` [px], each row's own; `target` [m], shared by the repeats of a point, where it is stated."""
        seen = self.in_camera(values, T_base_flange, perturb)
        return errors_in_image(self.dataset, lambda point: project(point, values), seen)

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Across the view at the target's distance, (c, m, 2) [m]."""
        depth = self.in_camera(values, T_base_flange, perturb)[..., 2:]
        return residuals * depth / np.stack([values["fx"], values["fy"]], axis=-1)[:, None]

    def _view(self, values: Values, perturb: Perturbation) -> CameraView:
        """One candidate, effects of the lens included."""
        perturb = perturb.of_lens
        one = {name: values[name] for name in INTRINSICS}
        metres = self._metres(one)

        def slopes(pixel: Array) -> Array:
            straight = straighten(pixel[None], one)
            if not perturb.touches(Stage.IMAGE):
                return np.asarray(straight[0])
            there = straight
            for _ in range(LENS_ROUNDS):  # the effect acts before the lens distorts
                there = there + straight - perturb(Stage.IMAGE, there * metres) / metres
            return np.asarray(there[0])

        numbers = from_batch(one)
        exact = None if perturb.touches(Stage.IMAGE) else distortion(numbers)
        return CameraView(camera_matrix(numbers), slopes, exact)

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """`camera_optical`, z along the view, x along image u; of a camera in the cell the `target` on the flange."""
        hand_eye, view = self._hand_eye(values, perturb), self._view(values, perturb)
        camera = {OPTICAL: hand_eye[0, 0]}
        if self._rides:
            return InCell(camera, published=camera, mount=hand_eye, camera=view)
        target = {"target": self._target(values, perturb)[0, 0]}
        return InCell(target, camera, published=camera, stand=hand_eye, camera=view)

    @property
    def new_poses(self) -> NewPoses:
        """Views of the whole target."""
        return NewPoses(self._seen_from)

    def _seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """Every point of the target once at each pose; good poses show most of them, from the side seen so far."""
        dataset, image_px, poses = self.dataset, np.array(self.image_px), len(T_base_flange)
        rows = each_once(dataset.points, poses)
        there = CameraSensor(replace(dataset, points=rows))
        pixel = rows["pixel"] - there.residuals(values, T_base_flange[None], Perturbation())[0]
        inside = np.abs(pixel - (image_px - 1.0) / 2.0) <= (0.5 - MARGIN) * image_px
        known, planned = self._sides(self, values, dataset.flange()), self._sides(there, values, T_base_flange)
        inside &= (planned == known[0])[:, None] | (known != known[0]).any()
        shown = inside.all(axis=1).reshape(poses, -1).mean(axis=1)
        return replace(rows, pixel=pixel), np.asarray(shown >= SHARE_SEEN)

    def _sides(self, sensor: "CameraSensor", values: Values, T_base_flange: Array) -> Array:
        """On which side of the target's plane the camera is at each row, (m,), 1 or -1."""
        points, nothing = self.dataset.points["xyz"], Perturbation()
        normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
        rows = sensor.dataset.points
        lifted = CameraSensor(replace(sensor.dataset, points=replace(rows, xyz=rows["xyz"] + normal)))
        here = sensor.in_camera(values, T_base_flange[None], nothing)[0]
        above = lifted.in_camera(values, T_base_flange[None], nothing)[0]
        return np.asarray(np.sign((here * (above - here)).sum(axis=1)))
