"""Samples and results of easy_handeye and easy_handeye2."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import motion, peek, read_yaml, under
from robolaser.data.sensor_format import Mount
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import inverse

SUFFIXES = (".samples", ".calib", ".yaml", ".yml", ".json")
KEYS = ("tracking_base_frame", "hand_world_samples", "samples:", '"samples"')
SAMPLES, RESULTS = ("samples", "hand_world_samples"), ("transform", "transformation")
MOUNTS: Mapping[object, Mount] = {"eye_in_hand": "flange", "eye_on_base": "base", True: "flange", False: "base"}
"""Mounts by `calibration_type` (easy_handeye2) and `eye_on_hand` (easy_handeye)."""


@final
class EasyHandeye(Importer):
    """A file of samples and, where there is one, the result of easy_handeye.

    easy_handeye2 saves samples as `NAME.samples` and the result as `NAME.calib`; the older easy_handeye saves the
    result as YAML, and prints its samples on request. With the camera in the cell, samples
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
        holders: dict[str, tuple[str, Mapping[str, Any]]] = {}
        for path in paths:
            contents, file = read_yaml(path), path.name
            held = [key for key in (*SAMPLES, *RESULTS) if isinstance(contents, Mapping) and key in contents]
            if not held:
                raise DataError(f"{file} holds neither samples nor a result of easy_handeye.", file=file)
            what = "samples" if held[0] in SAMPLES else "result"
            if what in holders:
                raise UsageError(f"{holders[what][0]} and {file} both hold {what}: import one after the other.")
            holders[what] = file, contents
        if "samples" not in holders:
            message = "is a result without its samples. Give the samples too (easy_handeye2: NAME.samples)."
            raise DataError(f"{paths[0].name} {message}", file=paths[0].name)
        file, contents = holders["samples"]
        result_file, result = holders.get("result", ("", {}))
        mount = mount_of(options, file, _stated(contents) or _stated(result))
        robot, tracking, fields = _pairs(contents, file)
        guess = next((motion(result[key], result_file, key) for key in RESULTS if key in result), None)
        flange_from = fields[0] if mount == "flange" else f"{fields[0]}, inverted"
        poses = flange_poses(robot if mount == "flange" else inverse(robot))
        return pairs_dataset(Pairs(file, poses, tracking, flange_from, fields[1], guess), mount, options)


def _pairs(contents: Mapping[str, Any], file: str) -> tuple[Array, Array, tuple[str, str]]:
    """T_base_effector of each sample, inverted where the camera is fixed in the cell, and T_camera_marker."""
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
    """The camera's mount by the parameters in a file; easy_handeye2 leaves them empty in samples."""
    parameters = contents.get("parameters")
    if not isinstance(parameters, Mapping):
        return None
    type_stated = parameters.get("calibration_type") or parameters.get("eye_on_hand")
    return MOUNTS.get(type_stated) if isinstance(type_stated, str | bool) else None
