"""WORLD.toml: what a cell truly is, and what lies in it."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.csv_tables import read_text
from robolaser.data.dataset import Board, Dataset
from robolaser.data.toml_schema import Settings
from robolaser.emulator.physics import DEPARTURES, Departure
from robolaser.emulator.rendering import Block, Checkerboard, Eye, Floor, Scene, Sheet, Solid, Sphere
from robolaser.emulator.world.world import Sensor, World
from robolaser.errors import (
    BoardNotDrawn,
    DepartureNowhere,
    DepartureUnknown,
    FormatUnknown,
    NoScannerToEmulate,
    NotARotation,
    NotToml,
    SettingWrong,
    WorldKeyUnknown,
)
from robolaser.trials.worlds.arm import Arm

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
OF_EFFECTS = ("name", "where", "size")
POSITIVE = ("f", "s_u", "s_v")
ROUNDED = 0.01
"""How far a quaternion's length may be from one: files round their digits."""
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
    sensor = _sensor(path, sections["camera"], sections["light"])
    scene = Scene(tuple(_solids(path, said, description.board)))
    arm = Arm(robot)
    return World(arm, eye, _sheet(sections["light"], eye.truth), scene, sensor, _departures(path, said, arm))


def _eye(said: Settings, camera: Settings, description: Dataset, size: tuple[int, int]) -> Eye:
    drawn = {name: item.nominal for name, item in description.parameters.items()}
    k1, k2, p1, p2, k3 = camera.numbers("lens_error", 5, default=(0.0, 0.0, 0.0, 0.0, 0.0))
    return Eye(
        {name: said.number(name, positive=name in POSITIVE, default=drawn.get(name)) for name in SCANNER},
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


def _sensor(path: Path, said: Settings, light: Settings) -> Sensor:
    return Sensor(
        ambient_grey=_some(path, said, "ambient_grey", Sensor.ambient_grey),
        noise_grey=_some(path, said, "noise_grey", Sensor.noise_grey),
        speckle=_some(path, light, "speckle", Sensor.speckle),
        blur_px=_some(path, said, "blur_px", Sensor.blur_px),
        exposure=said.number("exposure", positive=True, default=Sensor.exposure),
    )


def _solids(path: Path, said: Mapping[str, Any], drawn: Board | None) -> Iterable[Solid]:
    if "floor" in said:
        floor = _section(path, "floor", _table(path, "floor", said["floor"]))
        yield Floor(floor.number("height_m", default=0.0), *_surface(path, floor, Floor.tone))
    for block in _sections(path, "block", said):
        size = block.numbers("size_m", 3, default=())
        if min(size) <= 0:
            raise SettingWrong(block.key("size_m"), list(size), "three lengths above 0", path.name)
        yield Block(_placement(path, block, UPWARD), (size[0], size[1], size[2]), *_surface(path, block, Block.tone))
    for sphere in _sections(path, "sphere", said):
        centre = np.array(sphere.numbers("centre_m", 3, default=()))
        yield Sphere(centre, sphere.number("radius_m", positive=True), *_surface(path, sphere, Sphere.tone))
    if "board" in said:
        board = _section(path, "board", _table(path, "board", said["board"]))
        if drawn is None:
            raise BoardNotDrawn(path.name)
        yield Checkerboard(
            _placement(path, board, FACING_UP),
            drawn.columns,
            drawn.rows,
            board.number("square_m", positive=True, default=drawn.square_m),
            _some(path, board, "border_m", Checkerboard.border_m),
            _some(path, board, "white", Checkerboard.white),
            _some(path, board, "black", Checkerboard.black),
            _some(path, board, "shine", Checkerboard.shine),
        )


def _departures(path: Path, said: Mapping[str, Any], arm: Arm) -> list[Departure]:
    known = {kind.name: kind for kind in DEPARTURES}
    departures = []
    for effect, keys in zip(_sections(path, "effect", said), said.get("effect", ()), strict=True):
        name = effect.text("name")
        if name not in known:
            raise DepartureUnknown(path.name, name, known)
        kind = known[name]
        places = arm.joints if kind.on_joints else ("laser",)
        where = effect.text("where")
        if where not in places:
            raise DepartureNowhere(path.name, name, where, places)
        shapes = [one.name for one in fields(kind) if one.name not in OF_EFFECTS]
        for key in sorted(keys.keys() - {*OF_EFFECTS, *shapes}):
            raise WorldKeyUnknown(path.name, "[effect]", key, [*OF_EFFECTS, *shapes])
        shape = {one: effect.number(one) for one in shapes if one in effect}
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


def _surface(path: Path, said: Settings, tone: float) -> tuple[float, float]:
    return _some(path, said, "tone", tone), _some(path, said, "shine", 0.0)


def _some(path: Path, said: Settings, key: str, usual: float) -> float:
    value = said.number(key, default=usual)
    if value < 0:
        raise SettingWrong(said.key(key), value, "0 or more", path.name)
    return value


def _placement(path: Path, said: Settings, usual: tuple[float, float, float, float]) -> Array:
    T, quat = np.eye(4), said.numbers("quat", 4, default=usual)
    norm = float(np.linalg.norm(quat))
    if abs(norm - 1) > ROUNDED:
        raise NotARotation(f"{path.name}, {said.key('quat')}", norm)
    T[:3, :3] = Rotation.from_quat(quat).as_matrix()
    T[:3, 3] = said.numbers("origin_m", 3, default=())
    return T
