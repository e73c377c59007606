"""A hand-eye cell with known truth, and its files in each tool's format."""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, to_quaternion

LENGTH_NOISE_M, ANGLE_NOISE_RAD = 2e-4, 3e-4


@dataclass(frozen=True)
class HandEyeCell:
    """Flange poses, and target poses in the camera frame."""

    mount: str
    T_base_flange: np.ndarray
    T_camera_target: np.ndarray
    T_carried: np.ndarray
    """T_flange_camera, or T_flange_target."""
    T_standing: np.ndarray
    """T_base_target, or T_base_camera."""


def cell(mount: str, poses: int = 20, seed: int = 1) -> HandEyeCell:
    rng = np.random.default_rng(seed)

    def motions(turn: float, middle: tuple[float, float, float], spread: float, n: int = 1) -> np.ndarray:
        return pose(exp_so3(rng.normal(0, turn, (n, 3))), middle + rng.normal(0, spread, (n, 3)))

    flange = motions(0.7, (0.4, 0.1, 0.5), 0.2, poses)
    carried, standing = motions(2.0, (0.05, 0.0, 0.1), 0.02)[0], motions(2.0, (0.9, 0.1, 0.2), 0.1)[0]
    seen = inverse(flange @ carried) @ standing  # T_camera_target, the camera carried
    if mount == "base":
        seen = inverse(seen)  # the target is on the flange instead
        seen = inverse(standing) @ flange @ carried
    shaken = pose(exp_so3(rng.normal(0, ANGLE_NOISE_RAD, (poses, 3))), rng.normal(0, LENGTH_NOISE_M, (poses, 3)))
    return HandEyeCell(mount, flange, seen @ shaken, carried, standing)


def ros_transform(T: np.ndarray, indent: str) -> str:
    """A geometry_msgs/Transform in the format of rosidl's message_to_yaml."""
    q = to_quaternion(T[:3, :3])
    lines = ["translation:", *(f"  {k}: {v!r}" for k, v in zip("xyz", T[:3, 3].tolist(), strict=True))]
    lines += ["rotation:", *(f"  {k}: {v!r}" for k, v in zip("xyzw", q.tolist(), strict=True))]
    return "\n".join(indent + line for line in lines)


PARAMETERS = """parameters:
  name: '{name}'
  calibration_type: '{kind}'
  robot_base_frame: '{base}'
  robot_effector_frame: ''
  tracking_base_frame: ''
  tracking_marker_frame: ''
  freehand_robot_movement: false
"""


def easy_handeye2(folder: Path, made: HandEyeCell) -> list[Path]:
    """NAME.samples with empty parameters, and NAME.calib."""
    robot = made.T_base_flange if made.mount == "flange" else inverse(made.T_base_flange)
    rows = [
        f"- robot:\n{ros_transform(r, '    ')}\n  tracking:\n{ros_transform(t, '    ')}"
        for r, t in zip(robot, made.T_camera_target, strict=True)
    ]
    samples = folder / "cell.samples"
    samples.write_text(PARAMETERS.format(name="", kind="", base="") + "samples:\n" + "\n".join(rows) + "\n", "utf-8")
    result = made.T_carried if made.mount == "flange" else made.T_standing
    kind = "eye_in_hand" if made.mount == "flange" else "eye_on_base"
    calib = folder / "cell.calib"
    header = PARAMETERS.format(name="cell", kind=kind, base="base_link")
    calib.write_text(f"{header}transform:\n{ros_transform(result, '  ')}\n", "utf-8")
    return [samples, calib]


def easy_handeye(folder: Path, made: HandEyeCell) -> list[Path]:
    """Printed samples of the older tool, and its result."""
    robot = made.T_base_flange if made.mount == "flange" else inverse(made.T_base_flange)
    lines = ["samples:"]
    for field, T in (("hand_world_samples", robot), ("camera_marker_samples", made.T_camera_target)):
        lines.append(f"  {field}:")
        for one in T:
            first, *rest = ros_transform(one, "      ").splitlines()
            lines += ["    - " + first.strip(), *rest]
    (folder / "samples.yaml").write_text("\n".join(lines) + "\n", "utf-8")
    T = made.T_carried if made.mount == "flange" else made.T_standing
    values = dict(zip(("x", "y", "z", "qx", "qy", "qz", "qw"), [*T[:3, 3], *to_quaternion(T[:3, :3])], strict=True))
    parameters = {"eye_on_hand": made.mount == "flange", "tracking_base_frame": "camera", "namespace": "/cell/"}
    result = {"parameters": parameters, "transformation": {key: float(value) for key, value in values.items()}}
    (folder / "result.yaml").write_text(json.dumps(result), "utf-8")
    return [folder / "samples.yaml", folder / "result.yaml"]


def moveit(folder: Path, made: HandEyeCell) -> list[Path]:
    """The file of "Save samples", in the format of yaml-cpp's emitter."""
    lines = []
    for effector, seen in zip(made.T_base_flange, made.T_camera_target, strict=True):
        lines.append(f"- effector_wrt_world: [{', '.join(map(repr, effector.ravel().tolist()))}]")
        lines.append(f"  object_wrt_sensor: [{', '.join(map(repr, seen.ravel().tolist()))}]")
    (folder / "samples.yaml").write_text("\n".join(lines) + "\n", "utf-8")
    return [folder / "samples.yaml"]


def opencv(folder: Path, made: HandEyeCell, name: str = "pairs.yml", *, vectors: bool = False) -> list[Path]:
    """Vectors of matrices in the format of cv::FileStorage; translations in mm."""
    storage = cv2.FileStorage(str(folder / name), cv2.FILE_STORAGE_WRITE)
    for word, T in (("gripper2base", made.T_base_flange), ("target2cam", made.T_camera_target)):
        for letter in "Rt":
            storage.startWriteStruct(f"{letter}_{word}", cv2.FILE_NODE_SEQ)
            for one in T:
                R = cv2.Rodrigues(one[:3, :3].copy())[0] if vectors else one[:3, :3].copy()
                storage.write("", R if letter == "R" else one[:3, 3:] * 1e3)
            storage.endWriteStruct()
    storage.write("camera_matrix", np.eye(3))
    storage.release()
    return [folder / name]


def tum(folder: Path, made: HandEyeCell) -> list[Path]:
    """Trajectories of the flange at 50 Hz, and of the target on it in the camera frame, at other times."""
    assert made.mount == "base"
    lines = [[], []]
    for i, (flange, seen) in enumerate(zip(made.T_base_flange, made.T_camera_target, strict=True)):
        for at in (-0.01, 0.01):  # at rest
            lines[0].append((1.6e9 + i + at, flange))
        lines[1].append((1.6e9 + i + 0.003, seen))
    for path, rows in zip(("flange.tum", "body.tum"), lines, strict=True):
        text = [
            " ".join(map(repr, [float(t), *T[:3, 3].tolist(), *to_quaternion(T[:3, :3]).tolist()])) for t, T in rows
        ]
        (folder / path).write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(text) + "\n", "utf-8")
    return [folder / "flange.tum", folder / "body.tum"]
