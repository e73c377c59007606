"""An arm that others move is recorded while it moves."""

from pathlib import Path

import bench
import cv2
import numpy as np
import pytest
from terminal import Rig, emulated

import robolaser
from robolaser.arrays import Array, Image
from robolaser.cell.session import watch
from robolaser.errors import OutputError

COUNT = 30


class Remembering(bench.Painted):
    """A camera that knows when each image came, and where the motors were."""

    def shot(self, settle_s: float) -> Image:
        image = super().shot(settle_s)
        self.came = [*getattr(self, "came", []), (self._clock.now(), self._bench.motor())]
        return image


def recorded(tmp_path: Path, kind: str) -> tuple[robolaser.Dataset, Array, Array]:
    cell = bench.cell(tmp_path, kind)
    rig, arm = bench.armed(cell)
    camera = Remembering(rig, cell.description.image_px)
    began = rig.clock.now()
    arm.start_move(rig.motor() + np.array([0.5, -0.3, 0.2, 0.1, -0.4]), 8.0)
    watch(arm, camera, bench.begun(cell, tmp_path / "out", ()), rig.clock, COUNT, cell.laser_output, lambda name: None)
    times, q = zip(*camera.came[-COUNT:], strict=True)
    return robolaser.load(tmp_path / "out"), np.array(times) - began, np.array(q)


@pytest.mark.parametrize("kind", ["acl", "dynamixel", "feetech", "ur"])
def test_angles_and_velocities_are_those_at_the_time_of_the_image(tmp_path, kind):
    dataset, time_s, q = recorded(tmp_path, kind)
    poses = dataset.poses
    assert not poses.qd_from_path
    assert np.ptp(time_s - poses.time_s) < 1e-3
    np.testing.assert_allclose(poses.q, q, atol=4e-3)
    np.testing.assert_allclose(poses.qd, np.gradient(q, time_s, axis=0), atol=0.03)
    assert np.abs(poses.qd).max() > 0.05


def test_no_image_is_kept_that_may_have_been_exposed_before_the_laser_was_on(cell, tmp_path):
    rig, arm = bench.armed(cell)
    camera, late = Remembering(rig, cell.description.image_px), []
    shot = camera.shot

    def one_late(settle_s: float) -> Image:
        late.append(shot(settle_s))
        return late[-2] if len(late) > 1 else np.zeros_like(late[0])  # exposed when the one before it came

    camera.shot = one_late
    watch(arm, camera, bench.begun(cell, tmp_path / "out", ()), rig.clock, 3, cell.laser_output, lambda _: None, 0.3)
    images = [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in sorted((tmp_path / "out/images").iterdir())]
    assert [int(image[3].min()) for image in images] == [200] * 3


def test_the_laser_goes_off_when_the_disk_is_full(cell, tmp_path, monkeypatch):
    rig, arm = bench.armed(cell)
    writer = bench.begun(cell, tmp_path / "out", ())

    def full(samples: object) -> None:
        raise OutputError("The disk is full.")

    monkeypatch.setattr(writer, "add", full)
    camera = Remembering(rig, cell.description.image_px)
    with pytest.raises(OutputError):
        watch(arm, camera, writer, rig.clock, 2, cell.laser_output, lambda name: None)
    assert not rig.controller.outputs(rig.clock.now())


@pytest.mark.parametrize("kind", ["acl", "dynamixel", "feetech"])
def test_the_command_moves_nothing_and_writes_a_data_set(tmp_path, kind, capsys):
    rig = Rig(tmp_path, kind)
    with emulated(rig) as port:
        assert rig.record("--watch", "5", port=port) == 0
    assert "5 images of 5" in capsys.readouterr().out
    assert not (rig.out / "plan.csv").exists()
    poses = robolaser.load(rig.out).poses
    assert poses.names == ("w001", "w002", "w003", "w004", "w005")
    np.testing.assert_array_equal(poses.qd, 0.0)
    assert rig.record("--watch", "5", "--move", "--force", port="loop://") == 2
