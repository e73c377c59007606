"""Two results that were just made, or read back, say what changed between them."""

from pathlib import Path

import pytest
from few_files import only

import robolaser
from robolaser.data.stated_noise import Noise
from robolaser.simulation import simulate


def measured(offset: float, seed: int) -> robolaser.Dataset:
    noise, effects = Noise(point_m=3e-5), {"joint_offset:elbow_joint": offset}
    return simulate("ur5", kind="point", poses=25, noise=noise, effects=effects, seed=seed).dataset


def test_what_moved_is_told_in_standard_errors(tmp_path: Path) -> None:
    with only("robot_corrected.urdf"):
        monday, friday = (
            robolaser.calibrate(measured(offset, seed), effects=["joint_offset:elbow_joint"], weights="noise", seed=0)
            for offset, seed in ((0.001, 1), (0.003, 2))
        )
    found = monday.compare(friday)
    rows = {row["name"]: row for row in found["rows"]}
    offset = rows["joint_offset.elbow_joint.offset"]
    assert offset["change"] == pytest.approx(0.002, rel=0.1)
    assert offset["errors"] > 20.0
    assert "standard errors" in repr(found)
    assert 0.3 < rows["flange of the corrected arm"]["change"] < 1.2  # mm: 2 mrad at some 0.4 m
    assert "joint_offset.elbow_joint.offset" in set(found.to_frame()["name"])
    monday.save(tmp_path / "monday")
    assert robolaser.load_calibration(tmp_path / "monday").compare(friday)["rows"] == found["rows"]
