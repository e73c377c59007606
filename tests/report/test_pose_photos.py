"""Images of poses are small, few, and left out where they are not what was stated."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from calibrated import KINDS, POSES, ROWS, stripe
from cells import project
from PIL import Image

from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.report.cell_poses import CellPoses
from robolaser.report.model_scene import MOST_PHOTOS, WIDTH_PX, photos


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
    found = photos(dataset, range(POSES), errors, np.full((POSES * ROWS, 2), [3.0, 4.0]))
    assert set(found) == set(dataset.poses.names[:MOST_PHOTOS])
    photo = found["p2"]
    assert photo["misses"] == [[3.0, 4.0]] * ROWS
    assert all("5 px from where the model predicts it" in name for name in photo["names"])
    np.testing.assert_allclose(photo["points"], dataset.points.pixel[dataset.points.pose == 2], atol=0.01)
    assert photo["size"] == dataset.image_px
    small = Image.open(io.BytesIO(base64.b64decode(photo["source"].partition(",")[2])))
    assert small.size == (WIDTH_PX, WIDTH_PX * dataset.image_px[1] // dataset.image_px[0])


def test_what_is_missing_damaged_or_of_another_size_is_left_out(dataset):
    (dataset.folder / "0.png").unlink()
    (dataset.folder / "1.png").write_bytes(b"no image")
    Image.new("L", (10, 10)).save(dataset.folder / "2.png")
    found = photos(dataset, range(POSES), np.ones((POSES * ROWS, 3)), None)
    assert set(found) == set(dataset.poses.names[3:])
    assert found["p3"]["misses"] == [[None, None]] * ROWS
    assert not photos(replace(dataset, folder=None), range(POSES), np.ones((POSES * ROWS, 3)), None)


@pytest.mark.parametrize("axis", ["u", "v"])
def test_a_scanners_miss_leads_to_the_pixel_of_the_known_point(axis):
    calibration = stripe(axis=axis)
    model, x = calibration.model, calibration.x
    errors = model.in_metres(x, model.residuals(x[None])[0])
    cell = CellPoses(model, x)
    in_camera = apply(inverse(cell.camera)[model.dataset.points.pose], cell.known)
    predicted = project(in_camera[None], cell.values, axis)[0]
    np.testing.assert_allclose(model.dataset.points.pixel + cell.misses(errors), predicted, atol=0.02)


def test_a_cameras_miss_is_its_residual_turned_round():
    calibration = KINDS["camera"]()
    model, x = calibration.model, calibration.x
    residuals = model.residuals(x[None])[0]
    misses = CellPoses(model, x).misses(model.in_metres(x, residuals))
    np.testing.assert_allclose(misses, -residuals, atol=1e-9)
