"""The data sets of the frozen answers by group, each with its known truth."""

import itertools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.errors import RobolaserError
from robolaser.simulation import CellOptions, simulate
from robolaser.trials.building import Ranges
from robolaser.trials.kinds import IN_IMAGES, KINDS
from robolaser.trials.making import make
from robolaser.trials.score import UNKNOWN

REAL = ("ur5-tracker", "mukca-dinova_1", "rosi-two-axis", "mukca-panda_1", "mukca-panda_3", "ur3e-hand-eye-2",
        "etna-s1", "etna-s2", "ur10-tracker-b")  # fmt: skip
SLOW = ("ur10-tracker-a", "etna-s3")  # real sets that take over a minute of CPU
IMAGES = ("etna-s1", "etna-s2", "etna-s3")  # recordings, converted to data sets by `extract`

SCATTER_RAD = (1e-4, 1e-3, 2e-3, 5e-3)  # of all joints, never stated
HARMLESS_RAD = 1e-4  # this scatter is no gap
SEEN_BY = {  # sensor, seed, and its stated noise
    "point": (301, Noise(point_m=2e-5)),
    "stripe": (302, Noise(pixel_px=0.1, target_m=3e-5)),
    "camera": (303, Noise(pixel_px=0.1)),
    "pose": (304, Noise(point_m=2e-5, angle_rad=5e-5)),
}

OF_BLIND = {  # library names of effects with other names in the sealed truth
    "form:soft base": "base_compliance",
    "soft_base": "base_compliance",
    "form:bracket sags": "hand_eye_sag",
}
CLEAR = 1e6  # assumed squared misfit of an effect where the truth has none
CLASSES = {effect.name: effect.cause or effect.name for effect in robolaser.EFFECTS}
KEPT = ("effect", "where", "misfit", "rivals", "also_right", "sites", "classes", "withheld")

CELLS = (("scorbot_er7", False), ("panda", True), ("ur5", False), ("scorbot_er7", True), ("ur5", True))
"""Arm of a fresh world, and whether a tracker measures it, in turn."""
RANGES = Ranges(poses=(30, 45), points=(5, 7))
ROUNDS = 10
GROUPS = ("real", "scatter", "blind-dev", "blind-hard", "removed", "fresh", "slow")


@dataclass(frozen=True)
class World:
    """A data set of a group."""

    name: str
    group: str
    load: Callable[[], tuple[Dataset, dict[str, Any] | None]]  # the data, and the known truth
    without: tuple[str, ...] = ()  # effects removed from the library


def worlds(group: str, data: Path, fresh: Path | None) -> Iterator[World]:
    """The worlds of a group; `fresh` is the folder that `make_fresh` filled."""
    if group in ("real", "slow"):
        yield from (_real(data / name, group) for name in (REAL if group == "real" else SLOW))
    elif group == "scatter":
        yield from (_scattered(sensor, rad) for sensor in SEEN_BY for rad in SCATTER_RAD)
    elif group == "fresh":
        yield from _fresh(fresh) if fresh else ()
    elif group == "removed":
        yield from _removed(data / "blind-dev")
        yield from _removed(data / "blind-hard")
    else:
        for name, truth in _truths(data / group):
            yield World(name, group, lambda name=name, truth=truth: (robolaser.load(data / group / name), truth))


def _real(folder: Path, group: str) -> World:
    def load() -> tuple[Dataset, None]:
        points = _cache(folder.name) if folder.name in IMAGES else folder
        if not (points / "points.csv").exists():
            command = [sys.executable, "-m", "robolaser", "extract", str(folder), "--output", str(points), "--force"]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return robolaser.load(points), None

    return World(folder.name, group, load)


def _scattered(sensor: str, rad: float) -> World:
    """A UR5 with unstated scatter of its joints."""

    def load() -> tuple[Dataset, dict[str, Any]]:
        seed, noise = SEEN_BY[sensor]
        drawn = Noise(**{**{k: v for k, v in vars(noise).items() if v}, "joint_rad": rad})
        made = simulate(
            robolaser.find_robot("ur5"),
            kind=sensor,
            poses=40,
            noise=drawn,
            options=CellOptions(stated=noise),
            seed=seed,
        )
        return made.dataset, {"scatter_rad": rad}

    return World(f"{sensor}-{1e3 * rad:g}-mrad", "scatter", load)


def _truths(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, truth in json.loads((folder / "truth.json").read_text(encoding="utf-8")).items():
        yield name, compact(truth)


def _removed(folder: Path) -> Iterator[World]:
    """The worlds of a folder, with their true effects removed from the library."""
    library = {effect.name for effect in robolaser.EFFECTS}
    for name, truth in _truths(folder):
        gone = tuple(sorted({item["effect"] for item in truth["each"]} & library))
        if gone:
            for item in truth["each"]:
                item["withheld"] = item["effect"] in gone
            yield World(
                f"{name}-removed",
                "removed",
                lambda name=name, truth=truth: (robolaser.load(folder / name), truth),
                without=gone,
            )


def _fresh(folder: Path) -> Iterator[World]:
    """The fresh worlds, in the order of their creation."""
    for name, truth in json.loads((folder / "truth.json").read_text(encoding="utf-8")).items():
        yield World(name, "fresh", lambda name=name, truth=truth: (robolaser.load(folder / name), truth))


def make_fresh(folder: Path, seed: int) -> None:
    """Write ten worlds of each kind of `robolaser challenge`, for all versions that are compared."""
    truths = {}
    for i, (j, kind) in itertools.product(range(ROUNDS), enumerate(KINDS)):
        (robot, tracked), own = CELLS[(i + j) % len(CELLS)], seed + i * len(KINDS) + j
        name = f"{kind}-{own}"
        try:
            arm, tracked = robolaser.find_robot(robot), tracked and kind not in IN_IMAGES
            world = make(arm, kind, seed=own, ranges=RANGES, tracked=tracked)
        except RobolaserError as e:  # a random fault that this cell cannot have
            print(f"{name}: {e}", file=sys.stderr)
            continue
        robolaser.save(world.dataset, folder / name, overwrite=True)
        truths[name] = compact(world.truth)
    (folder / "truth.json").write_text(json.dumps(truths, indent=1), encoding="utf-8")


def compact(truth: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a truth that decides whether an answer is right, in current names; older truths state less."""
    each = []
    for given in truth.get("each") or [
        {"effect": effect, "where": where} for effect, where in truth.get("effects", [])
    ]:
        item = {name: truth[name] for name in ("also_right", "sites") if name in truth} | dict(given)
        item["effect"] = OF_BLIND.get(given["effect"], given["effect"])
        item["misfit"] = round(given.get("misfit") or CLEAR)
        usual = _usual(item)
        each.append({key: item[key] for key in KEPT if item.get(key) and item[key] != usual.get(key)})
    background: dict[str, list[str]] = {}
    for effect, where in truth.get("background", []):
        background.setdefault(effect, []).append(where)
    short: dict[str, Any] = {"each": each}
    return short | {name: some for name, some in (("kind", truth.get("kind")), ("background", background)) if some}


def sealed(short: Mapping[str, Any]) -> dict[str, Any]:
    """A compact truth in the format of `trials.score`."""
    background = [[effect, where] for effect, places in short.get("background", {}).items() for where in places]
    each = [_usual(item) | item for item in short["each"]]
    return {"kind": short.get("kind", ""), "each": each, "background": background}


def _usual(item: Mapping[str, Any]) -> dict[str, Any]:
    """Default values of a true effect, which `compact` omits."""
    cause = CLASSES.get(item["effect"], UNKNOWN)
    return {"rivals": [], "also_right": [], "sites": [item["where"]], "classes": [cause], "values": {}}


def _cache(name: str) -> Path:
    folder = Path(os.environ.get("ROBOLASER_FROZEN", Path(tempfile.gettempdir()) / "robolaser-frozen")) / name
    folder.parent.mkdir(parents=True, exist_ok=True)
    return folder


def made(world: World) -> tuple[Dataset, dict[str, Any] | None] | None:
    """A world's data and truth; None for a random fault that its cell cannot have."""
    try:
        return world.load()
    except RobolaserError as e:
        print(f"{world.name}: {e}", file=sys.stderr)
        return None
