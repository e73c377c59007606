"""A new cell for a known arm with a camera: its description, a board to print, plans, and an emulated world."""

import math
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, final

from scipy.spatial.transform import Rotation

from robolaser.cell.first_plan import Layout, first_poses, layout, reach_of, with_motions
from robolaser.cell.route import route_text
from robolaser.data.board import Board, board_pdf
from robolaser.data.cell_config import load_cell
from robolaser.data.csv_tables import table_text
from robolaser.data.lerobot import TURN, MotorCalibration
from robolaser.data.writing import toml_text
from robolaser.errors import UsageError
from robolaser.model.sensors.placements import numbers_of_motion
from robolaser.robot.by_name import RobotEntry, find_robot, known_robots

CELL_FILES: Final = (
    "README.md", "board.pdf", "cell.toml", "dataset.toml", "motions.csv", "poses.csv", "world.toml"
)  # fmt: skip
FOLLOW_HZ, FOLLOW_RAD_S = 50, 0.8  # of arms of small servos that follow setpoints
FOLLOWING: Final = ("dynamixel", "feetech")
EMULATED: Final = ("acl", *FOLLOWING)
BOARD: Final = Board(10, 7, 0.020, "charuco", 0.015, "DICT_4X4_100")  # fits on a sheet of A4
IMAGE_PX: Final = (640, 480)
REACH: Final = 0.95  # share of the arm's reach that is used, so that it is never stretched
SEED: Final = 1


@final
@dataclass(frozen=True)
class NewCell:
    """Description of a new cell."""

    entry: RobotEntry
    sensor: str  # "camera", or "stripe": with a laser
    poses: int
    servos: Mapping[str, MotorCalibration]  # LeRobot's calibration; empty: servos count from position 2048

    @property
    def follows(self) -> bool:
        """Whether the arm follows setpoints."""
        return self.entry.controller["kind"] in FOLLOWING


def new_cell(new: NewCell) -> dict[str, str | bytes | None]:
    """The files of a cell by name; None for files that such an arm does not need.

    No parameter is given a value: camera, mount and board are found from the images.

    Raises:
        UsageError: There is no driver for the arm.
        PlanError: Too few poses see the board.
    """
    if not new.entry.controller:
        others = ", ".join(one.name for one in known_robots() if one.controller)
        raise UsageError(
            f"There is no driver for {new.entry.title}: a cell of it cannot be driven. Arms with one: {others}. Record"
            " the joint angles with its own software and use 'robolaser import'."
        )
    pdf = board_pdf(BOARD)
    reach_m = REACH * reach_of(find_robot(new.entry.name))
    described = {"dataset.toml": _dataset(new), "cell.toml": _cell(new, reach_m)}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in described.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        cell = load_cell(folder)
        poses = first_poses(cell, new.poses, SEED)
        at = layout(cell)
        motions = route_text(cell.robot, with_motions(cell, poses, SEED)) if new.follows else None
        world = new.sensor == "camera" and new.entry.controller["kind"] in EMULATED
        return {
            **described,
            "README.md": _readme(new, at),
            "board.pdf": pdf,
            "poses.csv": table_text(
                ["pose", *(f"q_{joint}" for joint in cell.robot.joints)],
                [[pose.name, *map(repr, pose.q.tolist())] for pose in poses],
            ),
            "motions.csv": motions,
            "world.toml": _world(new, at) if world else None,
        }


def _dataset(new: NewCell) -> str:
    entry, size = new.entry, dict(zip(("width_px", "height_px"), IMAGE_PX, strict=True))
    return toml_text((
        ("", {"format": "robolaser-dataset/1", "name": f"{entry.name}-cell"}),
        ("[robot]", {"urdf": entry.name, "flange": entry.flange, "joints": entry.joints}),
        ("[sensor]", {"kind": new.sensor}),
        ("[image]", size),
        ("[board]  # board.pdf: measure the print, and correct square_m and marker_m", asdict(BOARD)),
        ("[target]  # the position of the board is found", {"placed": False}),
    ))  # fmt: skip


def _cell(new: NewCell, reach_m: float) -> str:
    arm: dict[str, Any] = dict(new.entry.controller)
    if new.follows:
        arm["setpoint_hz"] = FOLLOW_HZ
    if new.servos:
        servos = [new.servos[joint] for joint in new.entry.joints]
        arm["ids"] = [servo.id for servo in servos]
        arm["reference_rad"] = [round((TURN / 2 - servo.middle) * 2 * math.pi / TURN, 6) for servo in servos]
    lines = toml_text([("[arm]", arm)])
    speed = f"speed_rad_s = {FOLLOW_RAD_S}\n" if new.follows else ""
    lit = "\n[laser]\n# output = 1            # of the controller; absent: always on\n"
    return f"""\
format = "robolaser-cell/1"

{lines}
[camera]
source = 0              # number, device or URL
{lit if new.sensor == "stripe" else ""}
[limits]
floor_m = 0.02          # nothing goes below
reach_m = {reach_m:.2f}          # the arm does not stretch farther
{speed}"""


def _world(new: NewCell, at: Layout) -> str:
    """An arm with usual faults, and a tilted camera next to the flange."""
    focal, joints = 0.96 * IMAGE_PX[0], new.entry.joints
    T = at.T_flange_camera.copy()
    T[:3, 3] = T[:3, :3] @ [0.004, -0.045, -0.03]
    T[:3, :3] = T[:3, :3] @ Rotation.from_euler("XYZ", [-0.12, 0.03, 0.02]).as_matrix()
    camera = {
        "fx": focal, "fy": 0.998 * focal, "cx": 0.51 * IMAGE_PX[0], "cy": 0.49 * IMAGE_PX[1],
        "k1": 0.05, "k2": -0.08,
        "hand_eye": {name.partition(".")[2]: round(x, 6) for name, x in numbers_of_motion(T, "hand_eye").items()},
    }  # fmt: skip
    quat = [round(value, 6) for value in Rotation.from_matrix(at.T_base_board[:3, :3]).as_quat().tolist()]
    origin = [round(value, 6) for value in at.T_base_board[:3, 3].tolist()]
    faults = [("joint_offset", joints[2], 0.05), ("backlash", joints[1], 0.01)]
    if new.follows:
        late = [(name, joint, size) for joint in joints for name, size in (("lag", 0.06), ("dead_time", 0.03))]
        faults += [("dead_zone", joints[2], 0.03), ("droop", joints[1], 0.05), ("droop", joints[2], 0.08), *late]
    about = "# The true camera and board, and the faults of the arm: only `robolaser emulate` reads them.\n"
    return about + toml_text((
        ("", {"format": "robolaser-world/1"}),
        ("[truth]", camera),
        ("[floor]", {"height_m": 0}),
        ("[board]", {"origin_m": origin, "quat": quat}),
        *(("[[effect]]", {"name": name, "where": where, "size": size}) for name, where, size in faults),
    ))  # fmt: skip


def _readme(new: NewCell, at: Layout) -> str:
    sensor, long_m = "camera" if new.sensor == "camera" else "scanner", BOARD.square_m * (BOARD.columns + 1)
    plan = "motions.csv" if new.follows else "poses.csv --both-ways"
    log = "\n       robolaser diagnose recording/motion --output servo" if new.follows else ""
    return f"""\
# {new.entry.title} with a {sensor}

1. Print `board.pdf` at 100 %. The longer side should measure {1e3 * long_m:.0f} mm; otherwise correct `square_m` and
   `marker_m` in `dataset.toml`. Glue the print to something flat.
2. Lay it on the table, its middle {100 * at.ahead_m:.0f} cm in front of the arm ({at.front} of its base frame), the
   long side across. A few centimetres do not matter: part of the board in view is enough.
3. Fix the {sensor} to the last link, so that it looks where the arm points. Its exact pose is estimated.
4. Set `port` and `source` in `cell.toml`, and the size of the camera's images in `dataset.toml`.
5. Look at the plan, clear the table, keep a hand on the power switch, and record:

       robolaser record . --poses {plan} --output ../recording --dry-run
       robolaser record . --poses {plan} --output ../recording --move

6. Find out what is wrong:

       cd ..
       robolaser extract recording --output points
       robolaser diagnose points --output why{log}

`why/report.html` says where the error is, what causes it and what to do about it.
"""
