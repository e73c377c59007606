"""A cell that hides a fault, from the first pose to the last figure; nothing but the world's file knows the fault."""

import json
import shutil
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import final

import numpy as np
import pytest
from few_files import untried
from virtual_cell import in_virtual_time

from robolaser.cli import main
from robolaser.data.dataset_file import describe
from robolaser.data.loading import load
from robolaser.emulator.world.world import load_world
from robolaser.scan import Calibrated, prepare, read_calibration
from robolaser.scan.cloud_files import Subsample
from robolaser.scan.quality import Measured, measure

EXAMPLES = Path(__file__).parents[2] / "examples"
HIDDEN = ("joint_3", 2.4e-3)
PLANNED = 8
EVERY = 8  # pose of the example's sweep, which goes there and back
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

    @cached_property
    def measured(self) -> dict[str, dict[str, Measured]]:
        """Plane, step and sphere, as far as they are to be seen, as each scanner measures them."""
        corrected, ordinary = (read_calibration(self.folder / name) for name in ("why", "calibration"))
        scanners = {
            "true": self._true(corrected),
            "corrected": corrected,
            "ordinary": ordinary,
            "as drawn": corrected.as_drawn(),
        }
        return {name: self._bodies(scanner) for name, scanner in scanners.items()}

    def _true(self, found: Calibrated) -> Calibrated:
        """The scanner that the world has, with its fault."""
        joint, size = HIDDEN
        cell = self.folder / "scan-cell"
        told = load_world(cell / "world.toml", describe(cell)).truth
        fault = {f"backlash.{joint}.lost_motion": size, f"backlash.{joint}.start": 0.0}
        numbers = {**{name: told[name] for name in found.parameters}, **fault}
        return replace(found, values={name: np.array([value]) for name, value in numbers.items()})

    def _bodies(self, scanner: Calibrated) -> dict[str, Measured]:
        scan, subsample = prepare(scanner, load(self.folder / "things")), Subsample()
        for _ in subsample.watch(scan.cloud.pieces(lambda what, share: None)):
            pass
        return {
            body.what: body
            for body in measure(subsample.vertices, plane=True, step_m=STEP_M, sphere_m=RADIUS_M).primitives
        }

    def off_m(self, what: str, scanner: str) -> float:
        """How far points are from a body of the true size, root mean square [m]; infinite where none is to be seen."""
        body = self.measured[scanner].get(what)
        return np.inf if body is None else float(np.hypot(body.rms_m, body.error_m or 0.0))


def _hide(cell: Path) -> None:
    """Give a cell of the examples another fault."""
    joint, size = HIDDEN
    world = (cell / "world.toml").read_text("utf-8")
    assert 'where = "joint_2"\nsize = 3e-3' in world
    world = world.replace('where = "joint_2"\nsize = 3e-3', f'where = "{joint}"\nsize = {size}')
    (cell / "world.toml").write_text(world, "utf-8")


def _some_poses(cell: Path) -> Path:
    header, *rows = (cell / "poses.csv").read_text("utf-8").splitlines()
    path = cell / "some.csv"
    path.write_text("\n".join([header, *rows[::EVERY]]) + "\n", "utf-8")
    return path


def _record(cell: Path, recording: Path, *how: str, seed: int) -> None:
    with in_virtual_time(cell, seed=seed):
        assert main(["record", str(cell), "--output", str(recording), *how, "--move"]) == 0


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
    with untried():
        assert main(["diagnose", points, "--output", str(folder / "why")]) == 0
    _record(folder / "scan-cell", folder / "things", "--poses", str(_some_poses(folder / "scan-cell")), seed=2)
    return Run(folder)


def test_every_pose_is_recorded_from_below_and_from_above(run: Run) -> None:
    poses = load(run.folder / "recording").poses
    taken = [name for name, image in zip(poses.names, poses.image, strict=True) if image]
    assert taken == [f"p{i:03d}_{way}" for i in range(1, PLANNED + 1) for way in ("up", "down")]


def test_the_hidden_fault_is_named_and_nothing_else(run: Run) -> None:
    joint, size = HIDDEN
    found = run.diagnosis
    assert found["verdict"] == "explained"
    effects = [effect for effect in found["effects"] if effect["where"] != "image"]  # a gross error is no cause
    assert [(effect["effect"], effect["where"]) for effect in effects] == [("backlash", joint)]
    assert effects[0]["probability"] > 0.95
    assert effects[0]["parameters"]["lost_motion"]["value"] == pytest.approx(size, rel=0.02)


def test_with_the_fault_in_the_model_only_noise_is_left(run: Run) -> None:
    gap = run.diagnosis["gap_mm"]
    assert gap["after"] < LIKE_NOISE * gap["noise_floor"]
    assert gap["calibrated"] > 3 * gap["noise_floor"]


@pytest.mark.parametrize("what", ["step", "sphere"])
def test_bodies_are_measured_as_well_as_with_the_true_scanner(run: Run, what: str) -> None:
    assert run.off_m(what, "corrected") < LIKE_NOISE * run.off_m(what, "true")


@pytest.mark.parametrize("what", ["step", "sphere"])
@pytest.mark.parametrize("scanner", ["as drawn", "ordinary"])
def test_a_scanner_with_another_model_measures_them_wrong(run: Run, scanner: str, what: str) -> None:
    assert run.off_m(what, scanner) > LIKE_NOISE * run.off_m(what, "true")


def test_without_the_fault_in_the_model_the_ways_there_and_back_do_not_meet(run: Run) -> None:
    on_plane = {scanner: bodies["plane"].points for scanner, bodies in run.measured.items() if "plane" in bodies}
    assert on_plane["corrected"] > 0.99 * on_plane["true"]
    assert on_plane.get("ordinary", 0) < 0.7 * on_plane["true"]


def test_the_command_writes_the_same_cloud_and_says_the_sizes(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    cloud = run.folder / "cloud.ply"
    sizes = ["--step", str(STEP_M), "--sphere", str(RADIUS_M)]
    assert main(["scan", str(run.folder / "why"), str(run.folder / "things"), "--output", str(cloud), *sizes]) == 0
    said = capsys.readouterr().out
    for what in ("step", "sphere"):
        assert f"{what}, " in said
    assert cloud.stat().st_size > 10_000 * 20
