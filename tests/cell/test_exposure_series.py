"""A series of exposures at each pose, and what becomes of it."""

from dataclasses import replace
from pathlib import Path

import bench
import cv2
import pytest

import robolaser
from robolaser.data.cell_config import load_cell
from robolaser.data.image_list import images_of_poses
from robolaser.errors import DataError
from robolaser.vision.board import Image


class Exposing(bench.Painted):
    """Writes its exposure into the corner of each image."""

    exposure = 0.0

    def expose(self, exposure: float) -> None:
        self.exposure = exposure

    def shot(self, settle_s: float) -> Image:
        image = super().shot(settle_s)
        image[0, 0] = self.exposure
        return image


def test_each_pose_has_an_image_of_each_exposure_and_the_first_one_again_without_the_laser(tmp_path: Path) -> None:
    cell = bench.cell(tmp_path)
    cell = replace(cell, camera=replace(cell.camera, exposures=(7.0, 30.0, 90.0)))
    rig = bench.bench_for(cell)
    assert cell.description.image_px is not None
    writer = bench.begun(cell, tmp_path / "out", bench.poses(cell, 2), shots=3)
    bench.session(cell, rig, writer, Exposing(rig, cell.description.image_px)).run(lambda _: None)
    shots = images_of_poses(robolaser.load(tmp_path / "out"))
    corners = [[int(cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)[0, 0]) for file in one.files] for one in shots]
    assert corners == [[7, 30, 90, 7]] * 2


@pytest.mark.parametrize("text", ["exposures = [5]", "exposure = 5\nexposures = [5, 6]"])
def test_a_series_is_of_two_or_more_and_stands_alone(tmp_path: Path, text: str) -> None:
    folder = bench.cell_folder(tmp_path)
    said = (folder / "cell.toml").read_text().replace("[camera]\n", f"[camera]\n{text}\n")
    (folder / "cell.toml").write_text(said)
    with pytest.raises(DataError, match=r"exposures.*two or more, and no exposure beside them"):
        load_cell(folder)
