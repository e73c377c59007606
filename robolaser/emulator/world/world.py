"""The world of an emulated cell: the true arm, scanner and solids, their current state, and its world.toml."""

import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, make_dataclass
from pathlib import Path
from typing import Any, Literal, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array, Image
from robolaser.data.board import Board, board_print
from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import check_rotation
from robolaser.data.toml_schema import Positive, read_toml, typed, wrong
from robolaser.emulator.servo_loop import SERVO_FAULTS, ServoLoop
from robolaser.emulator.world.scene import CameraModel, CameraSettings, Projector, RenderedScene
from robolaser.emulator.world.solids import Cuboid, Floor, PrintedBoard, Solid, Sphere, Vector
from robolaser.errors import DataError, near
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.robot.kinematics import Robot
from robolaser.trials.synthetic.scanner import Light, ScannerOptics

FORMAT = "robolaser-world/1"
SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
PINHOLE, LENS = ("fx", "fy", "cx", "cy"), ("k1", "k2", "p1", "p2", "k3")
POSITIVE = ("f", "s_u", "s_v", "fx", "fy")
SAME_PLACE_M = 1e-5  # change of the camera's position, and of its rotation in radians, without new speckle


@final
class EmulatedWorld:
    """The true state of a world: nominal arm, solids, camera and laser, and the sensor's true numbers by name, SI.

    Faults are sizes by name and joint [rad]: `joint_offset` of an encoder's zero, and `backlash`, by half of which the
    link trails its motor. Without a loop the joints follow their commands exactly.
    """

    def __init__(
        self,
        arm: Robot,
        scene: RenderedScene,
        truth: Mapping[str, float],
        faults: Mapping[tuple[str, str], float],
        loop: ServoLoop | None = None,
    ) -> None:
        self.arm, self.scene, self.truth, self.faults, self.loop = arm, scene, truth, faults, loop
        self._offset, play = (
            np.array([faults.get((name, joint), 0.0) for joint in arm.joints]) for name in ("joint_offset", "backlash")
        )
        self._half_play = play / 2
        self._none = np.zeros(len(arm.joints))
        self._at: tuple[Array, Array] | None = None
        """Encoder angles and backlash offsets; replaced as a whole, since images are taken concurrently."""
        self._rendered: tuple[bytes, Array, Array] | None = None

    def follow(self, motor: Array) -> None:
        """Move straight from the last encoder angles to the current ones, (j,) [rad].

        The first call places the arm there, in the middle of all play.
        """
        before, lag = self._at or (motor, self._none)
        self._at = np.array(motor, dtype=np.float64), np.clip(lag + motor - before, -self._half_play, self._half_play)

    @property
    def q(self) -> Array:
        """True joint angles, (j,) [rad]; zero before the first `follow`."""
        motor, lag = self._at or (self._none, self._none)
        return np.asarray(motor + self._offset - lag)

    @property
    def T_base_flange(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the flange, (4, 4)."""
        return np.asarray(self.arm.forward(self.q))

    @property
    def T_base_camera(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the camera, (4, 4)."""
        return np.asarray(self.T_base_flange @ self.scene.eye.optics.mount)

    def photograph(self, rng: np.random.Generator, *, lit: bool) -> Image:
        """An image, (height, width), at the current pose: noise is new, speckle constant while nothing moves."""
        T = self.T_base_camera
        key = T.tobytes()
        if self._rendered is None or self._rendered[0] != key:
            self._rendered = key, *self.scene.render(T)
        _, room, laser = self._rendered
        grain = np.random.default_rng(zlib.crc32(np.rint(T / SAME_PLACE_M).astype(np.int64).tobytes()))
        return self.scene.expose(room, laser if lit else np.zeros_like(laser), rng=rng, grain=grain)


@final
@dataclass(frozen=True)
class BoardTable:
    """`[board]`; by default its pattern faces upwards: its z points into the board."""

    origin_m: Vector
    quat: Quaternion = (1.0, 0.0, 0.0, 0.0)


@final
@dataclass(frozen=True)
class EffectTable:
    """`[[effect]]`."""

    name: Literal["backlash", "joint_offset", "dead_time", "lag", "dead_zone", "droop"]
    where: str
    size: float


@final
@dataclass(frozen=True)
class WorldFile:
    """The whole file."""

    format: str
    truth: dict[str, Any] = field(default_factory=dict)
    light: Projector = Projector()
    camera: CameraSettings = CameraSettings()
    floor: Floor | None = None
    board: BoardTable | None = None
    block: tuple[Cuboid, ...] = ()
    sphere: tuple[Sphere, ...] = ()
    effect: tuple[EffectTable, ...] = ()


def _table(name: str, *numbers: str, **tables: type) -> type:
    """A table of numbers, None where they are nominal, and of tables."""
    fields = [(key, (Positive if key in POSITIVE else float) | None, None) for key in numbers]
    return make_dataclass(name, [*fields, *((key, table, table()) for key, table in tables.items())], frozen=True)


TRUTHS: Mapping[str, type] = {  # `[truth]` by the kind of sensor
    "stripe": _table("Scanner", *SCANNER),
    "camera": _table("Camera", *PINHOLE, *LENS, hand_eye=_table("HandEye", "x", "y", "z", "w", "phi", "psi")),
}


def load_world(path: str | Path, description: Dataset) -> EmulatedWorld:
    """Read and check a world.toml for the robot, scanner and board of a cell; errors name file and key."""
    path = Path(path)
    read = typed(read_toml(path, FORMAT), WorldFile, file=path.name)
    robot, size = description.robot, description.image_px
    fixed = description.kind == "camera" and description.options.mount == "base"
    if robot is None or size is None or description.kind not in TRUTHS or fixed:
        raise DataError(
            f"{path.name} describes a world for a camera on an arm, but dataset.toml has no [robot], or its sensor is"
            " neither a stripe scanner nor a camera on the flange, with an [image]. Emulate this cell without --world.",
            file=path,
        )
    truth, light = _truth(path.name, read.truth, description), None
    if description.kind == "stripe":
        optics = ScannerOptics(truth, description.bracket_quat, description.angles, description.stripe_axis)
        flat = np.array(0.0)
        light = Light(truth["b"], np.array(truth["theta"]), flat, flat)
        eye = CameraModel(optics, optics.lens, *size, read.camera)
    else:
        eye = CameraModel(_optics_of_camera(truth), np.array([truth[name] for name in LENS]), *size, read.camera)
    scene = RenderedScene(tuple(_solids(path.name, read, description.board)), eye, light, read.light)
    faults = _faults(path.name, read.effect, robot)
    in_servos = any(name in SERVO_FAULTS for name, _ in faults)
    return EmulatedWorld(robot, scene, truth, faults, ServoLoop(robot, faults) if in_servos else None)


def _truth(file: str, stated: Mapping[str, Any], description: Dataset) -> dict[str, float]:
    """The sensor's numbers: stated, else nominal; for a lens without values, 0."""
    values = asdict(typed(stated, TRUTHS[description.kind], file=file, at=("truth",)))
    values |= {f"hand_eye.{name}": value for name, value in values.pop("hand_eye", {}).items()}
    truth = {}
    for name, value in values.items():
        nominal = description.parameters[name].nominal if name in description.parameters else None
        number = nominal if value is None else value
        if number is None and name not in LENS:
            raise wrong(file, ("truth", name), number, "a finite number")
        truth[name] = number or 0.0
    return truth


def _optics_of_camera(truth: Mapping[str, float]) -> ScannerOptics:
    """A camera as a scanner of focal length 1 m without distortion."""
    fx, fy, cx, cy = (truth[name] for name in PINHOLE)
    pinhole = {"f": 1.0, "s_u": 1 / fx, "s_v": 1 / fy, "u_0": cx, "v_0": cy, "k": 0.0}
    turns = {name: truth[f"hand_eye.{name}"] for name in ("w", "phi", "psi")}
    origin = {f"t_{name}": truth[f"hand_eye.{name}"] for name in "xyz"}
    return ScannerOptics({**pinhole, **turns, **origin}, (0.0, 0.0, 0.0, 1.0), "xyz", "v")


def _solids(file: str, read: WorldFile, described: Board | None) -> Iterator[Solid]:
    if read.floor is not None:
        yield read.floor
    for block in read.block:
        check_rotation(block.quat, f"{file}, [[block]] quat", file)
        yield block
    yield from read.sphere
    if read.board is not None:
        if described is None:
            raise DataError(
                f"{file} has a [board], but dataset.toml has none, so its corners and squares are not known: add"
                " [board] with columns, rows and square_m there.",
                file=file,
                column="board",
            )
        yield _printed_board(file, read.board, described)


def _printed_board(file: str, board: BoardTable, described: Board) -> PrintedBoard:
    check_rotation(board.quat, f"{file}, [board] quat", file)
    T: Array = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_quat(board.quat).as_matrix(), board.origin_m
    return PrintedBoard(T, board_print(described))


def _faults(file: str, stated: Iterable[EffectTable], arm: Robot) -> dict[tuple[str, str], float]:
    """Sizes of faults by name and joint."""
    faults: dict[tuple[str, str], float] = {}
    for fault in stated:
        if fault.where not in arm.joints:
            reason = f"{fault.name} cannot be at '{fault.where}'.{near(fault.where, arm.joints)}"
            raise DataError(f"{file}, [[effect]] where: {reason}", file=file, column="where")
        if fault.size < 0.0 and fault.name != "joint_offset":
            raise wrong(file, ("effect", "size"), fault.size, f"0 or more: {fault.name} has no sign")
        if (fault.name, fault.where) in faults:
            raise wrong(file, ("effect", "where"), fault.where, f"one {fault.name} at most at each joint")
        faults[fault.name, fault.where] = fault.size
    return faults
