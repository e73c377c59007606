"""A cell: what moves the sensor, what sees, what lights, and what it must never do."""

from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.data.dataset import Dataset
from robolaser.data.loading import describe
from robolaser.data.toml_schema import Settings, read_settings
from robolaser.errors import CellWithoutRobot, FormatUnknown, NotACell, SettingWrong
from robolaser.geometry.kinematics import Robot

FILE = "cell.toml"
FORMAT = "robolaser-cell/1"
USUAL_BAUD = 9600
USUAL_SETTLE_S = 0.3
ADDRESSES = range(254)
"""Of servos; 254 is everybody's."""
USUAL_SPEED_RAD_S = 0.3  # a quarter turn in five seconds: slow enough to reach the button


@final
@dataclass(frozen=True)
class ArmLine:
    """The arm's controller and the line to it.

    Attributes:
        kind: Name of its language, see `robolaser.cell.arms.ARMS`.
        port: A device or any URL that pyserial opens.
        baud: Bits a second.
        flow: "none" or "xonxoff".
        ids: Addresses of the servos, base first, where the language has addresses; empty: 1, 2, ...
        reference_rad: Joint angles at the controller's reference posture; empty: all zero.
        direction: +1 or -1 for each joint: which way it counts; empty: all +1.
        home: Whether it searches its home before it measures.
    """

    kind: str
    port: str
    baud: int = USUAL_BAUD
    flow: str = "none"
    ids: tuple[int, ...] = ()
    reference_rad: tuple[float, ...] = ()
    direction: tuple[float, ...] = ()
    home: bool = False


@final
@dataclass(frozen=True)
class CameraLine:
    """The camera.

    Attributes:
        source: Whatever OpenCV's VideoCapture opens: a number, a device, a file, images "%04d.png", a stream's URL.
        exposure: In the driver's own unit; None: as it is.
        gain: Likewise.
        settle_s: Wait between the arm's rest, or the laser's switching, and the shot [s].
    """

    source: str | int
    exposure: float | None = None
    gain: float | None = None
    settle_s: float = USUAL_SETTLE_S


@final
@dataclass(frozen=True)
class Limits:
    """What no pose may break.

    Links are straight lines between their joints here, as thick as nothing, so the ends of each say how low it reaches:
    state a floor higher than the real one by half of what the thickest link measures. Only the flange's reach counts.

    Attributes:
        floor_m: Height in the base frame that no joint, flange, camera or light projector goes below [m]; None: no
            floor.
        reach_m: Farthest that the flange may be from the foot of the first joint [m]; None: as far as the arm goes.
        speed_rad_s: Fastest that any joint turns [rad/s or m/s].
    """

    floor_m: float | None = None
    reach_m: float | None = None
    speed_rad_s: float = USUAL_SPEED_RAD_S


@final
@dataclass(frozen=True)
class Cell:
    """A folder with dataset.toml, as its recordings will have it, and cell.toml.

    Attributes:
        description: Robot, sensor and target, without a pose.
        arm: The arm's controller.
        camera: The camera.
        laser_output: The controller's output that switches the laser; None: it is always on.
        limits: What no pose may break.
        warnings: What is odd, but no error.
    """

    description: Dataset
    arm: ArmLine
    camera: CameraLine
    laser_output: int | None
    limits: Limits
    warnings: tuple[str, ...] = ()

    @property
    def robot(self) -> Robot:
        """Its arm."""
        assert self.description.robot is not None  # a cell without one is not read
        return self.description.robot

    @property
    def folder(self) -> Path:
        """Where it lies."""
        assert self.description.folder is not None  # it was read from there
        return self.description.folder

    def beside(self, path: str) -> Path:
        """A path that cell.toml names, absolute or from the cell's folder."""
        return self.folder / path


def load_cell(folder: str | Path) -> Cell:
    """Read and check a cell.

    Raises:
        CellWithoutRobot: There is no arm in it.
        RobolaserError: With file and key of what is wrong.
    """
    folder = Path(folder)
    if not (folder / FILE).is_file():
        raise NotACell(folder)
    settings = read_settings(folder / FILE)
    found = settings.text("format")
    if found != FORMAT:
        raise FormatUnknown(FILE, found, FORMAT)
    description = describe(folder)
    if description.robot is None:
        raise CellWithoutRobot(folder)
    joints = len(description.robot.joints)
    limits, laser = settings.section("limits"), settings.section("laser")
    return Cell(
        description=description,
        arm=_arm(settings.section("arm"), joints),
        camera=_camera(settings.section("camera")),
        laser_output=laser.count("output", least=1) if "output" in laser else None,
        limits=Limits(
            floor_m=_maybe(limits, "floor_m"),
            reach_m=_maybe(limits, "reach_m"),
            speed_rad_s=limits.number("speed_rad_s", positive=True, default=USUAL_SPEED_RAD_S),
        ),
        warnings=(*description.warnings, *settings.passed_over(), *_unlimited(limits)),
    )


def _unlimited(limits: Settings) -> list[str]:
    kept = {"floor_m": "no part of the arm is kept from the floor", "reach_m": "the arm may stretch as far as it goes"}
    return [f"{FILE}, [limits] has no {key}: {what}." for key, what in kept.items() if key not in limits]


def _arm(said: Settings, joints: int) -> ArmLine:
    def each(key: str) -> tuple[float, ...]:
        return said.numbers(key, joints, default=()) if key in said else ()

    direction, ids = each("direction"), each("ids")
    if not set(direction) <= {-1.0, 1.0}:
        raise SettingWrong(said.key("direction"), list(direction), "+1 or -1 for each joint", FILE)
    if len(set(ids)) < len(ids) or not set(ids) <= set(ADDRESSES):
        expected = f"different whole numbers from {ADDRESSES[0]} to {ADDRESSES[-1]}"
        raise SettingWrong(said.key("ids"), list(ids), expected, FILE)
    return ArmLine(
        kind=said.text("kind"),
        port=said.text("port"),
        baud=said.count("baud", least=1, default=USUAL_BAUD),
        flow=said.text("flow", default="none", one_of=("none", "xonxoff")),
        ids=tuple(int(number) for number in ids),
        reference_rad=each("reference_rad"),
        direction=direction,
        home=said.flag("home", default=False),
    )


def _camera(said: Settings) -> CameraLine:
    return CameraLine(
        source=said.text_or_count("source"),
        exposure=_maybe(said, "exposure"),
        gain=_maybe(said, "gain"),
        settle_s=said.number("settle_s", positive=True, default=USUAL_SETTLE_S),
    )


def _maybe(said: Settings, key: str) -> float | None:
    return said.number(key) if key in said else None
