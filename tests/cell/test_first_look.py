"""The first images of a plan are looked at: is the whole board there?"""

from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell.first_look import FirstLook
from robolaser.data.board import Board
from robolaser.errors import CameraError, Interrupted
from robolaser.vision.board import Image

BOARD = Board(7, 5, 0.01)


def board_image(right_px: int) -> Image:
    """A board of squares of 30 px, so far to the right."""
    image = np.full((360, 480), 210, dtype=np.uint8)
    for row, column in np.argwhere(np.add.outer(np.arange(6), np.arange(8)) % 2 == 0):
        top, left = 90 + 30 * row, 120 + 30 * column + right_px
        image[top : top + 30, left : left + 30] = 30
    return image


@pytest.mark.parametrize(("cut", "ends"), [([1], False), ([0, 2], True), ([3, 4], False)])
def test_two_of_the_first_three_images_without_the_whole_board_end_a_recording(cut: list[int], ends: bool) -> None:
    look = FirstLook(BOARD)
    said = ""
    try:
        for i in range(5):
            look.at(f"p{i}", {"image": board_image(150 if i in cut else 0)})
    except CameraError as error:
        said = str(error)
    assert said.startswith("The whole board is not visible from p0 and p2,") == ends


def test_the_arm_is_stopped_and_the_target_is_to_be_measured_again(tmp_path: Path) -> None:
    cell = bench.cell(tmp_path)
    rig = bench.bench_for(cell)
    writer = bench.begun(cell, tmp_path / "out", bench.poses(cell, 4))
    said = r"p001 and p002.*target\.x.*--force[\s\S]*The arm was stopped[\s\S]*2 of 4 poses are in \S*\.$"
    with pytest.raises(Interrupted, match=said):  # and nothing of --resume
        bench.session(cell, rig, writer, first_look=FirstLook(BOARD)).run(lambda waypoint: None)
