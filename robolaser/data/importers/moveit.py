"""Samples of MoveIt's hand-eye calibration."""

from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np

from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.yaml_file import peek, read_yaml
from robolaser.errors import DataError, UsageError

SUFFIXES = (".yaml", ".yml", ".json")
EFFECTOR, OBJECT = "effector_wrt_world", "object_wrt_sensor"


@final
class MoveIt(Importer):
    """A file of samples ("Save samples"): T_base_flange and T_camera_target of each."""

    name = "moveit"
    title = "samples of MoveIt's hand-eye calibration (YAML)"
    further = (MOUNT,)
    takes = ()

    def recognises(self, path: Path) -> bool:
        """By its suffix and its keys."""
        return path.suffix.lower() in SUFFIXES and EFFECTOR in peek(path)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read samples."""
        if len(paths) > 1:
            raise UsageError(f"{len(paths)} files of samples: import one after the other.")
        contents, file = read_yaml(paths[0]), paths[0].name
        if not isinstance(contents.value, list):
            raise DataError(f"{file} holds no samples: give the file that «Save samples» wrote.", file=file)
        mount, samples = mount_of(options, file), contents.entries("sample")
        effector, seen = (
            np.array([sample[key].matrix() for sample in samples]).reshape(-1, 4, 4) for key in (EFFECTOR, OBJECT)
        )
        return pairs_dataset(Pairs(file, flange_poses(effector), seen, EFFECTOR, OBJECT), mount, options)
