"""A cell that hides a fault, from the first pose to the last figure; nothing but the world's file knows the fault."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np
import pytest
from emulator_process import EmulatorProcess

from robolaser.cli import main
from robolaser.data.dataset_file import describe
from robolaser.data.loading import load
from robolaser.emulator.world import load_world
from robolaser.scan import Calibrated, prepare, read_calibration
from robolaser.scan.cloud_filters import Subsample
from robolaser.scan.quality import Measured, measure

EXAMPLES = Path(__file__).parents[2] / "examples"
HIDDEN = ("joint_3", 2.4e-3)
HURRY = 40.0
PLANNED = 10
EVERY = 5  # pose of the example's sweep, which goes there and back
STEP_M, RADIUS_M = 0.010, 0.018
LIKE_NOISE = 1.2


@final
@dataclass(frozen=True)
class Run:
    """What came out of a blind run."""

    folder: Path

    @property
    def diagnosis(self) -> dict[str, object]:
        read: dict[str, object] = json.loads((self.folder / "why" / "diagnosis.json").read_text("utf-8"))
        return read

    @property
    def corrected(self) -> Calibrated:
        return read_calibration(self.folder / "why")

    def truth(self) -> Calibrated:
        """The scanner that the world has, with its fault."""
        joint, size = HIDDEN
        cell = self.folder / "scan-cell"
        told = load_world(cell / "world.toml", describe(cell)).truth()
        fault = {f"backlash.{joint}.lost_motion": size, f"backlash.{joint}.start": 0.0}
        found = self.corrected
        numbers = {**{name: told[name] for name in found.parameters}, **fault}
        return replace(found, values={name: np.array([value]) for name, value in numbers.items()})

    def body(self, what: str, scanner: Calibrated) -> Measured | None:
        """A plane, a step or a sphere as a scanner measures it; None where none is to be seen."""
        scan, subsample = prepare(scanner, load(self.folder / "things")), Subsample()
        for _ in subsample.watch(scan.cloud.pieces(lambda what, share: None)):
            pass
        found = measure(subsample.vertices, wanted=[what], step_m=STEP_M, sphere_m=RADIUS_M)
        return next((body for body in found.primitives if body.what == what), None)

    def off_m(self, what: str, scanner: Calibrated) -> float:
        """How far points are from a body of the true size, root mean square [m]; infinite where none is to be seen."""
        body = self.body(what, scanner)
        return np.inf if body is None else float(np.hypot(body.rms_m, body.error_m or 0.0))

    def on_table(self, scanner: Calibrated) -> int:
        """How many points lie on the largest plane."""
        plane = self.body("plane", scanner)
        return 0 if plane is None else plane.points


def _hide(cell: Path) -> None:
    """Give a cell of the examples another fault, and let it be recorded in a hurry."""
    joint, size = HIDDEN
    world = (cell / "world.toml").read_text("utf-8")
    assert 'where = "joint_2"\nsize = 3e-3' in world
    world = world.replace('where = "joint_2"\nsize = 3e-3', f'where = "{joint}"\nsize = {size}')
    (cell / "world.toml").write_text(world, "utf-8")
    said = (cell / "cell.toml").read_text("utf-8")
    said = said.replace("settle_s = 0.3", "settle_s = 0.03").replace("speed_rad_s = 0.3", "speed_rad_s = 1.0")
    said = said.replace("[arm]\n", f"[arm]\nunattended_s = {0.9 * HURRY}\n")  # which the arm's clock counts
    (cell / "cell.toml").write_text(said, "utf-8")


def _some_poses(cell: Path) -> Path:
    header, *rows = (cell / "poses.csv").read_text("utf-8").splitlines()
    path = cell / "some.csv"
    path.write_text("\n".join([header, *rows[::EVERY]]) + "\n", "utf-8")
    return path


def _record(cell: Path, recording: Path, *how: str, seed: int) -> None:
    with EmulatorProcess(cell, world=cell / "world.toml", time_scale=HURRY, seed=seed) as emulated:
        lines = ["--port", emulated.arm, "--camera", str(emulated.camera)]
        assert main(["record", str(cell), "--output", str(recording), *how, *lines, "--move"]) == 0


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("blind")
    for name in ("cell", "scan-cell"):
        shutil.copytree(EXAMPLES / name, folder / name)
        _hide(folder / name)
    recording, points = str(folder / "recording"), str(folder / "points")
    _record(folder / "cell", folder / "recording", "--plan", str(PLANNED), "--both-ways", seed=1)
    assert main(["extract", recording, "--output", points]) == 0
    assert main(["calibrate", points, "--output", str(folder / "calibration")]) == 0
    assert main(["diagnose", points, "--output", str(folder / "why")]) == 0
    _record(folder / "scan-cell", folder / "things", "--poses", str(_some_poses(folder / "scan-cell")), seed=2)
    return Run(folder)


def test_every_pose_is_recorded_from_below_and_from_above(run: Run) -> None:
    poses = load(run.folder / "recording").poses
    assert poses.image is not None
    taken = [name for name, image in zip(poses.names, poses.image, strict=True) if image]
    assert taken == [f"p{i:03d}_{way}" for i in range(1, PLANNED + 1) for way in ("up", "down")]


def test_the_hidden_fault_is_named_and_nothing_else(run: Run) -> None:
    joint, size = HIDDEN
    found = run.diagnosis
    assert found["verdict"] == "explained"
    assert isinstance(found["effects"], list)
    effects = [effect for effect in found["effects"] if effect["where"] != "image"]  # a gross error is no cause
    assert [(effect["effect"], effect["where"]) for effect in effects] == [("backlash", joint)]
    assert effects[0]["probability"] > 0.95
    assert effects[0]["parameters"]["lost_motion"]["value"] == pytest.approx(size, rel=0.02)


def test_with_the_fault_in_the_model_only_noise_is_left(run: Run) -> None:
    gap = run.diagnosis["gap_mm"]
    assert isinstance(gap, dict)
    assert gap["after"] < LIKE_NOISE * gap["noise_floor"]
    assert gap["calibrated"] > 3 * gap["noise_floor"]


@pytest.mark.parametrize("what", ["step", "sphere"])
def test_bodies_are_measured_as_well_as_with_the_true_scanner(run: Run, what: str) -> None:
    assert run.off_m(what, run.corrected) < LIKE_NOISE * run.off_m(what, run.truth())


@pytest.mark.parametrize("what", ["step", "sphere"])
def test_the_scanner_as_drawn_measures_them_wrong(run: Run, what: str) -> None:
    assert run.off_m(what, run.corrected.as_drawn()) > LIKE_NOISE * run.off_m(what, run.truth())


def test_without_the_fault_in_the_model_the_ways_there_and_back_do_not_meet(run: Run) -> None:
    ordinary = read_calibration(run.folder / "calibration")
    seen = run.on_table(run.truth())
    assert run.on_table(run.corrected) > 0.99 * seen
    assert run.on_table(ordinary) < 0.7 * seen
    assert all(run.off_m(what, ordinary) > LIKE_NOISE * run.off_m(what, run.truth()) for what in ("step", "sphere"))


def test_the_command_writes_the_same_cloud_and_says_the_sizes(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    cloud = run.folder / "cloud.ply"
    sizes = ["--step", str(STEP_M), "--sphere", str(RADIUS_M)]
    assert main(["scan", str(run.folder / "why"), str(run.folder / "things"), "--output", str(cloud), *sizes]) == 0
    said = capsys.readouterr().out
    for what in ("step", "sphere"):
        assert f"{what}, " in said
    assert cloud.stat().st_size > 10_000 * 20
