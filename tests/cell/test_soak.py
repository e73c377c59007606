"""A hundred bad days: whatever goes wrong, the arm stands, the recording is whole, and it can be gone on with."""

import csv
import errno
import os
import re
from pathlib import Path
from typing import Any

import bench
import numpy as np
import pytest

import robolaser
from robolaser.cell.route import Waypoint, both_ways
from robolaser.errors import Interrupted, RobolaserError

DAYS = 1000 if os.environ.get("GENERATED") == "long" else 100
"""Where none of a hundred fails, less than 3 % of such days do, with 95 % confidence."""
BATCH = 20
POSES = 3
LATEST_S = 12.0
"""A good day lasts 15 to 30 s of the clock on the bench."""
LASTS_S = 20.0
"""Of the clock on the bench: longer than any motion, and anything that comes late."""
TRUE_RAD = 2e-3
"""What is written is where the arm stood, to a step of the coarser encoders, however bad the line."""
STRAYED_RAD = np.deg2rad(12.0)
"""The motors are never farther off the straight way that was checked; 3 degrees, and what goes by until it is read."""
LOOK_S = 0.1
SAID_DEG = 0.11
"""What is said of where it stands is true, to a step of the coarser encoders."""
LINE = ("garbage:0.02", "garbage:0.2", "lost:0.02", "lost:0.2", "misheard:0.02", "misheard:0.2", "late:0.5", "late:1.5",
        "late:3", "late:30", "silent", "flood", "flood:200", "cut")  # fmt: skip
AXES = ("impact", "stall", "thermic", "reboot")
KINDS = ("acl", "acl", "acl", "acl", "acl", "lss", "dynamixel", "feetech")
OTHERS = ("camera", "disk", "hand")


class Day:
    """What goes wrong, and when."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.seed = seed
        self.kind = KINDS[int(len(KINDS) * rng.random())]
        self.both_ways = rng.random() < 0.4
        self.fault, self.other = "", ""
        self.moment_s = rng.uniform(0.5, LATEST_S)
        self.shot = int(rng.integers(0, 2 * POSES))
        pick = rng.integers(0, 10)
        when = f"@{rng.integers(1, 150)}" if rng.random() < 0.5 else f"@>{rng.uniform(0.1, LATEST_S):.1f}s"
        if pick < 5:
            self.fault = f"{rng.choice(LINE)}{when}"
        elif pick < 8:
            self.fault = f"{rng.choice(AXES)}:{rng.integers(1, 6)}{when}"
        else:
            self.other = str(rng.choice(OTHERS))

    def __repr__(self) -> str:
        return f"seed {self.seed}: {self.kind} {self.fault or self.other} {'both ways' if self.both_ways else ''}"


def full_disk(*_: Any, **__: Any) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def names_on_disk(folder: Path) -> set[str]:
    with (folder / "poses.csv").open(newline="") as file:
        return {row["pose"] for row in csv.DictReader(file) if row["image"]}


def run(day: Day, cell: Any, folder: Path, waypoints: tuple[Waypoint, ...]) -> str:
    """One day: what was said at its end."""
    told: list[str] = []
    writer = bench.begun(cell, folder, waypoints)
    rig = bench.bench_for(cell, [day.fault] if day.fault else [], day.seed)
    camera = bench.Painted(rig, cell.description.image_px, day.shot if day.other == "camera" else None)
    patched = pytest.MonkeyPatch()

    def by_hand() -> None:
        raise KeyboardInterrupt

    def on_disk(waypoint: Waypoint) -> None:
        told.append(waypoint.name)
        with (folder / "poses.csv").open(newline="") as file:
            *_, row = csv.DictReader(file)
        q = np.array([float(cell) for column, cell in row.items() if column.startswith("q_")])
        assert np.abs(q - rig.motor()).max() < TRUE_RAD, day

    if day.other == "hand":
        rig.clock.at.append((day.moment_s, by_hand))
    if day.other == "disk":
        rig.clock.at.append((day.moment_s, lambda: patched.setattr("os.fsync", full_disk)))
    said, early = "", False
    watched = bench.Watched(rig, LOOK_S)
    try:
        running = bench.session(cell, rig, writer, camera)
        watched.goes(running._arm)
        running.run(on_disk)
    except Interrupted as error:
        said = str(error)
    except (RobolaserError, KeyboardInterrupt) as error:
        said, early = str(error), True  # the line was never up
    finally:
        patched.undo()
    assert not (early and told), day
    assert watched.strayed < STRAYED_RAD, (day, np.rad2deg(watched.strayed), said)
    assert watched.fastest() < 1.05 * cell.limits.speed_rad_s, (day, watched.fastest())
    stood = rig.motor()
    stands = re.findall(r"(-?\d+\.\d+)°", said.partition("It is at")[2].partition("\n")[0])
    assert not stands or np.abs(np.rad2deg(stood) - [float(angle) for angle in stands]).max() < SAID_DEG, (day, said)
    rig.clock.at.clear()
    rig.clock.time_s += LASTS_S
    moved = float(np.abs(rig.motor() - stood).max())
    assert moved < 1e-9 or "could not be seen to stop" in said, (day, moved, said)
    if (folder / "dataset.toml").exists():
        assert len(robolaser.load(folder).poses) >= len(told), day
        assert names_on_disk(folder) == set(told), day
    else:
        assert not told, day
    return said


def go_on(cell: Any, folder: Path, waypoints: tuple[Waypoint, ...]) -> None:
    """The next day nothing is wrong."""
    rig = bench.bench_for(cell)
    there = (folder / "plan.csv").exists()
    writer = bench.resumed(cell, folder) if there else bench.begun(cell, folder, waypoints)
    if writer.last_position is not None:  # the power was on all night
        bench.arm_on(rig, cell).start_move(writer.last_position, 5.0)
        rig.clock.wait(60.0)
    bench.session(cell, rig, writer).run(lambda waypoint: None)
    assert names_on_disk(folder) == {waypoint.name for waypoint in waypoints}
    poses = robolaser.load(folder).poses
    assert (np.diff(poses.time_s) > 0).all()
    assert all((folder / image).is_file() for image in poses.image if image)
    for waypoint in waypoints:
        assert np.abs(poses.q[poses.names.index(waypoint.name)] - waypoint.q).max() < 0.01


@pytest.mark.parametrize("batch", range(DAYS // BATCH))
def test_after_any_bad_day_the_arm_stands_and_the_recording_is_whole(batch: int, tmp_path: Path) -> None:
    cells = {}
    for kind in set(KINDS):
        (tmp_path / kind).mkdir()
        cells[kind] = bench.cell(tmp_path / kind, kind)
    stopped = 0
    for seed in range(BATCH * batch, BATCH * (batch + 1)):
        day = Day(seed)
        cell = cells[day.kind]
        waypoints = bench.poses(cell, POSES)
        waypoints = both_ways(waypoints[:2], 0.05) if day.both_ways else waypoints
        folder = tmp_path / f"recording-{seed}"
        said = run(day, cell, folder, waypoints)
        stopped += bool(said)
        go_on(cell, folder, waypoints)
    assert stopped > BATCH // 4
