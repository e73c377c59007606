"""A board's corners and its frame, against the board that was painted."""

from dataclasses import replace

import numpy as np
import pytest
from painted import HEIGHT, SQUARE, WIDTH, scene, session
from scipy.spatial.transform import Rotation

from robolaser.vision.board import find_board
from robolaser.vision.board_orientation import orient_by_continuity, orient_by_robot
from robolaser.vision.lens import Intrinsics, find_lens, view_board
from robolaser.vision.target import is_telling

ONE_WAY = [(7, 6), (6, 7)]
TWO_WAYS = [(7, 5), (6, 4), (5, 5)]
FOUR_WAYS = [(6, 6)]


def seen(columns, rows, roll_deg=0.0, dark_first=True):
    return scene((8, 12, roll_deg), (-0.01, 0, 0.19), columns=columns, rows=rows, dark_first=dark_first)


def error(grid, one):
    """Largest error of the corners that were found, infinite if they are few [px]."""
    found = np.isfinite(grid).all(axis=-1)
    return np.abs(grid - one.corners())[found].max() if found.mean() > 0.8 else np.inf


def test_corners_of_a_dark_board_beside_a_glaring_stripe_are_found_to_a_fraction_of_a_pixel():
    for k, one in enumerate(session()):
        (grid,) = find_board(one.paint(k), columns=7, rows=6).orientations
        assert np.abs(grid - one.corners()).max() < 0.25
        assert np.sqrt(np.mean((grid - one.corners()) ** 2)) < 0.08


@pytest.mark.parametrize("roll_deg", [0, 100, 180, 260])
@pytest.mark.parametrize(("columns", "rows"), ONE_WAY)
def test_colours_that_allow_one_frame_fix_it_however_the_camera_rolls(columns, rows, roll_deg):
    """The stripe crosses the board here: corners it glares on may be missing, none may be wrong."""
    one = seen(columns, rows, roll_deg)
    (grid,) = find_board(one.paint(0), columns=columns, rows=rows).orientations
    assert error(grid, one) < 0.5


@pytest.mark.parametrize(
    ("columns", "rows", "ways"), [(*size, 2) for size in TWO_WAYS] + [(*size, 4) for size in FOUR_WAYS]
)
def test_colours_that_allow_several_frames_give_each_of_them(columns, rows, ways):
    one = seen(columns, rows, 30)
    orientations = find_board(one.paint(0), columns=columns, rows=rows).orientations
    assert len(orientations) == ways
    assert min(error(grid, one) for grid in orientations) < 0.5
    for grid in orientations:
        x, y = np.nanmedian(np.diff(grid, axis=1), axis=(0, 1)), np.nanmedian(np.diff(grid, axis=0), axis=(0, 1))
        assert x[0] * y[1] - x[1] * y[0] > 0


@pytest.mark.parametrize(("columns", "rows"), [(6, 4), (7, 5)])
def test_a_board_with_light_corner_squares_still_gets_a_frame(columns, rows):
    one = seen(columns, rows, dark_first=False)
    orientations = find_board(one.paint(0), columns=columns, rows=rows).orientations
    assert len(orientations) == 2
    assert min(error(grid, one) for grid in orientations) < 0.5


def test_no_board_is_found_where_none_is():
    noise = np.random.default_rng(0).normal(60, 15, (120, 160)).clip(0, 255).astype(np.uint8)
    assert find_board(noise, columns=7, rows=6) is None
    assert find_board(np.zeros((HEIGHT, WIDTH), np.uint8), columns=7, rows=6) is None


def layings_of(grid):
    """Every turn of a square grid."""
    return tuple(np.rot90(grid, k) for k in range(4))


def test_a_slowly_rolling_camera_keeps_the_frame_by_sight():
    scenes = [seen(6, 6, roll) for roll in range(0, 360, 40)]
    settled = orient_by_continuity([layings_of(one.corners()) for one in scenes])
    for grid, one in zip(settled, scenes, strict=True):
        np.testing.assert_allclose(grid, one.corners())


def test_the_robots_turns_keep_the_frame_however_far_the_camera_rolls():
    rng = np.random.default_rng(3)
    hand_eye = Rotation.from_quat(rng.standard_normal(4))
    tilts = [(10, 5, 0), (-14, 8, 170), (4, -18, 95), (15, 12, -110), (-6, 16, 60)]
    scenes = [scene(tilt, (0, 0, 0.2), columns=6, rows=6) for tilt in tilts]
    lens = find_lens([one.corners() for one in scenes], SQUARE, WIDTH, HEIGHT)
    base = Rotation.from_quat(rng.standard_normal(4))
    flange = np.stack([(base * Rotation.from_matrix(one.R).inv() * hand_eye).as_matrix() for one in scenes])
    orientations = [layings_of(one.corners()) for one in scenes]
    mixed = [ways[k % 4 :] + ways[: k % 4] if k else ways for k, ways in enumerate(orientations)]
    for grid, one in zip(orient_by_robot(mixed, flange, lens)[0], scenes, strict=True):
        np.testing.assert_allclose(grid, one.corners())


def test_a_known_plane_gives_places_far_beyond_the_corners():
    scenes = session()
    lens = find_lens([one.corners() for one in scenes], SQUARE, WIDTH, HEIGHT)
    far = np.array([[0.09, 0.0], [0.09, 0.06], [-0.03, -0.02]])
    for one in scenes:
        view = view_board(one.corners(), SQUARE, lens)
        np.testing.assert_allclose(view.intersect(lens.undistort(one.project(far))), far, atol=3e-6)
        np.testing.assert_allclose(view.R_camera_board, one.R, atol=1e-3)


@pytest.mark.parametrize("tilt", [(0, 0, 0), (0, 18, 0), (12, 0, 0), (0, 18, 90)])
def test_a_board_tilted_about_its_own_axes_has_its_plane_whatever_the_last_digits(tilt):
    one = scene(tilt, (-0.012, 0, 0.16))
    lens = Intrinsics(np.array([[800.0, 0, 319.5], [0, 800, 239.5], [0, 0, 1]]), np.zeros(5), known=True)
    one = replace(one, k1=0.0)
    rng = np.random.default_rng(4)
    for _ in range(100):
        view = view_board(one.corners() * (1 + 1e-15 * rng.standard_normal(one.corners().shape)), SQUARE, lens)
        np.testing.assert_allclose(view.R_camera_board, one.R, atol=1e-5)


@pytest.mark.parametrize(
    ("corners", "enough"),
    [
        ([(0, 0), (0, 1), (1, 0), (1, 1)], True),
        ([*((0, i) for i in range(7)), (1, 3), (2, 5)], True),
        ([(0, 0), (0, 1), (1, 0)], False),
        ([(i, i) for i in range(6)], False),
        ([*((0, i) for i in range(7)), (1, 3)], False),
        ([], False),
    ],
)
def test_corners_are_enough_where_they_determine_the_plane(corners, enough):
    one = replace(scene((8, 12, 5), (-0.01, 0, 0.19)), k1=0.0)
    there = np.zeros((6, 7), bool)
    for corner in corners:
        there[corner] = True
    assert is_telling(there) == enough
    if enough:
        lens = Intrinsics(np.eye(3), np.zeros(5), known=False)
        view = view_board(np.where(there[..., None], one.corners(), np.nan), SQUARE, lens)
        np.testing.assert_allclose(view.intersect(one.corners().reshape(-1, 2))[-1], [0.06, 0.05], atol=1e-6)


@pytest.mark.parametrize("views", [1, 2])
def test_too_few_views_leave_the_lens_unknown_and_the_corners_in_place(views):
    scenes = [replace(one, k1=0.0) for one in session()[:views]]
    lens = find_lens([one.corners() for one in scenes], SQUARE, WIDTH, HEIGHT)
    assert not lens.known
    view = view_board(scenes[0].corners(), SQUARE, lens)
    np.testing.assert_allclose(view.intersect(scenes[0].corners().reshape(-1, 2))[-1], [0.06, 0.05], atol=1e-7)
