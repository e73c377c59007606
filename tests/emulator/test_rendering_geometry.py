from pathlib import Path

import cv2
import numpy as np
import pytest
from scenes import MIDDLE, above, eye, face_up, grey, heading, near, photograph, scene
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.board import Board, board_print
from robolaser.data.dataset import Dataset, Poses
from robolaser.emulator.world.solids import Cuboid, Floor, PrintedBoard, Solid, Sphere
from robolaser.geometry.rigid_motion import inverse
from robolaser.vision.recordings import points_from_images

BALL = Sphere(near(0.012, 0.01, 0.018), 0.018)
BLOCK = Cuboid(near(-0.02, -0.03, 0.0), (0.05, 0.04, 0.01), heading(17))
BOARD = PrintedBoard(face_up(near(-0.04, 0.025, 0.0)), board_print(Board(9, 6, 0.010)))
T = above()


def seen(*solids: Solid) -> tuple[Array, Array]:
    """What each pixel shows: points, (n, 3), and numbers of the solids, (n,)."""
    camera = scene(*solids)
    direction = camera.eye.all_rays @ T[:3, :3].T
    distance, index = camera.cast(T[:3, 3], direction)
    return T[:3, 3] + distance[:, None] * direction, index


def shown(point: Array) -> Array:
    """Where the camera shows points of its own frame, (n, 3) -> (n, 2)."""
    return eye().optics.pixels(point, eye().lens)


def corners() -> Array:
    """Of the board in the base frame, (54, 3)."""
    x, y = np.meshgrid(np.arange(9), np.arange(6))
    inside = 0.010 * np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=-1)
    return inside @ BOARD.T_base_board[:3, :3].T + BOARD.T_base_board[:3, 3]


@pytest.mark.parametrize("axis", ["u", "v"])
def test_what_a_pixel_shows_opencv_projects_back_onto_it(axis: str) -> None:
    camera = eye(axis)
    point = 0.3 * camera.all_rays[::97]
    inside = np.stack([-point[:, 1], point[:, 0], point[:, 2]], axis=-1) if axis == "u" else point
    f, s_u, s_v, u_0, v_0 = (camera.optics.truth[name] for name in ("f", "s_u", "s_v", "u_0", "v_0"))
    K = np.array([[f / s_u, 0.0, u_0], [0.0, f / s_v, v_0], [0.0, 0.0, 1.0]])
    pixel, _ = cv2.projectPoints(inside, np.zeros(3), np.zeros(3), K, camera.lens)
    v, u = np.divmod(np.arange(640 * 480)[::97], 640)
    np.testing.assert_allclose(pixel.reshape(-1, 2), np.stack([u, v], axis=-1), atol=1e-6)


def test_every_pixel_lies_on_the_solid_that_it_shows() -> None:
    point, index = seen(Floor(), BALL, BLOCK)
    on_floor, on_ball, on_block = (point[index == i] for i in range(3))
    assert min(map(len, (on_floor, on_ball, on_block))) > 1000
    np.testing.assert_allclose(on_floor[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(on_ball - BALL.centre_m, axis=1), BALL.radius_m, atol=1e-12)
    inside = (on_block - BLOCK.origin_m) @ Rotation.from_quat(BLOCK.quat).as_matrix()
    out = np.abs(inside - [0, 0, 0.005]) - [0.025, 0.02, 0.005]
    np.testing.assert_allclose(out.max(axis=1), 0.0, atol=1e-12)


@pytest.mark.parametrize("solid", [Floor(), BALL, BLOCK, BOARD], ids=lambda solid: type(solid).__name__)
def test_seen_from_above_normals_point_at_who_looks(solid: Solid) -> None:
    aims = {Floor: MIDDLE, Sphere: BALL.centre_m, Cuboid: BLOCK.origin_m, PrintedBoard: corners().mean(axis=0)}
    start = np.add(aims[type(solid)], [0.0, 0.0, 0.3])
    direction = np.random.default_rng(3).uniform(-0.02, 0.02, (50, 3)) - [0.0, 0.0, 1.0]
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    normal = solid.normal(start + solid.hit(start, direction)[:, None] * direction)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    assert ((normal * direction).sum(axis=1) < 0).all()


def test_of_two_solids_in_one_plane_the_later_one_is_seen() -> None:
    point, index = seen(Floor(), BOARD)
    place = (point - BOARD.T_base_board[:3, 3]) @ BOARD.T_base_board[:3, :3]
    beyond = (np.abs(place[:, :2] - [0.04, 0.025]) - [0.06, 0.045]).max(axis=1)
    clear = np.abs(beyond) > 1e-6
    np.testing.assert_array_equal((index == 1)[clear], (beyond < 0)[clear])


@pytest.mark.parametrize("tilt", [(0, 0, 0), (0, 0, 45), (12, -8, 20), (-20, 10, 15)])
def test_corners_of_the_board_show_where_they_truly_are(tilt: tuple[float, float, float]) -> None:
    T = above(*tilt)
    image = photograph(scene(Floor(), BOARD, ambient_grey=140.0), T, lit=False)
    true = shown((corners() - T[:3, 3]) @ T[:3, :3])
    true = true[((true > 15) & (true < [624, 464])).all(axis=1)]
    assert len(true) > 40
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    start = (true + 0.4).reshape(-1, 1, 2).astype(np.float32)
    off = cv2.cornerSubPix(image, start, (8, 8), (-1, -1), stop).reshape(-1, 2) - true
    assert np.sqrt((off**2).mean()) < 0.05
    assert np.abs(off.mean(axis=0)).max() < 0.02


def test_the_outward_square_at_the_origin_is_dark() -> None:
    squares = np.array([[-0.005, -0.005, 0], [0.005, -0.005, 0], [0.005, 0.005, 0]])
    points = squares @ BOARD.T_base_board[:3, :3].T + BOARD.T_base_board[:3, 3]
    u, v = np.rint(shown((points - T[:3, 3]) @ T[:3, :3])).astype(int).T
    dark, bright, inward = grey(scene(Floor(), BOARD, ambient_grey=140.0), T, lit=False)[v, u]
    assert dark < 0.3 * bright
    assert inward < 0.3 * bright


def test_on_a_charuco_board_of_which_a_part_is_seen_points_have_their_places(tmp_path: Path) -> None:
    board = Board(13, 9, 0.02, "charuco", 0.015, "DICT_4X4_100")
    T_base_board = face_up(near(-0.12, 0.08, 0.0))
    there = scene(Floor(), PrintedBoard(T_base_board, board_print(board)), ambient_grey=90.0, noise_grey=1.0)
    ways = [above(*tilt) for tilt in ((8, 5, 20), (-10, 8, 5), (5, -12, -15), (15, 3, 40))]
    for row, T in enumerate(ways):
        for lit in (True, False):
            cv2.imwrite(str(tmp_path / f"{row}{lit}.png"), photograph(there, T, lit=lit, seed=row))
    named, lit, unlit = (tuple(f"{row}{end}" for row in range(len(ways))) for end in ("", "True.png", "False.png"))
    poses = Poses(named, T_base_flange=np.stack(ways), image=lit, extra={"image_off": unlit})
    recording = Dataset("r", poses, stripe_axis="v", image_px=(640, 480), board=board, folder=tmp_path)
    found, both = points_from_images(recording)
    (camera,) = (sensor for sensor in both.sensors if sensor.data.kind == "camera")
    assert (np.bincount(both.points.pose[camera.rows]) < board.columns * board.rows).all()
    for row, T in enumerate(ways):
        here = found.points.take(found.points.pose == row)
        assert len(here) > 60
        T_board_camera = inverse(T_base_board) @ T
        start, ray = T_board_camera[:3, 3], there.eye.rays(here.pixel) @ T_board_camera[:3, :3].T
        place = start[:2] - start[2] / ray[:, 2:] * ray[:, :2]
        assert np.linalg.norm(place - here.xyz[:, :2], axis=-1).max() < 2e-4
