"""A camera's focal lengths, principal point and distortion, as ROS, OpenCV and industrial_calibration write them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from robolaser.data.importers.opencv_storage import MARKS, read_storage
from robolaser.data.importers.yaml_file import numbers, peek, read_yaml, under
from robolaser.errors import DataError, UsageError
from robolaser.parameters import Parameter

NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
PINHOLE = NAMES[:4]  # OpenCV's order of a distortion of five numbers follows these four
INTRINSICS: Final = "intrinsics"  # option that names a file of intrinsics
HOLD: Final = "hold"  # option that says whether they are held or fitted
MODELS = ("plumb_bob", "none", "")
SPAN_OF_FOCAL = 0.3
SPAN_OF_DISTORTION = 2.0


def intrinsics_of_file(path: Path) -> dict[str, float]:
    """What a file says: ROS's camera_info YAML, OpenCV's camera_matrix and distortion_coefficients, or fx fy cx cy.

    Raises:
        DataError: It says nothing of them, or has a distortion of another model than OpenCV's of five numbers.
    """
    if any(mark in peek(path) for mark in MARKS):
        nodes = read_storage(path)
        matrix = nodes.get("camera_matrix") or nodes.get("K")
        if not matrix or matrix[0].size != 9:
            raise DataError(f"{path.name} has no camera_matrix of nine numbers.", file=path)
        distortion = nodes.get("distortion_coefficients") or nodes.get("dist_coeffs") or [np.zeros(0)]
        return intrinsics_of(matrix[0].reshape(-1).tolist(), distortion[0].reshape(-1).tolist(), path.name)
    contents = read_yaml(path)
    if isinstance(contents, Mapping) and "camera_matrix" in contents:
        model = str(contents.get("distortion_model", ""))
        D = contents.get("distortion_coefficients", {"data": []})
        K = numbers(under(contents["camera_matrix"], "data", path.name), 9, path.name, "camera_matrix").tolist()
        return intrinsics_of(K, under(D, "data", path.name), path.name, model)
    return pinhole(under(contents, "intrinsics", path.name), path.name)


def pinhole(values: Any, file: str) -> dict[str, float]:
    """Of industrial_calibration: fx, fy, cx and cy."""
    return {name: float(numbers(under(values, name, file), 1, file, f"intrinsics.{name}")[0]) for name in PINHOLE}


def intrinsics_of(K: Sequence[float], D: Sequence[float], file: str, model: str = "") -> dict[str, float]:
    """Of a camera matrix, row by row, and distortion coefficients in OpenCV's order.

    Raises:
        DataError: The distortion is of another model, or the matrix is none of a camera.
    """
    D = list(D)
    if model not in MODELS or (len(D) > 5 and any(D[5:])):
        what = model if model not in MODELS else f"{len(D)} numbers"
        raise DataError(
            f"{file}: its distortion ({what}) is not OpenCV's of five numbers, k1 k2 p1 p2 k3. Leave the file out: the"
            " intrinsics are found from the board.",
            file=file,
        )
    if not (K[0] > 0 and K[4] > 0):
        raise DataError(f"{file}: the camera matrix has no focal lengths. Is the camera calibrated?", file=file)
    return dict(zip(NAMES, [K[0], K[4], K[2], K[5], *(D[:5] + [0.0] * 5)[:5]], strict=True))


def intrinsic_parameters(values: Mapping[str, float], further: Mapping[str, str]) -> dict[str, Parameter]:
    """Nominal values with wide bounds, or held at their values if `--set hold=intrinsics` says so.

    Raises:
        UsageError: It says something else.
    """
    held = further.get(HOLD)
    if held not in (None, INTRINSICS):
        raise UsageError(f"--set {HOLD}={held}: expected {INTRINSICS}, which are fitted otherwise.")
    focal = max(values["fx"], values["fy"])
    found = {}
    for name, value in values.items():
        span = SPAN_OF_FOCAL * focal if name in PINHOLE else SPAN_OF_DISTORTION
        ends = (value, value) if held else (value - span, value + span)
        found[name] = Parameter(name, "px" if name in PINHOLE else "", value, *ends)
    return found
