"""Files of each kind that an importer of ours reads, and what to say of them: the contract is tried on these."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from robolaser import find_robot
from robolaser.data.dataset import Dataset
from robolaser.simulation import simulate

Example = Callable[[Path], tuple[list[Path], list[str]]]
"""Writes files into a folder; gives them, and the options of `robolaser import`."""
JOINTS = [f"joint_{i}" for i in range(1, 6)]
MAPPED = {"pose": "Nr", "time_s": "t", "point": "Prisma", "x_m": "X", "y_m": "Y", "z_m": "Z"} | {
    f"q_{joint}": f"A{i}" for i, joint in enumerate(JOINTS, 1)
}


def tracked() -> Dataset:
    return simulate(find_robot("scorbot_er7"), kind="point", poses=8, points=2, seed=4).dataset


def written(path: Path, rows: Sequence[Sequence[object]], *, separator: str = ";", decimal: str = ",") -> Path:
    cells = [[repr(float(c)).replace(".", decimal) if isinstance(c, float) else str(c) for c in row] for row in rows]
    path.write_bytes("".join(f"{separator.join(row)}\r\n" for row in cells).encode("utf-8-sig"))
    return path


def log_rows(dataset: Dataset, length: float = 1e3, angle: float = 180 / np.pi) -> list[list[object]]:
    """A row for each point, with the readings of its pose; in mm and degrees."""
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
    said = ["--robot", "scorbot_er7", "--units", "mm,deg", "--decimal", ",", "--separator", ";"]
    return [file], [*said, *options(MAPPED)]


EXAMPLES: Mapping[str, Example] = {"csv": csv}
