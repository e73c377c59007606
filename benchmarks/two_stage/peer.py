"""The usual two-stage way: camera from boards, sheet as a free plane, hand-eye by OpenCV, refined by reprojection."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import cv2
import numpy as np
from scipy.optimize import least_squares

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import apply, exp_so3, inverse, pose, rigid_fit

HAND_EYE = {
    "Tsai": cv2.CALIB_HAND_EYE_TSAI,
    "Park": cv2.CALIB_HAND_EYE_PARK,
    "Horaud": cv2.CALIB_HAND_EYE_HORAUD,
    "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS,
}
LENSES: Mapping[str, int] = {
    "k1": cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    "k1 k2": cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    "k1, centre fixed": cv2.CALIB_FIX_K2
    | cv2.CALIB_FIX_K3
    | cv2.CALIB_ZERO_TANGENT_DIST
    | cv2.CALIB_FIX_PRINCIPAL_POINT
    | cv2.CALIB_USE_INTRINSIC_GUESS,
}


@final
@dataclass(frozen=True)
class View:
    """The corners that one image shows: their places on the board, (k, 3) [m], and pixels, (k, 2)."""

    board: Array
    pixel: Array


@final
@dataclass(frozen=True)
class Camera:
    """OpenCV's camera matrix and distortion."""

    matrix: Array
    distortion: Array

    def rays(self, pixel: Array) -> Array:
        """Viewing rays with z = 1, (m, 2) [px] -> (m, 3)."""
        straight = cv2.undistortPointsIter(pixel.reshape(-1, 1, 2), self.matrix, self.distortion, None, None, _EXACT)
        return np.pad(straight.reshape(-1, 2), ((0, 0), (0, 1)), constant_values=1.0)

    def project(self, seen: Array) -> Array:
        """Pixels of points in the camera frame, (n, 3) [m] -> (n, 2)."""
        return cv2.projectPoints(seen, np.zeros(3), np.zeros(3), self.matrix, self.distortion)[0].reshape(-1, 2)

    def locate(self, view: View) -> Array:
        """T_camera_board from the board's corners."""
        known = (view.board, view.pixel, self.matrix, self.distortion)
        _, turn, shift = cv2.solvePnP(*known, flags=cv2.SOLVEPNP_IPPE)
        turn, shift = cv2.solvePnPRefineLM(*known, turn, shift)
        return pose(cv2.Rodrigues(turn)[0], shift.ravel())


REFINED = 2  # of the four: they end in one optimum, a second start is to make sure
_EXACT = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)


def find_camera(views: Sequence[View], image_px: tuple[int, int], lens: str) -> Camera:
    """OpenCV's intrinsics."""
    width, height = image_px
    guess = np.array([[2.0 * width, 0, (width - 1) / 2], [0, 2.0 * width, (height - 1) / 2], [0, 0, 1]])
    _, matrix, distortion, _, _ = cv2.calibrateCamera(
        [view.board.astype(np.float32) for view in views],
        [view.pixel.astype(np.float32) for view in views],
        image_px,
        guess,
        np.zeros(5),
        flags=LENSES[lens] | cv2.CALIB_USE_INTRINSIC_GUESS,
    )
    return Camera(matrix, distortion.ravel())


@final
@dataclass(frozen=True)
class HandEye:
    """The hand-eye and the board, and how well they reproject the corners."""

    method: str
    T_flange_camera: Array
    T_base_target: Array
    corner_rms_px: float


def find_hand_eye(camera: Camera, views: Sequence[View], T_base_flange: Array, loss: str = "linear") -> HandEye:
    """Best of OpenCV's four methods by reprojection, refined by reprojection of all corners through the robot.

    Args:
        camera: With its distortion.
        views: n of them.
        T_base_flange: (n, 4, 4).
        loss: Of the refinement, see `scipy.optimize.least_squares`.
    """
    T_camera_board = np.stack([camera.locate(view) for view in views])
    image = np.repeat(np.arange(len(views)), [len(view.board) for view in views])
    board, pixel = np.concatenate([view.board for view in views]), np.concatenate([view.pixel for view in views])

    def off(T_flange_camera: Array, T_base_target: Array) -> Array:
        T_camera_target = inverse(T_flange_camera) @ inverse(T_base_flange) @ T_base_target
        return (camera.project(apply(T_camera_target[image], board)) - pixel).ravel()

    ways = []
    for name, method in HAND_EYE.items():
        R, t = cv2.calibrateHandEye(
            T_base_flange[:, :3, :3],
            T_base_flange[:, :3, 3],
            T_camera_board[:, :3, :3],
            T_camera_board[:, :3, 3],
            method=method,
        )
        X = pose(np.asarray(R), np.asarray(t).ravel())
        if not np.isfinite(X).all():
            continue
        Z = rigid_fit(board, apply((T_base_flange @ X @ T_camera_board)[image], board))
        ways.append((float(np.sum(off(X, Z) ** 2)), name, X, Z))
    ends = []
    for _, name, X, Z in sorted(ways, key=lambda way: way[0])[:REFINED]:
        fit = least_squares(
            lambda p, X=X, Z=Z: off(_moved(X, p[:6]), _moved(Z, p[6:])),
            np.zeros(12),
            x_scale="jac",
            method="trf",
            loss=loss,
            f_scale=1.0,
        )
        ends.append((fit.cost, name, _moved(X, fit.x[:6]), _moved(Z, fit.x[6:])))
    _, name, X, Z = min(ends, key=lambda end: end[0])
    return HandEye(name, X, Z, float(np.sqrt(2 * np.mean(off(X, Z) ** 2))))


def _moved(T: Array, p: Array) -> Array:
    return T @ pose(exp_so3(p[:3]), p[3:])


def find_sheet(points: Array, *, robust: bool) -> Array:
    """The plane n · P = d nearest to points (m, 3) in least squares, as (n, d).

    With `robust` distances are weighed down by the soft-L1 law beyond their median deviation.
    """
    weight = np.ones(len(points))
    for _ in range(50 if robust else 1):
        mean = np.average(points, axis=0, weights=weight)
        _, _, Vt = np.linalg.svd((points - mean) * np.sqrt(weight)[:, None], full_matrices=False)
        plane = np.append(Vt[2], Vt[2] @ mean)
        off = points @ plane[:3] - plane[3]
        scale = 1.4826 * np.median(np.abs(off))
        weight = 1.0 / np.sqrt(1.0 + (off / scale) ** 2)
    return plane


def cut(ray: Array, plane: Array) -> Array:
    """Where rays (m, 3) meet a plane."""
    return ray * (plane[3] / (ray @ plane[:3]))[:, None]


@final
@dataclass(frozen=True)
class TwoStage:
    """All that the two-stage way finds."""

    camera: Camera
    sheet: Array
    hand_eye: HandEye
    T_base_target: Array

    def residuals(self, T_base_flange: Array, pixel: Array, place: Array) -> Array:
        """Known less predicted points in the base frame, one flange pose a row, (m, 3) [m]."""
        seen = cut(self.camera.rays(pixel), self.sheet)
        return apply(self.T_base_target, place) - apply(T_base_flange @ self.hand_eye.T_flange_camera, seen)


def two_stage(
    *,
    views: Sequence[View],
    T_base_flange: Array,
    of_image: Ints,
    pixel: Array,
    place: Array,
    camera: Camera,
    robust: bool = False,
    place_by_stripe: bool = False,
) -> TwoStage:
    """Sheet and hand-eye with a given camera.

    Args:
        views: The corners in each of n images.
        T_base_flange: Of each image, (n, 4, 4).
        of_image: The image of each stripe pixel, (m,).
        pixel: (m, 2) [px].
        place: On the board, (m, 3) [m].
        camera: Found from boards of the same poses.
        robust: Weigh down far points of the sheet and far corners of the refinement.
        place_by_stripe: Place the target by the stripe's points rather than by the corners.
    """
    T = np.stack([camera.locate(view) for view in views])[of_image]
    ray, normal = camera.rays(pixel), T[:, :3, 2]
    seen = ray * ((normal * T[:, :3, 3]).sum(axis=1) / (normal * ray).sum(axis=1))[:, None]
    sheet = find_sheet(seen, robust=robust)
    hand_eye = find_hand_eye(camera, views, T_base_flange, "soft_l1" if robust else "linear")
    target = hand_eye.T_base_target
    if place_by_stripe:
        target = rigid_fit(place, apply(T_base_flange[of_image] @ hand_eye.T_flange_camera, cut(ray, sheet)))
    return TwoStage(camera, sheet, hand_eye, target)
