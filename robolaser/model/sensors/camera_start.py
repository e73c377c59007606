"""Start values of a camera: intrinsics from its boards, then hand-eye and target by A X = Z B."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly
from robolaser.errors import EstimationError
from robolaser.geometry.board_views import INTRINSICS, BoardView, board_pose, find_intrinsics
from robolaser.geometry.hand_eye import LEAST_TURN, hand_eye_by_travel, robot_world_hand_eye, turn_about_second_axis
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.sensors.placements import SIX, motion, numbers_of_motion
from robolaser.parameters import Values

FEWEST_PLACED = 3  # poses whose boards place the camera


@final
class CameraStart:
    """Closed forms for one data set; results of the images alone are computed once for all readings of the poses.

    Args:
        dataset: With pixels and target points.
        image_px: Width and height of the images.
        rides: Whether the camera is on the flange, and the target in the cell.
        most: Number of views that are used; the others would place a target again that a known camera sees.
    """

    def __init__(self, dataset: Dataset, image_px: tuple[int, int], *, rides: bool, most: int | None = None) -> None:
        self._rides, self._placed = rides, dataset.placed
        # parameters of the part on the flange, and of the one in the cell
        self._prefixes = ("hand_eye", "target") if rides else ("target", "hand_eye")
        every, poses = _views_of(dataset)
        used = evenly(len(every), most or len(every))
        views, self._poses = [every[i] for i in used], poses[used]
        self._shown = tuple((np.float64(view.points).tobytes(), np.float64(view.pixels).tobytes()) for view in views)
        self._image_px = image_px

    def initialize(self, values: Values, T_base_flange: Array) -> Values:
        """All parameters of the camera, (c,) each: as given, else by the flange, (c or 1, n, 4, 4).

        Raises:
            EstimationError: The images or the flange's poses do not determine them.
        """
        count = max([len(T_base_flange), *map(len, values.values())])
        each = [
            self._one(
                {name: float(value[i % len(value)]) for name, value in values.items()},
                T_base_flange[i % len(T_base_flange)],
            )
            for i in range(count)
        ]
        return {name: np.array([one[name] for one in each]) for name in each[0]}

    def _one(self, known: Mapping[str, float], T_base_flange: Array) -> dict[str, float]:
        held = tuple((name, known[name]) for name in INTRINSICS if name in known)
        intrinsics, T_camera_board = _placed_boards(self._shown, self._image_px, held)
        flange = T_base_flange[self._poses]
        X, Z = (self._known(known, prefix) for prefix in self._prefixes)
        B = inverse(T_camera_board) if self._rides else T_camera_board
        if X is None and Z is None and turn_about_second_axis(flange[:, :3, :3]) < LEAST_TURN:
            found_X, found_Z = hand_eye_by_travel(flange, B)
        else:
            every_X, found_Z = robot_world_hand_eye(flange, B, X=None if X is None else X[None], Z=Z)
            found_X = every_X[0]
        one, other = self._prefixes
        six = numbers_of_motion(found_X, one) | numbers_of_motion(found_Z, other)
        return dict(intrinsics) | {name: known.get(name, value) for name, value in six.items()}

    def _known(self, known: Mapping[str, float], prefix: str) -> Array | None:
        if prefix == "target" and self._placed:
            return np.eye(4)
        names = [f"{prefix}.{part}" for part in SIX]
        if not all(name in known for name in names):
            return None
        return np.asarray(motion({name: np.array([known[name]]) for name in names}, prefix)[0])


@lru_cache(maxsize=4)
def _placed_boards(
    shown: tuple[tuple[bytes, bytes], ...], image_px: tuple[int, int], held: tuple[tuple[str, float], ...]
) -> tuple[Mapping[str, float], Array]:
    """The intrinsics, and T_camera_board of each view, (v, 4, 4); cached for several readings of the same images."""
    views = [
        BoardView(*(np.frombuffer(part).reshape(-1, n) for part, n in zip(view, (3, 2), strict=True))) for view in shown
    ]
    intrinsics = find_intrinsics(views, image_px, dict(held))
    if len(views) < FEWEST_PLACED:
        raise EstimationError(
            f"{len(views)} of the poses show enough of the target to locate it: a hand-eye takes"
            f" {FEWEST_PLACED} or more, with turns about two axes. Take more images."
        )
    return intrinsics, np.stack([board_pose(view, intrinsics) for view in views])


def _views_of(dataset: Dataset) -> tuple[Sequence[BoardView], Ints]:
    """The informative views, and the numbers of their poses."""
    points = dataset.points
    found, poses = [], []
    for pose in np.unique(points.pose):
        own = points.pose == pose
        view = BoardView(points["xyz"][own], points["pixel"][own])
        if view.is_telling:
            found.append(view)
            poses.append(pose)
    return found, np.array(poses, dtype=np.int64)
