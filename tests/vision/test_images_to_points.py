"""The way from image files to points, on painted pictures and on a real recording."""

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
from painted import HEIGHT, SQUARE, WIDTH, Scene, scene, session, written
from scipy.spatial.transform import Rotation

from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Poses
from robolaser.errors import ImageError
from robolaser.vision.board import find_board
from robolaser.vision.extract import Extraction
from robolaser.vision.recordings import points_from_images

BOARD = Board(7, 6, SQUARE)
REAL = Path(__file__).parents[2] / "examples" / "etna-s2"


def extracted(images, size=(WIDTH, HEIGHT), axis="v", board=BOARD, turns=(), progress=None):
    T_base_flange = np.tile(np.eye(4), (len(images), 1, 1))
    T_base_flange[: len(turns), :3, :3] = turns or np.eye(3)
    names, files = zip(*images, strict=True)
    poses = Poses(names, T_base_flange=T_base_flange, image=tuple(str(file.relative_to("/")) for file in files))
    recording = Dataset("r", poses, stripe_axis=axis, image_px=size, board=board, folder=Path("/"))
    return points_from_images(recording, progress=progress)[0]


def misplaced(found: Extraction, scenes: list[Scene]) -> list[np.ndarray]:
    """Error of the places of each scene's points along the board [m]."""
    errors = []
    for k, one in enumerate(scenes):
        here = found.points.take(found.points.pose == k)
        errors.append(np.linalg.norm(one.place(here.pixel) - here.xyz[:, :2], axis=-1))
    return errors


def assert_near(found: Extraction, scenes: list[Scene], *, more_than: int = 0, within_m: float = 2e-4) -> None:
    for error, one in zip(misplaced(found, scenes), scenes, strict=True):
        assert len(error) > more_than
        assert error.max() < within_m, one


@pytest.fixture(scope="module")
def scenes():
    return session()


@pytest.fixture(scope="module")
def images(scenes, tmp_path_factory):
    return written(scenes, tmp_path_factory.mktemp("session"))


@pytest.fixture(scope="module")
def found(images):
    return extracted(images)


def test_every_point_shows_its_place_on_the_board(found, scenes):
    assert_near(found, scenes, more_than=60, within_m=1.2e-4)
    np.testing.assert_array_equal(found.points.xyz[:, 2], 0.0)


def test_every_point_lies_in_the_light_sheet(found, scenes):
    for k, one in enumerate(scenes):
        off_m = one.above_sheet(found.points.pixel[found.points.pose == k])
        assert abs(off_m.mean()) < 5e-6
        assert np.abs(off_m).max() < 6e-5


def test_points_are_named_once_and_frames_reported(found, images):
    assert len(set(zip(found.points.pose, found.points.names, strict=True))) == len(found)
    assert [frame.pose for frame in found.frames] == [pose for pose, _ in images]
    assert sum(frame.points for frame in found.frames) == len(found)
    for frame in found.frames:
        assert frame.skipped == ""
        assert 0 < frame.corner_rms_px < 0.1
        assert 0 < frame.line_rms_px < 0.15
    assert 0.005 < found.pixel_noise_px < 0.15


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_camera_mounted_turned_sees_the_same_places(quarters, images, scenes, tmp_path):
    turned = []
    for pose, path in images[:3]:
        target = tmp_path / path.name
        cv2.imwrite(str(target), np.ascontiguousarray(np.rot90(cv2.imread(str(path), 0), quarters)))
        turned.append((pose, target))
    lying = quarters % 2 == 1
    found = extracted(turned, (HEIGHT, WIDTH) if lying else (WIDTH, HEIGHT), "u" if lying else "v")
    for _ in range(quarters):
        width = WIDTH if lying else HEIGHT
        pixel = found.points.pixel
        pixel[:] = np.stack([width - 1 - pixel[:, 1], pixel[:, 0]], axis=-1)
        lying = not lying
    assert_near(found, scenes[:3], more_than=60)


def test_where_the_plate_ends_the_stripe_is_no_longer_on_the_board(scenes, tmp_path):
    on_edge = [Scene(one.R, one.t, plate=0.060) for one in scenes[:4]]
    found = extracted(written(on_edge, tmp_path))
    assert {frame.skipped for frame in found.frames} == {""}
    assert found.points.xyz[:, 1].max() < 0.0605
    assert found.points.xyz[:, 1].max() > 0.055
    assert_near(found, on_edge)


def test_a_mirror_image_of_the_stripe_is_not_followed(scenes, tmp_path):
    glossy = [Scene(one.R, one.t, light=200, mirror=0.5) for one in scenes[:3]]
    found = extracted(written(glossy, tmp_path))
    for k, one in enumerate(glossy):
        here = found.points.pose == k
        assert here.sum() > 60
        assert np.abs(one.above_sheet(found.points.pixel[here])).max() < 1e-4


def test_a_board_that_the_stripe_runs_across_is_found(tmp_path):
    crossed = [scene(tilt, (0.02, 0, 0.19)) for tilt in [(4, 12, 5), (15, -10, 190), (-10, 16, 100)]]
    assert_near(extracted(written(crossed, tmp_path)), crossed, more_than=20)


def test_squares_under_the_stripe_bias_no_point(tmp_path):
    """The stripe runs through the corners; what the squares' edges bite is left out."""
    crossing = [scene(tilt, (0.03, 0, 0.165), light=150) for tilt in [(4, 8, 5), (12, -10, -4), (-10, 12, 8)]]
    found = extracted(written(crossing, tmp_path))
    for k, one in enumerate(crossing):
        here = found.points.pose == k
        assert here.sum() > 20
        assert np.sqrt(np.mean(one.above_sheet(found.points.pixel[here]) ** 2)) < 6e-5


def test_frames_without_board_or_stripe_say_so(images, scenes, tmp_path):
    bare = tmp_path / "bare.png"
    cv2.imwrite(str(bare), np.full((HEIGHT, WIDTH), 30, np.uint8))
    dark = tmp_path / "dark.png"
    cv2.imwrite(str(dark), Scene(scenes[0].R, scenes[0].t, light=0.0).paint(0))
    found = extracted([*images[1:4], ("bare", bare), ("dark", dark)])
    reasons = {frame.pose: frame.skipped for frame in found.frames}
    assert reasons["bare"] == "no board"
    assert reasons["dark"] in {"no stripe", "no stripe on the board"}
    assert set(found.points.pose) == {0, 1, 2}


def test_two_views_give_points_without_a_lens(images):
    found = extracted(images[1:3])
    assert not found.lens.known
    assert set(found.points.pose) == {0, 1}


def test_every_image_is_told_to_whoever_waits(images):
    told = []
    extracted(images[:2], progress=lambda what, share: told.append((what, share)))
    assert told == [("looking at images", 0.5), ("looking at images", 1.0)]


def test_an_image_of_another_size_is_named(images):
    with pytest.raises(ImageError, match=r"image0\.png is 640 x 480 .* 640 x 512"):
        extracted(images[:1], (WIDTH, 512))


def test_a_real_recording_keeps_board_robot_and_sheet_together():
    rows = list(csv.DictReader((REAL / "poses.csv").read_text().splitlines()))[:4]
    found = extracted([(row["pose"], REAL / row["image"]) for row in rows], (1280, 1024))
    assert {frame.skipped for frame in found.frames} == {""}
    assert all(80 <= frame.points <= 250 for frame in found.frames)
    camera = np.array([[2399.0, 0, 640], [0, 2406, 520], [0, 0, 1]])
    bent = np.array([-0.062, 0, 0, 0, 0])
    pattern = SQUARE * np.stack([*np.meshgrid(np.arange(7), np.arange(6)), np.zeros((6, 7))], axis=-1)
    points, turns, flanges = [], [], []
    for k, row in enumerate(rows):
        (grid,) = find_board(cv2.imread(str(REAL / row["image"]), 0), columns=7, rows=6).orientations
        there = np.isfinite(grid).all(axis=-1)
        _, turn, shift = cv2.solvePnP(pattern[there], grid[there], camera, bent)
        turns.append(Rotation.from_rotvec(np.ravel(turn)))
        flanges.append(Rotation.from_quat([float(row[name]) for name in ("qx", "qy", "qz", "qw")]))
        points.append(turns[-1].apply(found.points.xyz[found.points.pose == k]) + np.ravel(shift))
    together = np.concatenate(points) - np.mean(np.concatenate(points), axis=0)
    assert np.sqrt(np.mean((together @ np.linalg.svd(together, full_matrices=False)[2][2]) ** 2)) < 3e-4
    for turn, flange in zip(turns[1:], flanges[1:], strict=True):
        seen, driven = (turn * turns[0].inv()).magnitude(), (flange.inv() * flanges[0]).magnitude()
        assert abs(seen - driven) < np.radians(2)


def test_flange_turns_keep_a_square_boards_frame_through_a_large_roll(tmp_path):
    """Six by six corners look alike after each quarter turn; between these images the camera rolls further."""
    tilts = [(4, 10, 0), (12, -8, 120), (-10, 6, -125), (8, 12, 75)]
    scenes = [scene(tilt, (-0.014, 0, 0.18), columns=6, rows=6) for tilt in tilts]
    flange = np.stack([one.R.T for one in scenes])
    found = extracted(written(scenes, tmp_path), board=Board(6, 6, SQUARE), turns=list(flange))
    assert_near(found, scenes, more_than=60)


def on_a_table(thickness):
    tilts = [(4, 8, 5), (12, -10, -4), (6, -16, 3)]
    return [scene(tilt, (-0.045, 0, 0.31), light=150, border=0.002, floor=thickness, width=6e-4) for tilt in tilts]


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    """Points of a board without thickness."""
    return len(extracted(written(on_a_table(0.0), tmp_path_factory.mktemp("flat"))))


@pytest.mark.parametrize(("thickness", "fewer"), [(0.008, 3), (0.001, 5)])
def test_the_stripe_on_the_table_beside_a_thick_board_is_no_point_of_it_and_that_is_said(
    thickness, fewer, flat, tmp_path
):
    """Six tenths of the stripe lie on a table, so that a line through most of its centres is the table's."""
    thick = on_a_table(thickness)
    found = extracted(written(thick, tmp_path))
    low, high = -SQUARE - 0.002, SQUARE * np.array([7, 6]) + 0.002
    assert set(found.points.pose) == {0, 1, 2}
    assert np.all((found.points.xyz[:, :2] > low) & (found.points.xyz[:, :2] < high))
    assert_near(found, thick, within_m=1e-4)
    assert all(frame.left_out > 0.5 for frame in found.frames)
    assert any("in 3 of 3 images the stripe has a step beside the board's squares" in doubt for doubt in found.doubts)
    assert flat > fewer * len(found)


def test_a_stripe_that_never_crosses_the_squares_is_said_to_lie_beside_them(found):
    assert all(frame.beside for frame in found.frames)
    assert "crosses none of the board's squares" in found.doubts[0]
