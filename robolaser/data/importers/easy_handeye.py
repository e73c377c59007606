"""Samples and results of easy_handeye and easy_handeye2."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import Entry, peek, read_yaml
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

    name = "easy_handeye"
    title = "samples (.samples), and perhaps the result (.calib, .yaml), of easy_handeye and easy_handeye2"
    further = (MOUNT,)
    takes = ()

    def recognises(self, path: Path) -> bool:
        """By its suffix and its keys."""
        return path.suffix.lower() in SUFFIXES and any(key in peek(path) for key in KEYS)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read samples, and the result that belongs to them."""
        holders: dict[str, Entry] = {}
        for contents in map(read_yaml, paths):
            held = [key for key in (*SAMPLES, *RESULTS) if key in contents]
            if not held:
                raise DataError(f"{contents} holds neither samples nor a result of easy_handeye.", file=contents.file)
            what = "samples" if held[0] in SAMPLES else "result"
            if what in holders:
                raise UsageError(f"{holders[what]} and {contents} both hold {what}: import one after the other.")
            holders[what] = contents
        if "samples" not in holders:
            message = "is a result without its samples. Give the samples too (easy_handeye2: NAME.samples)."
            raise DataError(f"{paths[0].name} {message}", file=paths[0].name)
        samples, result = holders["samples"], holders.get("result", Entry({}, ""))
        mount = mount_of(options, samples.file, _stated(samples) or _stated(result))
        robot, tracking, fields = _pairs(samples)
        guess = next((result[key].motion() for key in RESULTS if key in result), None)
        flange_from = fields[0] if mount == "flange" else f"{fields[0]}, inverted"
        poses = flange_poses(robot if mount == "flange" else inverse(robot))
        return pairs_dataset(Pairs(samples.file, poses, tracking, flange_from, fields[1], guess), mount, options)


def _pairs(contents: Entry) -> tuple[Array, Array, tuple[str, str]]:
    """T_base_effector of each sample, inverted where the camera is fixed in the cell, and T_camera_marker."""
    holder = contents if "hand_world_samples" in contents else contents["samples"]
    if isinstance(holder.value, Mapping):
        fields = ("hand_world_samples", "camera_marker_samples")
        held = [holder[field] for field in fields]
        held = [one["transforms"] for one in held] if "transforms" in held[0] else held
        lists = [one.entries("sample") for one in held]
    else:
        fields = ("robot", "tracking")
        lists = [[sample[field] for sample in holder.entries("sample")] for field in fields]
    if len(lists[0]) != len(lists[1]):
        message = f"{contents.file}: {fields[0]} and {fields[1]} are not two lists of one length."
        raise DataError(message, file=contents.file)
    robot, tracking = (np.array([one.motion() for one in entries]).reshape(-1, 4, 4) for entries in lists)
    return robot, tracking, fields


def _stated(contents: Entry) -> Mount | None:
    """The camera's mount by the parameters in a file; easy_handeye2 leaves them empty in samples."""
    parameters = contents["parameters"].value if "parameters" in contents else None
    if not isinstance(parameters, Mapping):
        return None
    type_stated = parameters.get("calibration_type") or parameters.get("eye_on_hand")
    return MOUNTS.get(type_stated) if isinstance(type_stated, str | bool) else None
