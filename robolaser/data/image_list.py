"""The images taken at each pose of a recording, as poses.csv names them."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.data.dataset import Dataset, Poses
from robolaser.data.dataset_file import inside
from robolaser.errors import DataError

LIT = "image"  # column of poses.csv with the first image taken with the laser on
UNLIT = "image_off"  # column with the image taken with the laser off
REPEAT = re.compile(r"image_([2-9]|[1-9]\d+)")  # columns with further images of the unmoved arm, laser on


@final
@dataclass(frozen=True)
class PoseImages:
    """Files of one pose's images."""

    row: int  # of poses.csv, the first is 0
    pose: str  # its name
    lit: tuple[Path, ...]  # with the laser on: one, or several of the unmoved arm
    unlit: Path | None = None  # with the laser off, where it was taken

    @property
    def files(self) -> tuple[Path, ...]:
        """All files."""
        return self.lit if self.unlit is None else (*self.lit, self.unlit)


def repeat_columns(poses: Poses) -> list[str]:
    """Columns of poses.csv that name repeats, in order."""
    return sorted((name for name in poses.extra if REPEAT.fullmatch(name)), key=lambda name: int(name[6:]))


def images_of_poses(recording: Dataset) -> list[PoseImages]:
    """The images of a recording on disk, of each pose that has any."""
    folder, poses = recording.folder, recording.poses
    if folder is None or poses.image is None:
        return []
    columns = {LIT: poses.image, **{name: poses.extra[name] for name in repeat_columns(poses)}}
    unlit = poses.extra.get(UNLIT, ("",) * len(poses))

    def file(column: str, path: str) -> Path:
        return inside(folder, path, f"poses.csv, column {column}")

    shots: list[PoseImages] = []
    shown: dict[Path, str] = {}
    for row, pose in enumerate(poses.names):
        lit = {column: file(column, paths[row]) for column, paths in columns.items() if paths[row]}
        if LIT in lit:
            for column, one in lit.items():
                if one in shown:
                    message = f"{one.name} is the image of pose {shown[one]} already. Name the image that was taken"
                    raise _wrong(column, pose, f"{message} here, or delete one of the two.")
                shown[one] = pose
            shots.append(PoseImages(row, pose, (*lit.values(),), file(UNLIT, unlit[row]) if unlit[row] else None))
        elif lit or unlit[row]:
            message = f"column {next(iter(lit), UNLIT)} names an image, but this one is empty."
            raise _wrong(LIT, pose, f"{message} Name the image with the laser on, or leave all empty.")
    return shots


def _wrong(column: str, pose: str, what: str) -> DataError:
    """The error of a pose's cell; its row is not known any more."""
    return DataError(f"poses.csv, column {column}: pose {pose}: {what}", file="poses.csv", column=column)
