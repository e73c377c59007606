"""A ball and a step of known size, as a camera sees them, become a cloud of that size."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scanned import calibrated, dataset, written

from robolaser.data.cell_config import load_cell
from robolaser.data.dataset import Points
from robolaser.data.loading import load
from robolaser.data.writing import save
from robolaser.emulator.world.world import load_world
from robolaser.scan import prepare, read_calibration
from robolaser.scan.cloud_files import Subsample
from robolaser.scan.quality import measure

THINGS = Path(__file__).parents[2] / "examples" / "scan-cell"
THERE = 54  # its first poses: on the way back play would part what a nominal scanner sees
RADIUS, STEP = 0.018, 0.010


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """What a camera took on the way over ball and step."""
    folder = tmp_path_factory.mktemp("things")
    said = load(THINGS)
    world = load_world(THINGS / "world.toml", load_cell(THINGS).description)
    rng, images = np.random.default_rng(0), [""] * len(said.poses)
    (folder / "images").mkdir()
    for row, q in enumerate(said.poses.q):
        world.follow(q)
        if row < THERE and row % 2 == 0:
            images[row] = f"images/{row:03d}.png"
            cv2.imwrite(str(folder / images[row]), world.photograph(rng, lit=True))
    poses = replace(said.poses, time_s=np.arange(float(len(said.poses))), image=tuple(images))
    save(replace(said, poses=poses, points=Points(np.empty(0, np.int64), ())), folder)
    return load(folder), world


@pytest.fixture(scope="module")
def truly(recording, tmp_path_factory):
    """A calibration that found the truth, from other poses."""
    said, world = recording
    numbers = {**world.truth, "backlash.joint_2.lost_motion": world.faults["backlash", "joint_2"]}
    others = replace(dataset(), parameters=said.parameters, bracket_quat=said.bracket_quat, angles=said.angles)
    found = replace(calibrated(others, ["backlash:joint_2"], numbers), noise={"pixel": 0.1})
    return read_calibration(written(found, tmp_path_factory.mktemp("truth")))


def looked_at(scan):
    subsample = Subsample()
    for _ in subsample.watch(scan.cloud.pieces()):
        pass
    return subsample.vertices


def test_ball_and_step_have_their_size(recording, truly):
    said, _ = recording
    scan = prepare(truly, said)
    assert scan.cloud.what == "images"
    found = measure(looked_at(scan), plane=True, step_m=STEP, sphere_m=RADIUS)
    plane, step, sphere = found.primitives
    assert abs(step.error_m) < 5e-5
    assert abs(sphere.error_m) < 1e-4
    assert plane.rms_m < 2 * plane.predicted_m
    assert abs(found.plane.place[2]) == pytest.approx(1.0, abs=1e-4)


def test_the_nominal_scanner_sees_them_wrong(recording, truly):
    said, _ = recording
    wrong = measure(looked_at(prepare(truly.as_drawn(), said)), step_m=STEP, sphere_m=RADIUS)
    _, step, sphere = wrong.primitives
    assert abs(step.error_m) > 3e-4
    assert sphere.rms_m > 5e-5
