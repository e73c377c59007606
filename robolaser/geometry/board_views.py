"""A camera's intrinsics, and poses of boards in its frame, from their image points alone."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import apply, pose

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")  # OpenCV's, in its order
FEWEST_POINTS = 6  # points of a board below which a view does not determine its pose
FEWEST_VIEWS = 3  # that determine a camera's intrinsics. Zhang 2000, A flexible new technique for camera calibration.
MOST_VIEWS = 40  # views, spread over the run, for start values of intrinsics; more cost much and add little
FOCAL_RANGE = (0.2, 50.0)  # focal lengths of lenses [image widths]; a fit outside saw boards that were not tilted
FLAT = 1e-3  # thickness of a target over its breadth below which it counts as flat
STRAY_MEDIANS = 5.0  # error of a view, in medians of all, beyond which it does not show the board
STRAY_LEAST_PX = 2.0  # the same at least [px]


@final
@dataclass(frozen=True)
class BoardView:
    """A board in one image."""

    points: Array  # in the board's frame, (k, 3) [m]
    pixels: Array  # their pixels, (k, 2) [px]

    @property
    def is_telling(self) -> bool:
        """Whether it has enough points that are not on one line."""
        if len(self.points) < FEWEST_POINTS:
            return False
        breadth = np.linalg.svd(self.points - self.points.mean(axis=0), compute_uv=False)
        return bool(breadth[1] > FLAT * breadth[0])


def camera_matrix(values: Mapping[str, float]) -> Array:
    """Of the pinhole, (3, 3) [px]."""
    return np.array([[values["fx"], 0.0, values["cx"]], [0.0, values["fy"], values["cy"]], [0.0, 0.0, 1.0]])


def distortion(values: Mapping[str, float]) -> Array:
    """OpenCV's five coefficients, (5,)."""
    return np.array([values[name] for name in INTRINSICS[4:]])


def find_intrinsics(
    views: Sequence[BoardView], image_px: tuple[int, int], held: Mapping[str, float] | None = None
) -> dict[str, float]:
    """A pinhole and two radial terms from views of boards; the other terms are zero.

    Args:
        views: Of flat boards or others, `is_telling` each.
        image_px: Width and height of the images.
        held: Intrinsics that are known.

    Returns:
        All of `INTRINSICS`.

    Raises:
        EstimationError: There are too few views, or none of them is tilted.
    """
    held = held or {}
    if all(name in held for name in INTRINSICS):
        return dict(held)
    if len(views) < FEWEST_VIEWS:
        raise EstimationError(
            f"Enough of the target, {FEWEST_POINTS} points or more, is seen in {len(views)} of the poses: the camera"
            f" cannot be found from fewer than {FEWEST_VIEWS}. Take more images of the whole target, or state all of"
            f" {', '.join(INTRINSICS)} under [parameters] with fixed = true."
        )
    chosen = np.unique(np.linspace(0, len(views) - 1, min(len(views), MOST_VIEWS)).astype(np.int64))
    found = _calibrated([views[i] for i in chosen], image_px, held)
    if not FOCAL_RANGE[0] < found["fx"] / image_px[0] < FOCAL_RANGE[1]:
        raise EstimationError(
            f"The views of the target do not determine the camera's focal length ({found['fx']:.3g} px came out): tilt"
            " the target against the view by 20 to 45 degrees, in several directions, or state fx, fy, cx and cy under"
            " [parameters] with fixed = true."
        )
    return found | dict(held)


def _calibrated(views: Sequence[BoardView], image_px: tuple[int, int], held: Mapping[str, float]) -> dict[str, float]:
    """OpenCV's fit of the intrinsics, without views of something else."""
    import cv2  # noqa: PLC0415 - takes a moment to import

    width, height = image_px
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_TANGENT_DIST
    for name in ("k1", "k2"):
        flags |= getattr(cv2, f"CALIB_FIX_{name.upper()}") if name in held else 0
    if {"cx", "cy"} & held.keys():
        flags |= cv2.CALIB_FIX_PRINCIPAL_POINT
    if {"fx", "fy"} <= held.keys():
        flags |= cv2.CALIB_FIX_FOCAL_LENGTH
    T_flat_board, flat = _plane_frame(np.concatenate([view.points for view in views]))
    boards = [_in_plane(T_flat_board, view.points, flat=flat).astype(np.float32) for view in views]
    guess = {"fx": 1.2 * width, "fy": 1.2 * width, "cx": (width - 1) / 2, "cy": (height - 1) / 2}
    is_bent = any(held.get(name) for name in INTRINSICS[4:])
    if is_bent:  # OpenCV takes a stated lens only with a guess of the pinhole
        guess = _calibrated(views, image_px, {name: held[name] for name in INTRINSICS[:4] if name in held})
    guess = {**guess, **dict.fromkeys(INTRINSICS[4:], 0.0), **held}
    if held.keys() & set(INTRINSICS[:4]) or is_bent or not flat:
        flags |= cv2.CALIB_USE_INTRINSIC_GUESS
    pixels = [view.pixels.reshape(-1, 1, 2).astype(np.float32) for view in views]
    for _ in range(2):
        try:
            with one_thread():
                _, K, coefficients, _, _, _, _, errors = cv2.calibrateCameraExtended(
                    boards, pixels, image_px, camera_matrix(guess), distortion(guess), flags=flags
                )
        except cv2.error:
            return dict(guess, fx=0.0)
        off = np.ravel(errors)
        good = off <= max(STRAY_MEDIANS * float(np.median(off)), STRAY_LEAST_PX)
        if good.all() or good.sum() < FEWEST_VIEWS:
            break
        boards, pixels = ([one for one, kept in zip(each, good, strict=True) if kept] for each in (boards, pixels))
    lens = np.ravel(coefficients)[:5].tolist()
    return dict(zip(INTRINSICS, (K[0, 0].item(), K[1, 1].item(), K[0, 2].item(), K[1, 2].item(), *lens), strict=True))


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep OpenCV to one thread: several sum in any order, and the last digits differ between runs."""
    import cv2  # noqa: PLC0415 - slow to import

    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _plane_frame(points: Array) -> tuple[Array, bool]:
    """T_flat_board with the points (k, 3) about z = 0, (4, 4), and whether they are in that plane."""
    middle = points.mean(axis=0)
    _, breadth, axes = np.linalg.svd(points - middle, full_matrices=False)
    axes = axes * np.array([[1.0], [1.0], [np.linalg.det(axes)]])
    return pose(axes, -axes @ middle), bool(breadth[2] < FLAT * breadth[0])


def _in_plane(T_flat_board: Array, points: Array, *, flat: bool) -> Array:
    return np.ascontiguousarray(apply(T_flat_board, points) * np.array([1.0, 1.0, 0.0 if flat else 1.0]))


def board_pose(view: BoardView, intrinsics: Mapping[str, float]) -> Array:
    """T_camera_board of a view that `is_telling`, (4, 4); the likelier of the two of a flat board."""
    import cv2  # noqa: PLC0415

    K, lens = camera_matrix(intrinsics), distortion(intrinsics)
    T_flat_board, flat = _plane_frame(view.points)
    points = _in_plane(T_flat_board, view.points, flat=flat)
    pixels = np.ascontiguousarray(view.pixels, dtype=np.float64).reshape(-1, 1, 2)
    found: list[tuple[Array, Array]] = []
    for method in (cv2.SOLVEPNP_IPPE, cv2.SOLVEPNP_ITERATIVE) if flat else (cv2.SOLVEPNP_SQPNP,):
        _, turns, shifts, _ = cv2.solvePnPGeneric(points, pixels, K, lens, flags=method)
        # For a board tilted about one of its own axes IPPE may give NaN, depending on rounding.
        each = zip(np.asarray(turns, dtype=np.float64), np.asarray(shifts, dtype=np.float64), strict=True)
        found += [start for start in each if np.isfinite(start).all()]
    best, least = np.eye(4), np.inf
    for start in found:
        turn, shift = cv2.solvePnPRefineLM(points, pixels, K, lens, *start)
        shown, _ = cv2.projectPoints(points, turn, shift, K, lens)
        left = float(np.square(shown - pixels).sum())
        if left < least and np.ravel(shift)[2] > 0.0:
            best, least = pose(np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64), np.ravel(shift)), left
    return np.asarray(best @ T_flat_board)
