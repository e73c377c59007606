"""WORLD.toml: what a cell truly is, and what lies in it."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.challenge.worlds.arm import Arm
from robolaser.dataset import Board, Dataset
from robolaser.emulator.departures import DEPARTURES, Departure
from robolaser.emulator.rendering import Block, Checkerboard, Eye, Floor, Scene, Sheet, Solid, Sphere
from robolaser.emulator.world.world import Sensor, World
from robolaser.errors import (
    BoardNotDrawn,
    DepartureNowhere,
    DepartureUnknown,
    FormatUnknown,
    NoScannerToEmulate,
    NotToml,
    SettingWrong,
    WorldKeyUnknown,
)
from robolaser.settings import Settings
from robolaser.tables import read_text

FORMAT = "robolaser-world/1"
SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
SURFACE = ("tone", "shine")
KEYS = {
    "": ("format", "truth", "light", "camera", "floor", "board", "block", "sphere", "effect"),
    "truth": SCANNER,
    "light": ("power_grey", "width_m", "distance_m", "speckle"),
    "camera": ("ambient_grey", "noise_grey", "blur_px", "exposure", "lens_error"),
    "floor": ("height_m", *SURFACE),
    "board": ("origin_m", "quat", "border_m", "square_m", "white", "black", "shine"),
    "block": ("origin_m", "quat", "size_m", *SURFACE),
    "sphere": ("centre_m", "radius_m", *SURFACE),
}
SECTIONS = ("truth", "light", "camera")
UPWARD = (0.0, 0.0, 0.0, 1.0)
FACING_UP = (1.0, 0.0, 0.0, 0.0)
"""Of a board on the floor: its z points into the board."""


def load_world(path: str | Path, description: Dataset) -> World:
    """Read and check a world.

    Args:
        path: Of WORLD.toml.
        description: The cell's robot, scanner and board.

    Raises:
        RobolaserError: With file and key of what is wrong.
    """
    path = Path(path)
    try:
        said: dict[str, Any] = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise NotToml(path, str(error)) from None
    whole = _section(path, "", said)
    sections = {name: _section(path, name, _table(path, name, said.get(name, {}))) for name in SECTIONS}
    found = whole.text("format")
    if found != FORMAT:
        raise FormatUnknown(path.name, found, FORMAT)
    robot, size = description.robot, description.image_px
    if robot is None or size is None:
        raise NoScannerToEmulate(path.name)
    eye = _eye(sections["truth"], sections["camera"], description, size)
    sensor = _sensor(sections["camera"], sections["light"])
    scene = Scene(tuple(_solids(path, said, description.board)))
    arm = Arm(robot)
    return World(arm, eye, _sheet(sections["light"], eye.truth), scene, sensor, _departures(path, said, arm))


def _eye(said: Settings, camera: Settings, description: Dataset, size: tuple[int, int]) -> Eye:
    drawn = {name: item.nominal for name, item in description.parameters.items()}
    k1, k2, p1, p2, k3 = camera.numbers("lens_error", 5, default=(0.0, 0.0, 0.0, 0.0, 0.0))
    return Eye(
        {name: said.number(name, default=drawn.get(name)) for name in SCANNER},
        description.bracket_quat,
        description.angles,
        description.stripe_axis,
        *size,
        lens_error=(k1, k2, p1, p2, k3),
    )


def _sheet(said: Settings, truth: Mapping[str, float]) -> Sheet:
    def length(key: str, usual: float) -> float:
        return said.number(key, positive=True, default=usual)

    return Sheet(
        truth["b"],
        truth["theta"],
        power=length("power_grey", Sheet.power),
        width_m=length("width_m", Sheet.width_m),
        distance_m=length("distance_m", Sheet.distance_m),
    )


def _sensor(said: Settings, light: Settings) -> Sensor:
    return Sensor(
        ambient_grey=said.number("ambient_grey", default=Sensor.ambient_grey),
        noise_grey=said.number("noise_grey", default=Sensor.noise_grey),
        speckle=light.number("speckle", default=Sensor.speckle),
        blur_px=said.number("blur_px", default=Sensor.blur_px),
        exposure=said.number("exposure", positive=True, default=Sensor.exposure),
    )


def _solids(path: Path, said: Mapping[str, Any], drawn: Board | None) -> Iterable[Solid]:
    if "floor" in said:
        floor = _section(path, "floor", _table(path, "floor", said["floor"]))
        yield Floor(floor.number("height_m", default=0.0), *_surface(floor, Floor.tone))
    for block in _sections(path, "block", said):
        size = block.numbers("size_m", 3, default=())
        yield Block(_placement(block, UPWARD), (size[0], size[1], size[2]), *_surface(block, Block.tone))
    for sphere in _sections(path, "sphere", said):
        centre = np.array(sphere.numbers("centre_m", 3, default=()))
        yield Sphere(centre, sphere.number("radius_m", positive=True), *_surface(sphere, Sphere.tone))
    if "board" in said:
        board = _section(path, "board", _table(path, "board", said["board"]))
        if drawn is None:
            raise BoardNotDrawn(path.name)
        yield Checkerboard(
            _placement(board, FACING_UP),
            drawn.columns,
            drawn.rows,
            board.number("square_m", positive=True, default=drawn.square_m),
            board.number("border_m", default=Checkerboard.border_m),
            board.number("white", default=Checkerboard.white),
            board.number("black", default=Checkerboard.black),
            board.number("shine", default=Checkerboard.shine),
        )


def _departures(path: Path, said: Mapping[str, Any], arm: Arm) -> list[Departure]:
    known = {kind.name: kind for kind in DEPARTURES}
    departures = []
    for effect in _sections(path, "effect", said):
        name = effect.text("name")
        if name not in known:
            raise DepartureUnknown(path.name, name, known)
        kind = known[name]
        places = arm.joints if kind.on_joints else ("laser",)
        where = effect.text("where")
        if where not in places:
            raise DepartureNowhere(path.name, name, where, places)
        shape = {one.name: effect.number(one.name) for one in fields(kind)[2:] if one.name in effect}
        departures.append(kind(where, effect.number("size"), **shape))
    return departures


def _section(path: Path, name: str, values: Mapping[str, Any]) -> Settings:
    for key in values:
        if name in KEYS and key not in KEYS[name]:
            raise WorldKeyUnknown(path.name, name, key, KEYS[name])
    return Settings(name, values, path.name)


def _sections(path: Path, name: str, said: Mapping[str, Any]) -> list[Settings]:
    several = said.get(name, [])
    if not isinstance(several, list):
        raise SettingWrong(name, several, f"sections [[{name}]]", path.name)
    return [_section(path, name, _table(path, name, values)) for values in several]


def _table(path: Path, name: str, values: Any) -> Mapping[str, Any]:
    if not isinstance(values, dict):
        raise SettingWrong(name, values, f"a section [{name}]", path.name)
    return values


def _surface(said: Settings, tone: float) -> tuple[float, float]:
    return said.number("tone", default=tone), said.number("shine", default=0.0)


def _placement(said: Settings, quat: tuple[float, float, float, float]) -> Array:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat(said.numbers("quat", 4, default=quat)).as_matrix()
    T[:3, 3] = said.numbers("origin_m", 3, default=())
    return T
