import cv2
import numpy as np
import pytest
from scenes import MIDDLE, SHEET, above, eye, face_up, near, placed, spotless

from robolaser.emulator.rendering import Ball, Checkerboard, Cuboid, EmulatedScene, Floor, Solid
from robolaser.vision.board import find_board

BALL = Ball(near(0.012, 0.01, 0.018), 0.018)
BLOCK = Cuboid(placed(near(-0.02, -0.03, 0.0), 0, 0, 17), (0.05, 0.04, 0.01))
BOARD = Checkerboard(face_up(near(-0.04, 0.025, 0.0)), 9, 6, 0.010)
THINGS = EmulatedScene((Floor(), BALL, BLOCK))


@pytest.mark.parametrize("axis", ["u", "v"])
def test_what_a_pixel_shows_opencv_projects_back_onto_it(axis: str) -> None:
    picture = spotless(THINGS, axis)
    T = np.linalg.inv(picture.truth.view.T_base_camera)
    point = picture.truth.point.reshape(-1, 3)[::97] @ T[:3, :3].T + T[:3, 3]
    seen = np.stack([-point[:, 1], point[:, 0], point[:, 2]], axis=-1) if axis == "u" else point
    camera = eye(axis)
    pixel, _ = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), camera.matrix, camera.lens)
    v, u = np.divmod(np.arange(640 * 480)[::97], 640)
    np.testing.assert_allclose(pixel.reshape(-1, 2), np.stack([u, v], axis=-1), atol=1e-6)


def test_every_pixel_lies_on_the_solid_that_it_shows() -> None:
    truth = spotless(THINGS).truth
    on_floor, on_ball, on_block = (truth.point[truth.solid == i] for i in range(3))
    assert min(map(len, (on_floor, on_ball, on_block))) > 1000
    np.testing.assert_allclose(on_floor[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(on_ball - BALL.centre, axis=1), BALL.radius, atol=1e-12)
    T = np.linalg.inv(BLOCK.T_base_block)
    inside = on_block @ T[:3, :3].T + T[:3, 3]
    out = np.abs(inside - [0, 0, 0.005]) - [0.025, 0.02, 0.005]
    np.testing.assert_allclose(out.max(axis=1), 0.0, atol=1e-12)


def test_boxes_around_solids_cut_nothing_off() -> None:
    view = spotless(THINGS).truth.view
    whole = view.along(view.all.ray)
    np.testing.assert_array_equal(view.all.solid, whole.solid)
    np.testing.assert_allclose(view.all.distance, whole.distance, rtol=1e-12)


@pytest.mark.parametrize("solid", [Floor(), BALL, BLOCK, BOARD], ids=lambda solid: type(solid).__name__)
def test_seen_from_above_normals_point_at_who_looks(solid: Solid) -> None:
    rng = np.random.default_rng(3)
    away = solid.corners()
    aim = (MIDDLE if away is None else away.mean(axis=0)) + rng.uniform(-0.008, 0.008, (50, 3))
    start = aim + np.array([0.0, 0.0, 0.3])
    direction = aim - start
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    distance = solid.hit(start, direction)
    normal = solid.normal(start + distance[:, None] * direction)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    assert ((normal * direction).sum(axis=1) < 0).all()


def test_of_two_solids_in_one_plane_the_later_one_is_seen() -> None:
    truth = spotless(EmulatedScene((Floor(), BOARD))).truth
    T = np.linalg.inv(BOARD.T_base_board)
    place = truth.point.reshape(-1, 3) @ T[:3, :3].T + T[:3, 3]
    beyond = (np.abs(place[:, :2] - [0.04, 0.025]) - [0.06, 0.045]).max(axis=1)
    clear = np.abs(beyond) > 1e-6
    np.testing.assert_array_equal((truth.solid.ravel() == 1)[clear], (beyond < 0)[clear])


@pytest.mark.parametrize("tilt", [(0, 0, 0), (0, 0, 45), (12, -8, 20), (-20, 10, 15)])
def test_corners_of_the_board_show_where_they_truly_are(tilt: tuple[float, float, float]) -> None:
    picture = spotless(EmulatedScene((Floor(), BOARD)), "v", *tilt, lit=False, ambient=140.0)
    T = above(*tilt)
    true = eye().pixels((BOARD.grid().reshape(-1, 3) - T[:3, 3]) @ T[:3, :3])
    true = true[((true > 15) & (true < [624, 464])).all(axis=1)]
    assert len(true) > 40
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    start = (true + 0.4).reshape(-1, 1, 2).astype(np.float32)
    found = cv2.cornerSubPix(picture.image, start, (8, 8), (-1, -1), stop).reshape(-1, 2)
    off = found - true
    assert np.sqrt((off**2).mean()) < 0.05
    assert np.abs(off.mean(axis=0)).max() < 0.02


def test_the_board_is_found_with_the_stripe_across_it() -> None:
    picture = spotless(EmulatedScene((Floor(), BOARD)), ambient=110.0, noise_grey=2.0, speckle=0.1)
    board = find_board(picture.image, columns=9, rows=6)
    T = above(8, 5, 20)
    true = eye().pixels((BOARD.grid().reshape(-1, 3) - T[:3, 3]) @ T[:3, :3]).reshape(6, 9, 2)
    assert board is not None
    assert len(board.orientations) == 1
    assert np.nanmedian(np.linalg.norm(board.orientations[0] - true, axis=-1)) < 0.1


def test_the_outward_square_at_the_origin_is_dark() -> None:
    T = above(8, 5, 20)
    squares = np.array([[-0.005, -0.005, 0], [0.005, -0.005, 0], [0.005, 0.005, 0]])
    points = squares @ BOARD.T_base_board[:3, :3].T + BOARD.T_base_board[:3, 3]
    u, v = np.rint(eye().pixels((points - T[:3, 3]) @ T[:3, :3])).astype(int).T
    dark, light, inward = spotless(EmulatedScene((Floor(), BOARD)), lit=False, ambient=140.0).image[v, u].astype(float)
    assert dark < 0.3 * light
    assert inward < 0.3 * light


def test_sheets_pass_through_their_source() -> None:
    assert SHEET.off(SHEET.source) == 0.0
