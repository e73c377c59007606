"""Samples of MoveIt's hand-eye calibration, and the joint states saved with them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import motion_of_matrix, numbers, peek, read_yaml, under
from robolaser.errors import DataError, UsageError, near

SUFFIXES = (".yaml", ".yml", ".json")
KEYS = ("effector_wrt_world", "joint_names")
EFFECTOR, OBJECT = "effector_wrt_world", "object_wrt_sensor"


@final
class MoveIt(Importer):
    """A file of samples ("Save samples"), and with a robot perhaps one of joint states ("Save joint states")."""

    name: ClassVar[str] = "moveit"
    title: ClassVar[str] = "samples of MoveIt's hand-eye calibration (YAML), and perhaps its joint states"
    further: ClassVar[tuple[str, ...]] = (MOUNT,)
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    def recognises(self, path: Path) -> bool:
        """By its suffix and its keys."""
        return path.suffix.lower() in SUFFIXES and any(key in peek(path) for key in KEYS)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read samples, and the joint states that belong to them."""
        samples: tuple[str, list[Any]] | None = None
        joints: tuple[str, Mapping[str, Any]] | None = None
        for path in paths:
            contents = read_yaml(path)
            if isinstance(contents, list) and samples is None:
                samples = path.name, contents
            elif isinstance(contents, Mapping) and "joint_names" in contents and joints is None:
                joints = path.name, contents
            else:
                raise DataError(f"{path.name} holds neither samples nor joint states of MoveIt.", file=path.name)
        if samples is None:
            raise DataError(
                f"{paths[0].name} holds no samples: give the file that «Save samples» wrote.", file=paths[0]
            )
        file, rows = samples
        mount = mount_of(options, file)
        effector, seen = (
            np.array([_matrix(row, key, file, i) for i, row in enumerate(rows, 1)]).reshape(-1, 4, 4)
            for key in (EFFECTOR, OBJECT)
        )
        q = _readings(joints, options, len(rows))
        poses = flange_poses(effector) if q is None else replace(flange_poses(effector), q=q, T_base_flange=None)
        flange_from = EFFECTOR if joints is None else f"{joints[0]}, joint_values"
        left_out = () if q is None else (f"{file}: {EFFECTOR} (the joint readings replace it)",)
        return pairs_dataset(Pairs(file, poses, seen, flange_from, OBJECT), mount, options, left_out)


def _matrix(row: Any, key: str, file: str, number: int) -> Array:
    where = f"sample {number}, {key}"
    sixteen = numbers(under(row, key, file, f"sample {number}"), 16, file, where)
    return motion_of_matrix(sixteen.reshape(4, 4), file, where)


def _readings(joints: tuple[str, Mapping[str, Any]] | None, options: ImportOptions, samples: int) -> Array | None:
    """Joint readings in the order of the robot's joints, (n, j); None where there is no robot."""
    robot = options.robot
    if robot is None and joints is None:
        return None
    if robot is None:
        raise UsageError("Of which robot are the joint states? Name it with --robot, or leave out their file.")
    if joints is None:
        raise UsageError(
            "--robot: the samples hold flange poses. Give the file of «Save joint states» too, or leave it out."
        )
    file, contents = joints
    names = [str(name) for name in contents["joint_names"] or ()]
    rows = under(contents, "joint_values", file)
    if not isinstance(rows, list) or len(rows) != samples:
        count = len(rows) if isinstance(rows, list) else 0
        raise DataError(f"{file} has {count} joint states, but there are {samples} samples.", file=file)
    q = np.array([numbers(row, len(names), file, f"joint_values, entry {i}") for i, row in enumerate(rows, 1)])
    for joint in robot.joints:
        if joint not in names:
            raise DataError(
                f"{file} lacks the joint {joint} of the robot.{near(joint, names)}", file=file, column=joint
            )
    return q[:, [names.index(joint) for joint in robot.joints]]
