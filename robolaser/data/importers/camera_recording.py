"""Images of a board with the arm's readings, as a raw recording of a camera: `extract` finds the board in them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import final

import numpy as np

from robolaser.bounded_reading import IMAGE_BYTES, decoded, read_bytes
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.importers.board_option import FORM
from robolaser.data.importers.hand_eye_pairs import Mount
from robolaser.data.importers.importer import ImportOptions
from robolaser.data.sensor_format import sensor_format
from robolaser.errors import DataError, UsageError
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import Robot

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp")


@final
@dataclass(frozen=True)
class ImageFiles:
    """The images of a recording."""

    paths: tuple[str, ...]  # of each pose, within the data set; "" where there is none
    contents: Mapping[str, Callable[[], bytes]]  # what gives the bytes of each, by path
    size_px: tuple[int, int]  # width and height of all of them [px]


def camera_recording(
    poses: Poses,
    images: ImageFiles,
    board: Board | None,
    mount: Mount,
    options: ImportOptions,
    *,
    source: str,
    parameters: Mapping[str, Parameter],
    robot: Robot | None = None,
) -> Dataset:
    """The recording, without points.

    Raises:
        UsageError: The board is not stated.
    """
    if board is None:
        raise UsageError(f"{source}: what is printed on the board? State it with {FORM}.")
    declared = sensor_format("camera")
    assert declared.options is not None  # where it is mounted
    return Dataset(
        options.name,
        poses,
        Points(np.empty(0, dtype=np.int64), ()),
        kind="camera",
        robot=robot,
        parameters=parameters,
        options=declared.options(mount=mount),
        image_px=images.size_px,
        board=board,
        placed=False,
        path_known=options.path_known,
        source=source,
    )


def image_files(files: Sequence[Path | None]) -> ImageFiles:
    """Images on disk, under their own names in the data set's folder `images`.

    Raises:
        DataError: One cannot be read, has another size than the first, or shares its name with another.
    """
    paths: list[str] = []
    contents: dict[str, Callable[[], bytes]] = {}
    origin: dict[str, Path] = {}
    size: tuple[int, int] | None = None
    for file in files:
        if file is None:
            paths.append("")
            continue
        path = str(PurePosixPath("images") / file.name)
        if origin.setdefault(path, file) != file:
            raise DataError(f"{origin[path]} and {file} have the same name: rename one.", file=file)
        paths.append(path)
        here = _size(file) if path not in contents else size
        size = size or here
        if here != size:
            raise DataError(
                f"{file.name} has {here[0]} x {here[1]} pixels, but the image before it {size[0]} x {size[1]}."
                if here and size
                else f"{file.name} is empty.",
                file=file,
            )
        contents[path] = file.read_bytes
    if size is None:
        raise DataError("There is no image.")
    return ImageFiles(tuple(paths), contents, size)


def _size(file: Path) -> tuple[int, int]:
    import cv2  # noqa: PLC0415 - slow to import

    image = decoded(read_bytes(file, IMAGE_BYTES), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise DataError(f"{file.name} is not an image that OpenCV can read. Is it complete?", file=file)
    height, width = image.shape[:2]
    return width, height
