"""WORLD.toml: what a cell truly is, and what lies in it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import QUATERNION_SLACK, check_format, no_rotation
from robolaser.data.toml_schema import NotNegative, Positive, read_toml, typed, wrong
from robolaser.emulator.rendering import (
    Ball,
    CameraModel,
    Checkerboard,
    Cuboid,
    EmulatedScene,
    Floor,
    LaserSheet,
    Solid,
)
from robolaser.emulator.world.faults import WORLD_FAULTS
from robolaser.emulator.world.world import EmulatedWorld, ImageSensor
from robolaser.errors import DataError, near
from robolaser.trials.synthetic.arm import ScrewArm
from robolaser.trials.synthetic.fault_model import FaultModel

FORMAT = "robolaser-world/1"
SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
POSITIVE = ("f", "s_u", "s_v")
OF_EFFECTS = ("name", "where", "size")
UPWARD = (0.0, 0.0, 0.0, 1.0)
FACING_UP = (1.0, 0.0, 0.0, 0.0)
"""Of a board on the floor: its z points into the board."""

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@final
@dataclass(frozen=True)
class LightTable:
    """`[light]`."""

    power_grey: Positive = LaserSheet.power
    width_m: Positive = LaserSheet.width_m
    distance_m: Positive = LaserSheet.distance_m
    speckle: NotNegative = ImageSensor.speckle


@final
@dataclass(frozen=True)
class CameraTable:
    """`[camera]`."""

    ambient_grey: NotNegative = ImageSensor.ambient_grey
    noise_grey: NotNegative = ImageSensor.noise_grey
    blur_px: NotNegative = ImageSensor.blur_px
    exposure: Positive = ImageSensor.exposure
    lens_error: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


@final
@dataclass(frozen=True)
class FloorTable:
    """`[floor]`."""

    height_m: float = 0.0
    tone: NotNegative = Floor.tone
    shine: NotNegative = 0.0


@final
@dataclass(frozen=True)
class BoardTable:
    """`[board]`."""

    origin_m: Vector
    quat: Quaternion = FACING_UP
    border_m: NotNegative = Checkerboard.border_m
    square_m: Positive | None = None
    white: NotNegative = Checkerboard.white
    black: NotNegative = Checkerboard.black
    shine: NotNegative = Checkerboard.shine


@final
@dataclass(frozen=True)
class BlockTable:
    """`[[block]]`."""

    origin_m: Vector
    size_m: tuple[Positive, Positive, Positive]
    quat: Quaternion = UPWARD
    tone: NotNegative = Cuboid.tone
    shine: NotNegative = 0.0


@final
@dataclass(frozen=True)
class SphereTable:
    """`[[sphere]]`."""

    centre_m: Vector
    radius_m: Positive
    tone: NotNegative = Ball.tone
    shine: NotNegative = 0.0


@final
@dataclass(frozen=True)
class WorldFile:
    """The whole file."""

    format: str
    truth: dict[str, float] = field(default_factory=dict)
    light: LightTable = LightTable()
    camera: CameraTable = CameraTable()
    floor: FloorTable | None = None
    board: BoardTable | None = None
    block: tuple[BlockTable, ...] = ()
    sphere: tuple[SphereTable, ...] = ()
    effect: tuple[dict[str, Any], ...] = ()


def load_world(path: str | Path, description: Dataset) -> EmulatedWorld:
    """Read and check a world.

    Args:
        path: Of WORLD.toml.
        description: The cell's robot, scanner and board.

    Raises:
        RobolaserError: With file and key of what is wrong.
    """
    path = Path(path)
    contents = read_toml(path)
    check_format(contents, FORMAT, path.name)
    read = typed(contents, WorldFile, file=path.name)
    robot, size = description.robot, description.image_px
    if robot is None or size is None:
        raise DataError(
            f"{path.name} describes a world for a camera on an arm, but dataset.toml has no [robot], or its sensor is"
            " not a stripe scanner with an [image]. Emulate this cell without --world.",
            file=path,
        )
    truth = _truth(path.name, read.truth, description)
    eye = CameraModel(
        truth,
        description.bracket_quat,
        description.angles,
        description.stripe_axis,
        *size,
        lens_error=read.camera.lens_error,
    )
    light, camera = read.light, read.camera
    sheet = LaserSheet(
        truth["b"], truth["theta"], power=light.power_grey, width_m=light.width_m, distance_m=light.distance_m
    )
    sensor = ImageSensor(camera.ambient_grey, camera.noise_grey, light.speckle, camera.blur_px, camera.exposure)
    scene = EmulatedScene(tuple(_solids(path.name, read, description.board)))
    arm = ScrewArm(robot)
    return EmulatedWorld(arm, eye, sheet, scene, sensor, _faults(path.name, read.effect, arm))


def _truth(file: str, stated: Mapping[str, float], description: Dataset) -> dict[str, float]:
    """The paper's fourteen: as stated, else as drawn."""
    for name in stated:
        if name not in SCANNER:
            raise _unknown_key(file, "truth", name, SCANNER)
    drawn = {name: item.nominal for name, item in description.parameters.items()}
    truth = {name: stated.get(name, drawn.get(name)) for name in SCANNER}
    for name, value in truth.items():
        if value is None or (name in POSITIVE and value <= 0):
            raise wrong(file, ("truth", name), value, "a positive number" if name in POSITIVE else "a finite number")
    return {name: value for name, value in truth.items() if value is not None}


def _solids(file: str, read: WorldFile, drawn: Board | None) -> Iterable[Solid]:
    if read.floor is not None:
        yield Floor(read.floor.height_m, read.floor.tone, read.floor.shine)
    for block in read.block:
        T_base_block = _placement(file, "[[block]] quat", block.origin_m, block.quat)
        yield Cuboid(T_base_block, block.size_m, block.tone, block.shine)
    for sphere in read.sphere:
        yield Ball(np.array(sphere.centre_m), sphere.radius_m, sphere.tone, sphere.shine)
    if read.board is not None:
        board = read.board
        if drawn is None:
            raise DataError(
                f"{file} has a [board], but dataset.toml has none, so its corners and squares are not known: add"
                " [board] with columns, rows and square_m there.",
                file=file,
                column="board",
            )
        yield Checkerboard(
            _placement(file, "[board] quat", board.origin_m, board.quat),
            drawn.columns,
            drawn.rows,
            board.square_m or drawn.square_m,
            board.border_m,
            board.white,
            board.black,
            board.shine,
        )


def _faults(file: str, stated: Iterable[Mapping[str, Any]], arm: ScrewArm) -> list[FaultModel]:
    faults = []
    for number, effect in enumerate(stated):
        name, where = effect.get("name"), effect.get("where")
        if not isinstance(name, str) or name not in WORLD_FAULTS:
            raise _wrong_effect(file, "name", f"an emulated world cannot have '{name}'.{near(str(name), WORLD_FAULTS)}")
        kind = WORLD_FAULTS[name]
        locations = arm.joints if kind.on_joints else ("laser",)
        if not isinstance(where, str) or where not in locations:
            raise _wrong_effect(file, "where", f"{name} cannot sit at '{where}'.{near(str(where), locations)}")
        for key in sorted(effect.keys() - {*OF_EFFECTS, *kind.parameters}):
            raise _unknown_key(file, "[effect]", key, [*OF_EFFECTS, *kind.parameters])
        values = {"size": effect.get("size"), **{key: effect.get(key, usual) for key, usual in kind.parameters.items()}}
        for key, value in values.items():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise wrong(file, ("effect", number, key), value, "a finite number")
        faults.append(kind.make(where, **{key: float(value) for key, value in values.items()}))
    return faults


def _wrong_effect(file: str, key: str, reason: str) -> DataError:
    return DataError(f"{file}, [[effect]] {key}: {reason}", file=file, column=key)


def _unknown_key(file: str, section: str, key: str, known: Iterable[str]) -> DataError:
    return DataError(f"{file}, [{section}] {key}: there is no such key.{near(key, known)}", file=file, column=key)


def _placement(file: str, key: str, origin_m: Vector, quat: Quaternion) -> Array:
    length = float(np.linalg.norm(quat))
    if abs(length - 1) > QUATERNION_SLACK:
        raise no_rotation(f"{file}, {key}", length, file)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat(quat).as_matrix()
    T[:3, 3] = origin_m
    return T
