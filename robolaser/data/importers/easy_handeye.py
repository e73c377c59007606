"""Samples and results of easy_handeye and easy_handeye2."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.importers.hand_eye_pairs import MOUNT, Mount, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import motion, peek, read_yaml, under
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import inverse

SUFFIXES = (".samples", ".calib", ".yaml", ".yml", ".json")
KEYS = ("tracking_base_frame", "hand_world_samples", "samples:", '"samples"')
MOUNTS: Mapping[object, Mount] = {"eye_in_hand": "flange", "eye_on_base": "base", True: "flange", False: "base"}
"""What `calibration_type` (easy_handeye2) and `eye_on_hand` (easy_handeye) say."""


@final
class EasyHandeye(Importer):
    """A file of samples and, where there is one, the result that easy_handeye found.

    easy_handeye2 saves samples as `NAME.samples` and the result as `NAME.calib`; the older easy_handeye saves the
    result as YAML, and prints its samples when its service is asked for them. With the camera in the cell, samples
    state the base as seen from the effector, and are inverted.
    """

    name: ClassVar[str] = "easy_handeye"
    title: ClassVar[str] = (
        "samples (.samples), and perhaps the result (.calib, .yaml), of easy_handeye and easy_handeye2"
    )
    further: ClassVar[tuple[str, ...]] = (MOUNT,)
    takes: ClassVar[tuple[str, ...]] = ()

    def recognises(self, path: Path) -> bool:
        """By its suffix and its keys."""
        return path.suffix.lower() in SUFFIXES and any(key in peek(path) for key in KEYS)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read samples, and the result that belongs to them."""
        samples: tuple[str, Any] | None = None
        result: tuple[str, Any] | None = None
        for path in paths:
            contents, file = read_yaml(path), path.name
            if isinstance(contents, Mapping) and {"samples", "hand_world_samples"} & contents.keys():
                if samples is not None:
                    raise UsageError(f"{samples[0]} and {file} both hold samples: import one after the other.")
                samples = file, contents
            elif isinstance(contents, Mapping) and {"transform", "transformation"} & contents.keys():
                result = file, contents
            else:
                raise DataError(f"{file} holds neither samples nor a result of easy_handeye.", file=file)
        if samples is None:
            raise DataError(
                f"{paths[0].name} is a result without its samples. Give the samples too (easy_handeye2: NAME.samples).",
                file=paths[0].name,
            )
        file, contents = samples
        mount = mount_of(options, file, _stated(contents) or (_stated(result[1]) if result else None))
        robot, tracking, fields = _pairs(contents, file)
        pairs = Pairs(
            file,
            flange_poses(robot if mount == "flange" else inverse(robot)),
            tracking,
            fields[0] if mount == "flange" else f"{fields[0]}, inverted",
            fields[1],
            guess=None if result is None else _result(*result),
        )
        return pairs_dataset(pairs, mount, options)


def _pairs(contents: Mapping[str, Any], file: str) -> tuple[Array, Array, tuple[str, str]]:
    """Of each sample T_base_effector, inverted where the camera stands in the cell, and T_camera_marker."""
    holder = contents if "hand_world_samples" in contents else contents["samples"]
    if isinstance(holder, Mapping):
        fields = ("hand_world_samples", "camera_marker_samples")
        lists = [under(holder, field, file) for field in fields]
        lists = [one["transforms"] if isinstance(one, Mapping) and "transforms" in one else one for one in lists]
    else:
        fields = ("robot", "tracking")
        rows = holder if isinstance(holder, list) else []
        lists = [[under(row, field, file, f"sample {i}") for i, row in enumerate(rows, 1)] for field in fields]
    if not all(isinstance(one, list) for one in lists) or len(lists[0]) != len(lists[1]):
        raise DataError(f"{file}: {fields[0]} and {fields[1]} are not two lists of one length.", file=file)
    robot, tracking = (
        np.array([motion(row, file, f"sample {i}, {field}") for i, row in enumerate(rows, 1)]).reshape(-1, 4, 4)
        for field, rows in zip(fields, lists, strict=True)
    )
    return robot, tracking, fields


def _stated(contents: Mapping[str, Any]) -> Mount | None:
    """What the parameters that a file was saved with say of the camera; easy_handeye2 leaves them empty in samples."""
    parameters = contents.get("parameters")
    if not isinstance(parameters, Mapping):
        return None
    type_stated = parameters.get("calibration_type") or parameters.get("eye_on_hand")
    return MOUNTS.get(type_stated) if isinstance(type_stated, str | bool) else None


def _result(file: str, contents: Mapping[str, Any]) -> Array:
    key = "transform" if "transform" in contents else "transformation"
    return motion(contents[key], file, key)
