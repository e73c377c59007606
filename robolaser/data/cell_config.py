"""The configuration of a cell: its arm, camera, laser and limits."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, final

from msgspec import Meta

from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import NonEmpty, check_rotation, describe
from robolaser.data.toml_schema import NotNegative, Positive, lacking, read_toml, typed, wrong
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.checking import unknown_frame

FILE = "cell.toml"
FORMAT = "robolaser-cell/1"
Address = Annotated[int, Meta(ge=0, le=253)]  # of a servo; 254 is the broadcast address
Axes = Literal["er7", "er5plus"]
UNATTENDED_S, MOST_UNATTENDED_S = 0.9, 1.0
MOST_SETPOINT_HZ = 200.0  # capacity of a line


@final
@dataclass(frozen=True)
class ArmLine:
    """The arm's controller and the line to it."""

    kind: NonEmpty  # name of its protocol, see `robolaser.cell.arm.ARMS`
    port: NonEmpty  # a device or any URL that pyserial opens
    baud: Annotated[int, Meta(ge=1)] = 9600  # bits a second
    flow: Literal["none", "xonxoff"] = "none"  # "none" or "xonxoff"
    ids: tuple[Address, ...] = ()  # addresses of the servos, base first, where there are addresses; empty: 1, 2, ...
    reference_rad: tuple[float, ...] = ()  # joint angles at the controller's reference posture; empty: all zero
    direction: tuple[float, ...] = ()  # +1 or -1 for each joint: which way it counts; empty: all +1
    home: bool = False  # whether it searches its home before a recording
    unattended_s: Positive = UNATTENDED_S  # longest motion per command, and so after a crash of this computer [s]
    # setpoints a second that the arm follows, and that are logged; None: its controller plans each motion
    setpoint_hz: Annotated[float, Meta(gt=0, le=MOST_SETPOINT_HZ)] | None = None
    axes: Axes | None = None  # a SCORBOT's type, required for it, see `robolaser.cell.acl`


@final
@dataclass(frozen=True)
class CameraLine:
    """The camera."""

    source: NonEmpty | Annotated[int, Meta(ge=0)]  # a number, a device, a stream's URL, or a folder of images
    exposure: float | None = None  # in the driver's unit; None: unchanged
    gain: float | None = None  # likewise
    settle_s: Positive = 0.3  # wait between the arm's rest, or the laser's switching, and the shot [s]


@final
@dataclass(frozen=True)
class Limits:
    """Limits of all poses.

    For the floor, links are straight lines between their joints, without thickness: state a floor higher than the real
    one by half the diameter of the thickest link. Only the flange's reach counts.
    """

    floor_m: float | None = None  # least height of joints, flange, camera, projector in the base frame [m]; None: any
    reach_m: float | None = None  # largest distance of flange from the first joint's foot [m]; None: the arm's reach
    speed_rad_s: Positive = 0.3  # highest joint speed [rad/s or m/s]: slow enough for an emergency stop
    # least distance between links, scanner and boxes that could collide [m]; by default more than the motion between
    # two checked postures, and than the error of a ruler
    margin_m: NotNegative = 0.01
    link_radius_m: Positive | None = None  # of links without boxes, spheres or cylinders [m]; None: by the arm's length


@final
@dataclass(frozen=True)
class Box:
    """An obstacle in the cell, or a body on a link of the arm."""

    name: NonEmpty  # for messages
    centre_m: tuple[float, float, float]  # in the frame of its link, (3,) [m]
    size_m: tuple[Positive, Positive, Positive]  # edges along its own x, y and z, (3,) [m]
    quat: Quaternion = (0.0, 0.0, 0.0, 1.0)  # its rotation there, (x, y, z, w)
    link: NonEmpty | None = None  # the link that carries it; None: it is fixed in the base frame


@final
@dataclass(frozen=True)
class LaserLine:
    """The laser."""

    output: Annotated[int, Meta(ge=1)] | None = None  # the controller's output that switches it; None: it is always on


@final
@dataclass(frozen=True)
class CellFile:
    """cell.toml."""

    format: str
    arm: ArmLine
    camera: CameraLine
    laser: LaserLine = LaserLine()
    limits: Limits = Limits()
    box: tuple[Box, ...] = ()


@final
@dataclass(frozen=True)
class Cell:
    """A folder with cell.toml and the dataset.toml of its recordings."""

    description: Dataset  # robot, sensor and target, without a pose
    arm: ArmLine  # the arm's controller
    camera: CameraLine  # the camera
    laser_output: int | None  # the controller's output that switches the laser; None: it is always on
    limits: Limits  # of all poses
    boxes: tuple[Box, ...] = ()  # obstacles in the cell, and bodies on links
    warnings: tuple[str, ...] = ()  # doubtful settings that are no errors

    @property
    def robot(self) -> Robot:
        """Its arm."""
        assert self.description.robot is not None  # a cell without one is not read
        return self.description.robot

    @property
    def folder(self) -> Path:
        """The folder that it was read from."""
        assert self.description.folder is not None  # it was read from there
        return self.description.folder

    @property
    def pictures(self) -> Path | None:
        """The folder of images in place of its camera; None for a live camera."""
        source = self.camera.source
        if isinstance(source, int) or "://" in source or source.startswith("/dev/"):
            return None
        return self.folder / source

    @property
    def inputs(self) -> list[Path]:
        """Folders that a recording reads: the cell's own, and recordings in place of its arm or its camera."""
        replayed = self.folder / self.arm.port if self.arm.kind == "replay" else None
        return [folder for folder in (self.folder, replayed, self.pictures) if folder is not None]


def load_cell(folder: str | Path) -> Cell:
    """Read and check a cell.

    Raises:
        DataError: With file and key of the error; or there is no arm.
        RobotError: The URDF, its flange or its joints are not usable.
    """
    folder = Path(folder)
    contents = read_toml(folder / FILE, FORMAT, "A cell is a folder with dataset.toml, cell.toml and the robot's URDF.")
    read = typed(contents, CellFile, file=FILE)
    description = describe(folder)
    if description.robot is None:
        raise lacking("dataset.toml", "[robot]", ": there is no arm to move. Name its urdf, flange and joints")
    _check_arm(read.arm, len(description.robot.joints))
    _check_boxes(read.box, description.robot)
    warnings = (*description.warnings, *_warnings(read.arm, read.limits))
    return Cell(description, read.arm, read.camera, read.laser.output, read.limits, read.box, warnings)


def _warnings(arm: ArmLine, limits: Limits) -> list[str]:
    kept = {"floor_m": "no part of the arm is kept from the floor", "reach_m": "the arm may stretch as far as it goes"}
    warnings = [f"{FILE}, [limits] has no {key}: {why}." for key, why in kept.items() if getattr(limits, key) is None]
    if arm.unattended_s > MOST_UNATTENDED_S:
        on = f"if this computer dies, the arm moves on for up to {arm.unattended_s:g} s"
        only = f"Use more than {MOST_UNATTENDED_S:g} s only with an emulator."
        warnings.append(f"{FILE}, [arm] unattended_s: {on}. {only}")
    return warnings


def _check_arm(arm: ArmLine, joints: int) -> None:
    for name in ("ids", "reference_rad", "direction"):
        values = getattr(arm, name)
        if values and len(values) != joints:
            raise wrong(FILE, ("arm", name), list(values), f"a list of {joints}: one for each joint")
    if not set(arm.direction) <= {-1.0, 1.0}:
        raise wrong(FILE, ("arm", "direction"), list(arm.direction), "+1 or -1 for each joint")
    if arm.kind == "acl" and arm.axes is None:
        why = "a SCORBOT's counts mean other angles on other arms"
        how = '"er7" if each encoder counts its joint, as on the ER VII, or axes = "er5plus" for the ER V plus'
        raise lacking(FILE, "[arm] axes", f": {why}. State axes = {how}")
    if len(set(arm.ids)) < len(arm.ids):
        raise wrong(FILE, ("arm", "ids"), list(arm.ids), "different whole numbers from 0 to 253")


def _check_boxes(boxes: tuple[Box, ...], robot: Robot) -> None:
    links = robot.links
    names = [box.name for box in boxes]
    for number, box in enumerate(boxes):
        if box.name in links or box.name in names[:number]:
            raise wrong(FILE, ("box", "name"), box.name, "a name that no other box and no link has")
        if box.link is not None and box.link not in links:
            raise unknown_frame(f"{FILE}, [[box]] {box.name}", box.link, links)
        check_rotation(box.quat, f"{FILE}, [[box]] quat, entry {number + 1}", FILE)
