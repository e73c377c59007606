"""Images of poses are small, few, and left out where they are not what was stated."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from calibrated import POSES, ROWS, stripe
from PIL import Image

from robolaser.report.pose_photos import MOST, WIDTH_PX, photos


@pytest.fixture
def dataset(tmp_path):
    made = stripe().model.dataset
    for number in range(POSES):
        Image.new("L", made.image_px, 10 * number).save(tmp_path / f"{number}.png")
    images = tuple(f"{number}.png" for number in range(POSES))
    return replace(made, folder=tmp_path, poses=replace(made.poses, image=images))


def test_each_image_has_its_points_in_its_own_pixels(dataset):
    first = np.flatnonzero(dataset.points.pose == 2)[0]
    errors = np.where(np.arange(POSES * ROWS)[:, None] == first, 2.0, [1.0, 1.0, 1.0])
    found = photos(dataset, range(POSES), errors)
    assert set(found) == set(dataset.poses.names[:MOST])
    photo = found["p2"]
    assert photo.shares.tolist() == [1.0] + [0.5] * (ROWS - 1)
    np.testing.assert_array_equal(photo.points, dataset.points.pixel[dataset.points.pose == 2])
    assert photo.size_px == dataset.image_px
    small = Image.open(io.BytesIO(base64.b64decode(photo.source.partition(",")[2])))
    assert small.size == (WIDTH_PX, WIDTH_PX * dataset.image_px[1] // dataset.image_px[0])


def test_what_is_missing_damaged_or_of_another_size_is_left_out(dataset):
    (dataset.folder / "0.png").unlink()
    (dataset.folder / "1.png").write_bytes(b"no image")
    Image.new("L", (10, 10)).save(dataset.folder / "2.png")
    found = photos(dataset, range(POSES), np.ones((POSES * ROWS, 3)))
    assert set(found) == set(dataset.poses.names[3:])
    assert not photos(replace(dataset, folder=None), range(POSES), np.ones((POSES * ROWS, 3)))
