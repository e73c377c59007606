"""Which images a recording names, and which it must not."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.image_list import images_of_poses
from robolaser.errors import DataError


def recording(folder, image, **extra):
    poses = Poses(tuple(f"p{i}" for i in range(len(image))), image=image, extra=extra)
    return Dataset("r", poses, Points(np.empty(0, np.int64), ()), folder=folder)


def test_repeats_come_in_their_order_and_the_dark_image_last(tmp_path):
    said = recording(
        tmp_path, ("a", "", "b"), image_10=("a10", "", ""), image_2=("a2", "", "b2"), image_off=("o", "", ""),
        image_1=("x", "x", "x"), image_left=("y", "y", "y"),
    )  # fmt: skip
    named = [[file.name for file in shots.files] for shots in images_of_poses(said)]
    assert named == [["a", "a2", "a10", "o"], ["b", "b2"]]
    assert [shots.row for shots in images_of_poses(said)] == [0, 2]
    assert [shots.unlit and shots.unlit.name for shots in images_of_poses(said)] == ["o", None]


@pytest.mark.parametrize("column", ["image_2", "image_off"])
def test_a_pose_with_other_images_names_the_first_too(column, tmp_path):
    with pytest.raises(DataError, match=rf"^poses\.csv, column image: pose p1: column {column}"):
        images_of_poses(recording(tmp_path, ("a", ""), **{column: ("", "b")}))


def test_an_image_is_of_one_pose(tmp_path):
    with pytest.raises(DataError, match=r"^poses\.csv, column image: pose p2: a is the image of pose p0 already"):
        images_of_poses(recording(tmp_path, ("a", "b", "a")))


@pytest.mark.parametrize("again", [("a", ""), ("", "a")])
def test_an_image_is_no_repeat_of_itself(again, tmp_path):
    with pytest.raises(DataError, match=r"column image_2: pose p[01]: a is the image of pose p0 already\."):
        images_of_poses(recording(tmp_path, ("a", "b"), image_2=again))


@pytest.mark.parametrize("column", ["image", "image_2", "image_off"])
@pytest.mark.parametrize("path", ["../b", "/b", "c/../../b"])
def test_no_column_leads_out_of_the_folder(column, path, tmp_path):
    columns = {"image": ("a",), "image_2": ("a2",), "image_off": ("a",), column: (path,)}
    with pytest.raises(DataError, match=column):
        images_of_poses(recording(tmp_path, columns.pop("image"), **columns))


def test_a_recording_in_memory_or_without_images_has_none(tmp_path):
    assert images_of_poses(recording(None, ("a",))) == []
    assert images_of_poses(replace(recording(tmp_path, ("a",)), poses=Poses(("p0",)))) == []
