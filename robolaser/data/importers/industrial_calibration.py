"""Data of ROS-Industrial's industrial_calibration: cal_data.yaml, images, the poses of the wrist, the target finder."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, final

import numpy as np

from robolaser.data.board import Board, dictionaries
from robolaser.data.dataset import Poses
from robolaser.data.dataset_file import inside
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of, placed_camera
from robolaser.data.importers.image_folder import CAL_DATA, SUFFIXES, camera_recording, image_files
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import Entry, peek, read_yaml
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

    name = "industrial_calibration"
    title = "industrial_calibration's cal_data.yaml with its images and poses"
    further = (MOUNT,)
    takes = ()

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
        static = contents["static_camera"].value if "static_camera" in contents else None
        known: Mount | None = None if not isinstance(static, bool) else "base" if static else "flange"
        mount = mount_of(options, file, known)
        board = _board(contents["target_finder"])
        T, images, renamed = [], [], []
        for entry in contents["data"].entries("entry"):
            pose_file, image = (inside(folder, str(entry[key].value), file) for key in ("pose", "image"))
            T.append(replace(read_yaml(pose_file), file=f"{pose_file.parent.name}/{pose_file.name}").motion())
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
            parameters = _pinhole(contents[INTRINSICS])
            settings[" ".join(parameters)] = INTRINSICS
        if GUESS in contents:
            parameters |= placed_camera(contents[GUESS].motion(), "hand_eye")
            settings["hand_eye.*"] = GUESS
        dataset = camera_recording(poses, size_px, board, mount, options, source=file)
        left_out = [f"{file}: {key}" for key in contents.value if key not in USED]
        if renamed:
            more = f" and so on, {len(renamed)} in all" if len(renamed) > 1 else ""
            left_out.append(f"{file}: names of images that are there with another suffix ({renamed[0]}{more})")
        read_from = {
            "poses.csv": {"pose": "(name of the image)", "image": "image", "": "pose"},
            "dataset.toml": settings,
        }
        return Imported(replace(dataset, parameters=parameters), read_from, tuple(left_out), held)


def _pinhole(values: Entry) -> dict[str, Parameter]:
    """fx, fy, cx and cy of a camera without distortion, within wide bounds."""
    read = {name: values[name].number() for name in ("fx", "fy", "cx", "cy")}
    span = SPAN * max(read["fx"], read["fy"])
    return {name: Parameter(name, "px", value, value - span, value + span) for name, value in read.items()}


def _board(finder: Entry) -> Board:
    kind = str(finder["type"].value).rpartition("::")[2]
    if kind.startswith("CharucoGrid"):
        square_m, marker_m = (finder[key].number() for key in ("chessboard_dim", "aruco_marker_dim"))
        columns, rows = (int(finder[key].number()) - 1 for key in ("cols", "rows"))
        return Board(columns, rows, square_m, "charuco", marker_m, _dictionary(finder["dictionary"]))
    if kind.startswith("ModifiedCircleGrid"):
        columns, rows = (int(finder[key].number()) for key in ("cols", "rows"))
        return Board(columns, rows, finder["spacing"].number(), "modified_circles")
    raise DataError(
        f"{finder['type']}: {kind} is a board that robolaser does not find in images; it finds ChArUco boards and grids"
        " of circles.",
        file=finder.file,
        column="target_finder",
    )


def _dictionary(stated: Entry) -> str:
    """OpenCV's name of a dictionary that the file gives as a number."""
    number = int(stated.number())
    names = [name for name, known in dictionaries().items() if known == number]
    if not names:
        raise DataError(f"{stated}: OpenCV has no dictionary {number}.", file=stated.file)
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
