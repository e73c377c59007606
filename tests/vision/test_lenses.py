"""A lens is found where it is, and freed only as far as the boards say."""

import cv2
import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.vision.lens import find_lens

COLUMNS, ROWS, SQUARE_M = 9, 6, 0.010
WIDTH_PX, HEIGHT_PX = 640, 480
FOCAL_PX = 1090.0
K1 = -0.04


def boards(*, centre: tuple[float, float], k2: float = 0.0, noise_px: float, views: int = 20) -> list[Array]:
    """Corners of a board as a lens shows them from several sides, (rows, columns, 2) [px] each."""
    rng = np.random.default_rng(5)
    place = SQUARE_M * np.indices((ROWS, COLUMNS), dtype=np.float64)[::-1].reshape(2, -1).T
    place = np.pad(place - place.mean(axis=0), ((0, 0), (0, 1)))
    matrix = np.array([[FOCAL_PX, 0, centre[0]], [0, FOCAL_PX, centre[1]], [0, 0, 1]])
    lens = np.array([K1, k2, 0.0, 0.0, 0.0])
    grids = []
    for _ in range(views):
        turn = rng.uniform(-0.4, 0.4, 3)
        shift = np.array([*rng.uniform(-0.03, 0.03, 2), rng.uniform(0.28, 0.36)])
        pixel = np.asarray(cv2.projectPoints(place, turn, shift, matrix, lens)[0], dtype=np.float64)
        grids.append((pixel + noise_px * rng.standard_normal(pixel.shape)).reshape(ROWS, COLUMNS, 2))
    return grids


@pytest.mark.parametrize("centre", [(323.4, 236.2), (300.0, 250.0)])
def test_a_lens_beside_the_image_s_middle_is_found_there(centre: tuple[float, float]) -> None:
    lens = find_lens(boards(centre=centre, noise_px=0.04), SQUARE_M, WIDTH_PX, HEIGHT_PX)
    np.testing.assert_allclose(lens.matrix[:2, 2], centre, atol=1.0)
    assert lens.known
    assert lens.matrix[0, 0] == pytest.approx(FOCAL_PX, rel=5e-3)
    assert lens.distortion[0] == pytest.approx(K1, abs=5e-3)


def test_what_corners_do_not_tell_stays_where_a_lens_usually_has_it() -> None:
    lens = find_lens(boards(centre=(321.0, 238.0), noise_px=0.8, views=6), SQUARE_M, WIDTH_PX, HEIGHT_PX)
    np.testing.assert_allclose(lens.matrix[:2, 2], [(WIDTH_PX - 1) / 2, (HEIGHT_PX - 1) / 2])
    assert lens.distortion[1] == 0


def test_a_second_radial_term_is_taken_only_where_it_shows() -> None:
    without = find_lens(boards(centre=(330.0, 230.0), noise_px=0.04), SQUARE_M, WIDTH_PX, HEIGHT_PX)
    with_it = find_lens(boards(centre=(330.0, 230.0), k2=1.5, noise_px=0.04), SQUARE_M, WIDTH_PX, HEIGHT_PX)
    assert without.distortion[1] == 0
    assert with_it.distortion[1] == pytest.approx(1.5, abs=0.5)
