"""Eleven calibrations: the paper's, and ten of other arms, sizes and noises, some of them hardly enough to go by."""

from collections.abc import Callable
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import from_quaternion
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, Simulated, paper, simulate

CHOICE = 300  # poses, of which the degenerate experiments take the few that are most alike


def cell(robot: str, poses: int, points: int, noise: Noise, **options: Any) -> Callable[[], Simulated]:
    """A cell as `simulate` makes it, not yet made."""
    there = CellOptions(**options)
    return lambda: simulate(find_robot(robot), poses=poses, points=points, noise=noise, options=there, seed=1)


def alike(robot: str, poses: int, points: int, noise: Noise, unlike: Callable[[Array], Array]) -> Simulated:
    """A cell of many poses, less all but those whose cameras (n, 3, 3) are least unlike."""
    made = simulate(find_robot(robot), poses=CHOICE, points=points, noise=noise, seed=1)
    cameras = made.dataset.flange()[:, :3, :3] @ from_quaternion(np.array(made.dataset.bracket_quat))
    kept = np.isin(np.arange(CHOICE), np.argsort(unlike(cameras))[:poses])
    return Simulated(made.dataset.of_poses(kept), made.truth)


def tilt(cameras: Array) -> Array:
    """Angle between view and plumb line, (n, 3, 3) -> (n,) [rad]."""
    angle: Array = np.arccos(np.clip(-cameras[:, 2, 2], -1, 1))
    return angle


def turn(cameras: Array) -> Array:
    """Angle to a camera that has many near it, (n, 3, 3) -> (n,) [rad]."""
    between = np.arccos(np.clip((np.einsum("aij,bij->ab", cameras, cameras) - 1) / 2, -1, 1))
    nearest: Array = between[np.sort(between, axis=1)[:, 10].argmin()]
    return nearest


EXPERIMENTS: dict[str, Callable[[], Simulated]] = {
    "the paper's: SCORBOT, 25 points, 0.3 mm": lambda: paper(find_robot("scorbot_er7"), seed=1),
    "SCORBOT, 10 points, 0.3 mm": cell("scorbot_er7", 5, 2, Noise(target_m=3e-4)),
    "UR5, 200 points, 0.1 mm": cell("ur5", 20, 10, Noise(target_m=1e-4)),
    "Panda, 2000 points, 0.5 mm": cell("panda", 40, 50, Noise(target_m=5e-4)),
    "xArm 7, 50 points, no noise": cell("xarm7", 10, 5, Noise()),
    "Jaco 2, 60 points, 1 mm": cell("jaco2", 15, 4, Noise(target_m=1e-3)),
    "UR10, 300 points, 0.3 mm and 0.2 px": cell("ur10", 30, 10, Noise(target_m=3e-4, pixel_px=0.2)),
    "SCORBOT, 48 points, tilts below 1°, 0.1 mm": lambda: alike("scorbot_er7", 8, 6, Noise(target_m=1e-4), tilt),
    "Panda, 60 points, turns below 25°, 0.1 mm": lambda: alike("panda", 10, 6, Noise(target_m=1e-4), turn),
    "UR3, 200 points, unplaced target, 0.2 mm": cell("ur3", 20, 10, Noise(target_m=2e-4), placed=False),
    "Z1, 48 points, stripe along v, 0.3 mm": cell("z1", 6, 8, Noise(target_m=3e-4), stripe_axis="v"),
}
