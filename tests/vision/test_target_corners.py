"""Boards drawn flat and seen in perspective: every kind is found, named, and told from what cannot be told apart."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.cli import main
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.writing import save
from robolaser.errors import DataError, ImageError
from robolaser.geometry.rigid_motion import from_angles, pose
from robolaser.model.sensors.in_cell import Mounting
from robolaser.vision.target_corners import points_of_target

SIZE = (960, 720)
K = np.array([[1100.0, 0.0, 479.5], [0.0, 1100.0, 359.5], [0.0, 0.0, 1.0]])
PX = 40  # of the flat drawing, to a square
MARGIN = 1.5  # squares of paper around the pattern's first point
BOARDS = {
    "checkerboard": Board(7, 6, 0.03),
    "charuco": Board(6, 4, 0.03, "charuco", 0.022, "DICT_4X4_50"),
    "circles": Board(7, 5, 0.03, "circles"),
    "square circles": Board(5, 5, 0.03, "circles"),
    "modified circles": Board(5, 5, 0.03, "modified_circles"),
}


def drawn(name: str) -> tuple[np.ndarray, float]:
    """The board from straight above, and how far its first point is from the drawing's corner [squares]."""
    board = BOARDS[name]
    columns, rows = board.columns, board.rows
    if board.kind == "charuco":
        markers = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        printed = cv2.aruco.CharucoBoard((columns + 1, rows + 1), 0.03, 0.022, markers)
        flat = printed.generateImage(((columns + 1) * PX, (rows + 1) * PX))
    elif board.kind == "checkerboard":
        light = np.add.outer(np.arange(rows + 1), np.arange(columns + 1)) % 2
        flat = np.kron(255 * light, np.ones((PX, PX))).astype(np.uint8)
    else:
        flat = np.full(((rows + 1) * PX, (columns + 1) * PX), 255, np.uint8)
        for row in range(rows):
            for column in range(columns):
                cv2.circle(
                    flat,
                    ((column + 1) * PX, (row + 1) * PX),
                    int((0.4 if name.startswith("modified") and row == column == 0 else 0.3) * PX),
                    0,
                    -1,
                    cv2.LINE_AA,
                )
    return np.pad(flat, int(MARGIN * PX), constant_values=255), 1.0 + MARGIN


@cache
def images(name: str) -> tuple[np.ndarray, ...]:
    return tuple(looked_at(name, T) for T in poses())


def looked_at(name: str, T_camera_board: np.ndarray) -> np.ndarray:
    """The board before a pinhole camera, on grey ground."""
    flat, first = drawn(name)
    square = BOARDS[name].square_m
    H = K @ T_camera_board[:3, [0, 1, 3]]
    to_board = np.array([[square / PX, 0, -first * square], [0, square / PX, -first * square], [0, 0, 1]])
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])  # between pixels' middles and edges
    # circles are drawn about pixels' middles, squares between pixels' edges
    flat_half = np.eye(3) if "circles" in BOARDS[name].kind else half
    H = np.linalg.inv(half) @ np.diag([2.0, 2.0, 1.0]) @ half @ H @ to_board @ flat_half
    fine = cv2.warpPerspective(flat, H, (2 * SIZE[0], 2 * SIZE[1]), flags=cv2.INTER_LINEAR, borderValue=120)
    return cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA)


def poses(count: int = 8) -> np.ndarray:
    """T_camera_board: tilted, turned, near and far."""
    rng = np.random.default_rng(0)
    R = from_angles(*rng.uniform(-0.45, 0.45, (3, count)))
    return pose(R, rng.uniform((-0.03, -0.02, 0.48), (0.03, 0.02, 0.65), (count, 3)) - R @ [0.085, 0.07, 0.0])


def recording(folder: Path, name: str, write: Callable[[Path, np.ndarray], None] | None = None) -> Dataset:
    """A camera in the cell whose own frame is the base's, the board's frame the flange's."""
    T = poses()
    (folder / "images").mkdir(parents=True)
    files = tuple(f"images/{i}.png" for i in range(len(T)))
    for file, image in zip(files, images(name), strict=True):
        (write or (lambda path, image: cv2.imwrite(str(path), image)))(folder / file, image)
    described = Dataset(
        name="recording",
        kind="camera",
        poses=Poses(tuple(map(str, range(len(T)))), T_base_flange=T, image=files),
        points=Points(np.empty(0, dtype=np.int64), ()),
        image_px=SIZE,
        board=BOARDS[name],
        options=Mounting("base"),
        placed=False,
    )
    save(described, folder)
    return robolaser.load(folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Points:
    """Points of a board in grey, all of it in sight."""
    return points_of_target(recording(tmp_path_factory.mktemp("whole"), "charuco"))[1].points


@pytest.mark.parametrize("name", BOARDS)
def test_points_are_found_where_the_camera_shows_them(tmp_path, name):
    made = recording(tmp_path, name)
    seen, dataset = points_of_target(made)
    assert sum(one.points > 0 for one in seen) > len(seen) / 2
    T, points = made.poses.T_base_flange, dataset.points
    places = [points.xyz]
    board = BOARDS[name]
    if name in ("circles", "checkerboard", "square circles"):  # several ways to lay the frame, of which one is kept
        far = board.square_m * np.array([board.columns - 1, board.rows - 1, 0])
        places.append((far - points.xyz) * [1, 1, 0])
        if name.startswith("square"):
            turned = points.xyz[:, [1, 0, 2]]
            places += [np.abs(turned - far * [0, 1, 0]), np.abs(turned - far * [1, 0, 0])]
    off = []
    for place in places:
        shown = ((T[points.pose, :3, :3] @ place[..., None])[..., 0] + T[points.pose, :3, 3]) @ K.T
        off.append(np.linalg.norm(shown[:, :2] / shown[:, 2:] - points.pixel, axis=1))
    assert min(np.sqrt(np.mean(one**2)) for one in off) < 0.35


def test_a_command_reads_images_and_the_next_one_calibrates(tmp_path, capsys):
    recording(tmp_path, "charuco")
    assert main(["extract", str(tmp_path)]) in (None, 0)
    assert "images, 0 skipped" in capsys.readouterr().out
    result = calibrate(robolaser.load(tmp_path))
    assert result.row_errors[0].rms < 0.35
    assert result.value("fx") == pytest.approx(1100.0, rel=0.01)
    np.testing.assert_allclose([result.value(f"hand_eye.{part}") for part in "xyz"], 0.0, atol=3e-3)


def test_a_board_seen_in_part_still_gives_its_corners_by_name(whole, tmp_path):
    def covered(path: Path, image: np.ndarray) -> None:
        image = image.copy()
        image[:, : SIZE[0] // 3] = 120
        cv2.imwrite(str(path), image)

    part = points_of_target(recording(tmp_path / "part", "charuco", covered))[1].points
    assert 0 < len(part) < len(whole)
    pixel = {(pose, name): at for pose, name, at in zip(whole.pose, whole.names, whole.pixel, strict=True)}
    for pose_, name, at in zip(part.pose, part.names, part.pixel, strict=True):
        np.testing.assert_allclose(at, pixel[pose_, name], atol=0.3)


@pytest.mark.parametrize("depth", ["colour", "twelve bits"])
def test_colour_and_deeper_grey_show_the_same(whole, tmp_path, depth):
    def deeper(path: Path, image: np.ndarray) -> None:
        other = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if depth == "colour" else image.astype(np.uint16) * 16
        cv2.imwrite(str(path), other)

    other = points_of_target(recording(tmp_path / "other", "charuco", deeper))[1].points
    np.testing.assert_allclose(other.pixel, whole.pixel, atol=0.05)


def test_a_board_that_is_never_seen_is_told_and_nothing_is_written(tmp_path, capsys):
    recording(tmp_path, "charuco", lambda path, image: cv2.imwrite(str(path), np.full_like(image, 90)))
    assert main(["extract", str(tmp_path)]) == 1
    assert "None of 8 images shows a ChArUco board of 6 x 4" in capsys.readouterr().err
    assert not (tmp_path / "points.csv").exists()


def test_a_target_that_looks_the_same_after_every_quarter_turn_needs_a_flange_that_turns(tmp_path):
    made = recording(tmp_path, "square circles")
    still = made.poses.T_base_flange.copy()
    still[:, :3, :3] = np.eye(3)
    with pytest.raises(ImageError, match="the same after every quarter turn"):
        points_of_target(replace(made, poses=replace(made.poses, T_base_flange=still)))


def test_a_dictionary_that_opencv_does_not_have_is_told(tmp_path):
    made = recording(tmp_path, "charuco")
    with pytest.raises(DataError, match="Did you mean 'DICT_4X4_50'"):
        points_of_target(replace(made, board=replace(made.board, dictionary="DICT_4x4_50")))
