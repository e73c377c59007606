"""Data of ROS-Industrial's industrial_calibration: cal_data.yaml, images, the poses of the wrist, the target finder."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Final, final

import numpy as np

from robolaser.data.board import Board, dictionaries
from robolaser.data.dataset import Poses
from robolaser.data.dataset_file import inside
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of, placed_camera
from robolaser.data.importers.image_folder import CAL_DATA, SUFFIXES, camera_recording, image_files
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import motion, number, peek, read_yaml, under
from robolaser.data.sensor_format import Mount
from robolaser.errors import DataError, UsageError
from robolaser.parameters import Parameter

KEYS = ("target_finder:", "camera_mount_to_camera_guess:", "homography_threshold:", "static_camera:")
SUFFIX: Final = (".yaml", ".yml")
INTRINSICS, GUESS = "intrinsics", "camera_mount_to_camera_guess"
USED = ("data", "target_finder", INTRINSICS, GUESS, "static_camera")
SPAN = 0.3  # of the focal length: largest error of a camera's start values


@final
class IndustrialCalibration(Importer):
    """The folder with cal_data.yaml, or that file.

    The poses are those of the wrist in the base frame. For a ChArUco board the file counts squares, one more each
    way than inner corners. The guess of the target is left out: it has another frame on the board.
    """

    name: ClassVar[str] = "industrial_calibration"
    title: ClassVar[str] = "industrial_calibration's cal_data.yaml with its images and poses"
    further: ClassVar[tuple[str, ...]] = (MOUNT,)
    takes: ClassVar[tuple[str, ...]] = ()

    def recognises(self, path: Path) -> bool:
        """A folder with cal_data.yaml, or a YAML file with its keys."""
        file = path / CAL_DATA if path.is_dir() else path
        text = peek(file)
        return file.suffix in SUFFIX and any(text.startswith(key) or f"\n{key}" in text for key in KEYS)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read the listed images and poses."""
        if len(paths) > 1:
            raise UsageError(f"{len(paths)} folders: import one after the other.")
        whole = paths[0] / CAL_DATA if paths[0].is_dir() else paths[0]
        contents, file, folder = read_yaml(whole), whole.name, whole.parent
        if not isinstance(contents, Mapping):
            raise DataError(f"{file} has no named values, such as data and target_finder.", file=file)
        static = contents.get("static_camera")
        known: Mount | None = None if not isinstance(static, bool) else "base" if static else "flange"
        mount = mount_of(options, file, known)
        board = _board(under(contents, "target_finder", file), file)
        entries = under(contents, "data", file)
        if not isinstance(entries, list) or not entries:
            raise DataError(f"{file}, data: expected a list of images and poses.", file=file, column="data")
        T, images, renamed = [], [], []
        for i, entry in enumerate(entries, 1):
            where = f"data, entry {i}"
            pose_file, image = (inside(folder, str(under(entry, key, file, where)), file) for key in ("pose", "image"))
            T.append(motion(read_yaml(pose_file), f"{pose_file.parent.name}/{pose_file.name}", "pose"))
            images.append(_image(image, file))
            if images[-1] != image:
                renamed.append(f"{image.name} is {images[-1].name}")
        paths_of, held, size_px = image_files(images)
        names = tuple(image.stem for image in images)
        if len(set(names)) < len(images):
            names = tuple(map(str, range(1, len(images) + 1)))
        poses = Poses(names, T_base_flange=np.array(T), image=paths_of)
        parameters: dict[str, Parameter] = {}
        settings = {"[board]": "target_finder"}
        if INTRINSICS in contents:
            parameters = _pinhole(contents[INTRINSICS], file)
            settings[" ".join(parameters)] = INTRINSICS
        if GUESS in contents:
            parameters |= placed_camera(motion(contents[GUESS], file, GUESS), "hand_eye")
            settings["hand_eye.*"] = GUESS
        dataset = camera_recording(poses, size_px, board, mount, options, source=file)
        left_out = [f"{file}: {key}" for key in contents if key not in USED]
        if renamed:
            more = f" and so on, {len(renamed)} in all" if len(renamed) > 1 else ""
            left_out.append(f"{file}: names of images that are there with another suffix ({renamed[0]}{more})")
        read_from = {
            "poses.csv": {"pose": "(name of the image)", "image": "image", "": "pose"},
            "dataset.toml": settings,
        }
        return Imported(replace(dataset, parameters=parameters), read_from, tuple(left_out), held)


def _pinhole(values: Any, file: str) -> dict[str, Parameter]:
    """fx, fy, cx and cy of a camera without distortion, within wide bounds."""
    read = {name: number(values, name, file, INTRINSICS) for name in ("fx", "fy", "cx", "cy")}
    span = SPAN * max(read["fx"], read["fy"])
    return {name: Parameter(name, "px", value, value - span, value + span) for name, value in read.items()}


def _board(finder: Any, file: str) -> Board:
    kind = str(under(finder, "type", file, "target_finder")).rpartition("::")[2]

    def length(key: str) -> float:
        return number(finder, key, file, "target_finder")

    if kind.startswith("CharucoGrid"):
        markers = length("aruco_marker_dim"), _dictionary(int(length("dictionary")), file)
        corners = int(length("cols")) - 1, int(length("rows")) - 1
        return Board(*corners, length("chessboard_dim"), "charuco", *markers)
    if kind.startswith("ModifiedCircleGrid"):
        return Board(int(length("cols")), int(length("rows")), length("spacing"), "modified_circles")
    raise DataError(
        f"{file}, target_finder.type: {kind} is a board that robolaser does not find in images; it finds ChArUco boards"
        " and grids of circles.",
        file=file,
        column="target_finder",
    )


def _dictionary(number: int, file: str) -> str:
    """OpenCV's name of a dictionary that the file gives as a number."""
    names = [name for name, known in dictionaries().items() if known == number]
    if not names:
        raise DataError(f"{file}, target_finder.dictionary: OpenCV has no dictionary {number}.", file=file)
    return min(names, key=len)


def _image(stated: Path, file: str) -> Path:
    """The image of that name, or the only one of that name with another suffix."""
    if stated.is_file():
        return stated
    others = [stated.with_suffix(suffix) for suffix in SUFFIXES if stated.with_suffix(suffix).is_file()]
    if len(others) != 1:
        why = "is not there" if not others else f"is there as {' and '.join(one.name for one in others)}"
        raise DataError(f"{file}: {stated.parent.name}/{stated.name} {why}.", file=stated)
    return others[0]
