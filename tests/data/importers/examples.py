"""Example files for each importer with their options: the contract of importers is tested on these."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import cv2
import hand_eye
import numpy as np
import pytest
from hand_eye import HandEyeCell, cell

import robolaser
from robolaser import find_robot
from robolaser.data.dataset import Dataset
from robolaser.data.importers import ImportOptions
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.simulation import simulate

Example = Callable[[Path], tuple[list[Path], list[str]]]
"""Writes files into a folder; returns them and the options of `robolaser import`."""
JOINTS = [f"joint_{i}" for i in range(1, 6)]
MAPPED = {"pose": "Nr", "time_s": "t", "point": "Prisma", "x_m": "X", "y_m": "Y", "z_m": "Z"} | {
    f"q_{joint}": f"A{i}" for i, joint in enumerate(JOINTS, 1)
}


def read(paths: Sequence[Path], options: ImportOptions, kind: str | None = None) -> Dataset:
    return robolaser.import_files(*paths, options=options, kind=kind)


def tracked() -> Dataset:
    return simulate(find_robot("scorbot_er7"), kind="point", poses=8, points=2, seed=4).dataset


def written(path: Path, rows: Sequence[Sequence[object]], *, separator: str = ";", decimal: str = ",") -> Path:
    cells = [[repr(float(c)).replace(".", decimal) if isinstance(c, float) else str(c) for c in row] for row in rows]
    path.write_bytes("".join(f"{separator.join(row)}\r\n" for row in cells).encode("utf-8-sig"))
    return path


def log_rows(dataset: Dataset, length: float = 1e3, angle: float = 180 / np.pi) -> list[list[object]]:
    """A row for each point with the readings of its pose, in mm and degrees."""
    poses, points = dataset.poses, dataset.points
    header = ["Nr", "t", *(f"A{i}" for i in range(1, 6)), "Prisma", "X", "Y", "Z"]
    rows = [
        [
            poses.names[i],
            float(poses.time_s[i]),
            *(poses.q[i] * angle).tolist(),
            points.names[k],
            *(points.xyz[k] * length).tolist(),
        ]
        for k, i in enumerate(points.pose)
    ]
    return [header, *rows]


def options(mapped: Mapping[str, str]) -> list[str]:
    return [word for column, source in mapped.items() for word in ("--column", f"{column}={source}")]


def csv(folder: Path) -> tuple[list[Path], list[str]]:
    file = written(folder / "log.csv", log_rows(tracked()))
    words = ["--robot", "scorbot_er7", "--units", "mm,deg", "--decimal", ",", "--separator", ";"]
    return [file], [*words, *options(MAPPED)]


def pairs(write: Callable[[Path, HandEyeCell], list[Path]], *words: str, poses: int = 8) -> Example:
    def example(folder: Path) -> tuple[list[Path], list[str]]:
        return write(folder, cell("base", poses=poses)), list(words)

    return example


def rosbag(folder: Path) -> tuple[list[Path], list[str]]:
    bags = pytest.importorskip("bags")
    made = cell("base", poses=8)
    with bags.recorder(folder, "mcap") as (path, record):
        for i, (flange, seen) in enumerate(zip(made.T_base_flange, made.T_camera_target, strict=True)):
            record.frame(bags.START_S + i, "base", "tool0", flange)
            record.frame(bags.START_S + i, "camera", "tag", seen)
    frames = [f"--set={name}" for name in ("base=base", "flange=tool0", "camera=camera", "marker=tag")]
    return [next(path.glob("*.mcap"))], ["--set", "mount=base", "--set", "tolerance_s=0.01", *frames]


def images(folder: Path) -> tuple[list[Path], list[str]]:
    T = cell("base").T_base_flange[:3]
    q = to_quaternion(T[:, :3, :3])
    names = ["3.png", "10.png", "20.png"]
    header = ["image", "x", "y", "z", "qx", "qy", "qz", "qw"]
    rows = [[name, *t.tolist(), *one.tolist()] for name, t, one in zip(names, T[:, :3, 3] * 1e3, q, strict=True)]
    written(folder / "poses.csv", [header, *rows], separator=",", decimal=".")
    for name in names:
        cv2.imwrite(str(folder / name), np.full((30, 40), 99, dtype=np.uint8))
    mapped = {f"poses.{axis}_m": axis for axis in "xyz"}
    board = "board=charuco,4x6,36mm,18mm,DICT_6X6_250"
    return [folder], ["--units", "mm", "--set", "mount=base", "--set", board, *options(mapped)]


def industrial_calibration(folder: Path) -> tuple[list[Path], list[str]]:
    lines = ["data:"]
    (folder / "poses").mkdir()
    (folder / "images").mkdir()
    for i, T in enumerate(cell("base").T_base_flange[:3]):
        values = dict(zip(("x", "y", "z", "qx", "qy", "qz", "qw"), [*T[:3, 3], *to_quaternion(T[:3, :3])], strict=True))
        text = "\n".join(f"{key}: {float(value)!r}" for key, value in values.items())
        (folder / "poses" / f"{i}.yaml").write_text(text, "utf-8")
        cv2.imwrite(str(folder / "images" / f"{i}.png"), np.full((30, 40), 99, dtype=np.uint8))
        lines.append(f"  - pose: poses/{i}.yaml\n    image: images/{i}.png")
    (folder / "cal_data.yaml").write_text("\n".join(lines) + CAL_DATA, "utf-8")
    return [folder], []


CAL_DATA = """
target_finder:
  type: CharucoGridTargetFinder
  rows: 7
  cols: 5
  chessboard_dim: 0.036195
  aruco_marker_dim: 0.018256
  dictionary: 10
intrinsics: {fx: 1352.0, fy: 1356.1, cx: 789.7, cy: 627.3}
camera_mount_to_camera_guess: {x: -0.02, y: 1.28, z: 0.28, qx: -0.048080, qy: -0.558686, qz: 0.827604, qw: -0.025104}
static_camera: true
use_opencv: true
"""

EXAMPLES: Mapping[str, Example] = {
    "csv": csv,
    "easy_handeye": pairs(hand_eye.easy_handeye2),
    "moveit": pairs(hand_eye.moveit, "--set", "mount=base"),
    "opencv": pairs(hand_eye.opencv, "--set", "mount=base", "--units", "mm", poses=20),
    "tum": pairs(hand_eye.tum, "--set", "tolerance_s=0.02"),
    "rosbag": rosbag,
    "images": images,
    "industrial_calibration": industrial_calibration,
}
