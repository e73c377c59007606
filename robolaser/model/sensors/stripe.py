"""A camera and a laser plane on the flange: a pixel of the stripe is a point in space."""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat
from robolaser.duals import Dual, bare
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.sensors.placements import motion, six_names
from robolaser.model.sensors.scanner_start import laser_start, spans, target_by_stripe
from robolaser.model.sensors.sensor import NewPoses, Perturbation, Sensor, SensorParameters, Stage, Values, not_given
from robolaser.model.sensors.stripe_similarity import SIMILARITY, solve_similarity

SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
"""The paper's fourteen, in its order (eq. 15)."""

LASER = {"b", "theta"}
NO_START = (
    " Or give none: with the board's corners as a second sensor, as `robolaser extract --output` writes them, all start"
    " from closed forms."
)
SEEN_ALONG = 5  # points that represent the stripe at planned poses
LARGEST_PX = 0.1  # of a detected corner: a larger common motion of an image's rows is no error of corners
LEAST_TARGET_M = 1e-5
"""No printed target is better, and rows from images of a board, with residuals along their rays by construction, would
otherwise seem to be exact across them."""


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

    @cached_property
    def parameters(self) -> SensorParameters:
        """The paper's fourteen, some fixed by the `gauge`, and T_base_target where the target is not placed."""
        return SensorParameters(
            free=SCANNER,
            derived=() if self.dataset.placed else six_names("target"),
            fixed=gauge(self.dataset),
            fix_gauge=self._fix_gauge if gauge(self.dataset) else lambda values: values,
            closed_form="the stripe on the target",
            spans=partial(spans, image_px=self.dataset.image_px),
            linear=SIMILARITY,
            solve=partial(solve_similarity, self.dataset),
        )

    def _fix_gauge(self, values: Values) -> Values:
        """(f, s_u, s_v, k) → (c f, c s_u, c s_v, k/c²) changes no point: take c so that f is nominal."""
        c = self.dataset.parameters["f"].nominal / values["f"]
        scaled = {name: values[name] * c for name in ("f", "s_u", "s_v")}
        return {**values, **scaled, "k": values["k"] / c**2}

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """Camera and laser."""
        scanner = scanner_geometry.frames(self.dataset, values, perturb)
        return InCell(
            scanner,
            published=scanner,
            mount=scanner_geometry.mount(self.dataset, values, perturb),
            camera=scanner_geometry.camera_view(values, perturb),
        )

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """T_base_target by a rigid fit.

        The laser plane if only that is missing: camera and target are known.
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
            pixel = points["pixel"][None]
            seen = scanner_geometry.in_camera(pixel, values, perturb, self.dataset.stripe_axis)[0]
            away = np.linalg.norm(seen, axis=-1)
            m_per_px = away * values["s_u"][0] / values["f"][0]
            sources.append(board_errors(self.dataset.board, points, motion(values, "target")[0], m_per_px))
        return sources

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """E of eq. 17: target point less predicted point, in the base frame, (c, m, 3) [m]."""
        predicted = scanner_geometry.in_base(self.dataset, values, T_base_flange, perturb)
        return self.known(values, T_base_flange, perturb) - predicted

    @property
    def new_poses(self) -> NewPoses:
        """The stripe across the target."""
        return NewPoses(self._seen_from)

    def _seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """Some points of the stripe on the middle level of the target; good if they are on it and in the image."""
        view, xyz = scanner_geometry.view_of(self.dataset, values), self.dataset.points["xyz"]
        T_base_target = np.eye(4) if self.dataset.placed else motion(values, "target")[0]
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


def gauge(dataset: Dataset) -> tuple[str, ...]:
    """The parameters that no data can determine: f, unless the data set fixes those that would change with it.

    A k of zero stays zero, whatever f is.
    """
    given = dataset.parameters
    fixed = {name for name in ("s_u", "s_v", "k") if name in given and given[name].fixed}
    return () if fixed - {"k"} or ("k" in fixed and given["k"].nominal) else ("f",)


def pixel_moves(dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """Move of each residual with its own pixel's u and v, one candidate, (m, 3, 2) [m/px].

    Where points come from images of a board, the known point of a row is its own pixel mapped to the board by the
    homography, so it moves with the noise too. For all pixels both stay on one viewing ray o + λ r, the known point
    where the ray meets the board (λ_b), the predicted one where it meets the laser plane (λ_s): the residual is
    (λ_b − λ_s) r, and near the optimum, where λ_b ≈ λ_s, its derivative is r (∂λ_b − ∂λ_s). The board is z = 0 of
    the target's frame where the parameters place it, else the plane through all target points.
    """
    pixel = dataset.points["pixel"]

    at: Any = Dual(pixel[None], np.broadcast_to(np.eye(2)[:, None, None], (2, 1, *pixel.shape)), (0, 1))
    seen: Any = scanner_geometry.in_base(dataset, values, T_base_flange, perturb, pixel=at)[0]
    if dataset.board is None or not len(pixel):
        return np.asarray(-np.moveaxis(seen.slopes, 0, -1))

    centre = (T_base_flange @ scanner_geometry.mount(dataset, values, perturb))[0, :, :3, 3]
    centre = np.broadcast_to(centre, (len(dataset.poses), 3))[dataset.points.pose]
    if dataset.placed:
        known = scanner_geometry.target(dataset, values, perturb)[0]
        origin, normal = known.mean(axis=0), np.linalg.svd(known - known.mean(axis=0), full_matrices=False)[2][2]
    else:
        T_base_target = motion(values, "target")[0]
        origin, normal = T_base_target[:3, 3], T_base_target[:3, 2]

    along = seen - centre
    to_plane = np.linalg.norm(along, axis=-1, keepdims=True)
    ray = along / to_plane
    gap: Any = ((origin - centre) @ normal)[:, None] / (ray @ normal)[:, None] - to_plane
    return np.asarray(bare(ray)[:, :, None] * np.moveaxis(gap.slopes, 0, -1))


def board_errors(board: Board, points: Points, T_base_target: Array, m_per_px: Array) -> ErrorSource:
    """`board` [px], of each corner along x and y of the board, shared by all rows of an image.

    Where rows come from images of a board, a homography through its corners maps each pixel to the board. Its errors
    come from the corners, common to all rows: without this source the many rows would seem to locate the board better
    than its corners do. Points are in the board's frame; `m_per_px` is the size of a pixel at each row, (m,).
    """
    last = np.array([board.columns - 1, board.rows - 1])
    steps = [np.arange(end + 1) - end / 2 for end in last]
    corners = _homographies(np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2))
    of_unit_error = np.linalg.inv(np.linalg.qr(corners.reshape(-1, 8)).R)
    on_board = _homographies(points["xyz"][:, :2] / board.square_m - last / 2) @ of_unit_error
    effect = m_per_px[:, None, None] * (T_base_target[:3, :2] @ on_board)
    return ErrorSource("board", effect, points.pose, "px", level="point", most=LARGEST_PX)


def _homographies(at: Array) -> Array:
    """Small motions of points (m, 2) by each of a homography's eight numbers, (m, 2, 8)."""
    x, y = at.T
    one, none = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([one, none, x, y, none, none, x * x, x * y], axis=-1)
    along_y = np.stack([none, one, none, none, x, y, x * y, y * y], axis=-1)
    return np.stack([along_x, along_y], axis=1)
