"""A camera and a laser plane on the flange: a pixel of the stripe is a point in space."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.sensors.new_poses import NewPoses
from robolaser.model.sensors.placements import motion, six_names
from robolaser.model.sensors.scanner_start import laser_start, spans, target_by_stripe
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.sensor_parameters import SensorParameters, not_given
from robolaser.model.sensors.stripe_errors import board_errors, pixel_moves
from robolaser.model.sensors.stripe_similarity import StripeReduction
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
"""The paper's fourteen, in its order (eq. 15)."""

LASER = {"b", "theta"}
NO_START = (
    " Or give none: with the board's corners as a second sensor, as `robolaser extract --output` writes them, all start"
    " from closed forms."
)
SEEN_ALONG = 5  # points of the stripe that stand for all of them, at poses that are planned
LEAST_TARGET_M = 1e-5
"""No printed target is better, and rows from images of a board, whose residuals lie along their rays by the way they
are made, would else seem to know everything across them."""


@final
class Stripe(Sensor):
    """The laser scanner of the paper, eqs. 1-13, its target placed or not."""

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="stripe",
        title="laser stripe scanner",
        task="the scanner places points",
        columns={"pixel": PIXEL, "xyz": XYZ},
        tables=("scanner", "image", "board"),
        required=("image",),
        units={
            "f": "m", "s_u": "m/px", "s_v": "m/px", "u_0": "px", "v_0": "px", "k": "1/m²", "b": "m", "theta": "rad",
            "t_x": "m", "t_y": "m", "t_z": "m",
        },
        positive=("f", "s_u", "s_v"),
    )  # fmt: skip
    stages: ClassVar[frozenset[Stage]] = frozenset(Stage)

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._pixel = dataset.points["pixel"][None]

    @cached_property
    def parameters(self) -> SensorParameters:
        """The paper's fourteen, the focal length fixed, and T_base_target where the target is not placed."""
        return SensorParameters(
            free=SCANNER,
            derived=() if self.dataset.placed else six_names("target"),
            fixed=("f",),
            fix_gauge=self._fix_gauge,
            closed_form="the stripe on the target",
            spans=self._spans,
            reduction=StripeReduction(self.dataset),
        )

    def _spans(self, values: Mapping[str, float]) -> Mapping[str, float]:
        return spans(values, self.dataset.image_px)

    def _fix_gauge(self, values: Values) -> Values:
        """(f, s_u, s_v, k) → (c f, c s_u, c s_v, k/c²) changes no point: take c so that f is nominal."""
        c = self.dataset.parameters["f"].nominal / values["f"]
        scaled = {name: values[name] * c for name in ("f", "s_u", "s_v")}
        return {**values, **scaled, "k": values["k"] / c**2}

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """Camera and laser."""
        return InCell(
            scanner_geometry.frames(self.dataset, values, perturb),
            mount=scanner_geometry.mount(self.dataset, values, perturb),
            camera=scanner_geometry.camera_view(values, perturb),
        )

    @property
    def new_poses(self) -> NewPoses:
        """The stripe across the target."""
        return StripeNewPoses(self.dataset)

    def in_camera(self, values: Values, perturb: Perturbation) -> Array:
        """Points on the laser plane that the pixels show, in the camera frame, (c, m, 3) [m]."""
        return scanner_geometry.in_camera(self._pixel, values, perturb, self.dataset.stripe_axis)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The same in the base frame."""
        return scanner_geometry.in_base(self.dataset, values, T_base_flange, perturb)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """T_base_target by a rigid fit.

        The laser plane where only that is missing: the camera is known, and the target has a place.
        """
        if missing := [name for name in SCANNER if name not in values]:
            if not {name for name in self.parameters.names if name not in values} <= LASER:
                raise not_given(self.format, missing, NO_START)
            return laser_start(self.dataset, values, T_base_flange[:1])
        return target_by_stripe(self.dataset, values, T_base_flange, perturb)

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The target points, in the base frame, (c or 1, m, 3) [m]."""
        return scanner_geometry.target(self.dataset, values, perturb)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`pixel` [px], each row's own, and `target` [m], isotropic, shared by a point's repeats; `board_errors`."""
        points, noise = self.dataset.points, self.dataset.noise
        moves = pixel_moves(self.dataset, values, T_base_flange, perturb)
        rows = np.arange(len(points))
        sources = [
            ErrorSource("pixel", moves, rows, unit="px", stated=noise.pixel_px),
            ErrorSource(
                "target",
                along_each_axis(len(points), 3),
                points.place,
                level="point",
                stated=noise.target_m,
                least=LEAST_TARGET_M,
            ),
        ]
        if self.dataset.board and not self.dataset.placed:
            away = np.linalg.norm(self.in_camera(values, perturb)[0], axis=-1)
            m_per_px = away * values["s_u"][0] / values["f"][0]
            sources.append(board_errors(self.dataset.board, points, motion(values, "target")[0], m_per_px))
        return sources

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """E of eq. 17: target point less predicted point, in the base frame, (c, m, 3) [m]."""
        return self.known(values, T_base_flange, perturb) - self.in_base(values, T_base_flange, perturb)


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
