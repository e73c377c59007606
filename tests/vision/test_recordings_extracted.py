"""Recordings on disk: what `robolaser extract` makes of boards, scans, repeats and images without the laser."""

import shutil
import subprocess
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn import HEIGHT as LINES
from drawn import STRAIGHT, WIDTH, exposed, profile
from painted import HEIGHT, SQUARE, session

from robolaser.cli import main
from robolaser.data.board import Board
from robolaser.data.loading import load
from robolaser.data.stripe_file import open_stripes
from robolaser.errors import ImageError
from robolaser.vision import recordings
from robolaser.vision.board import find_board
from robolaser.vision.extract import Look
from robolaser.vision.recordings import points_from_images, stripes_from_images
from robolaser.vision.stripe_trace import trace

BOARD = f"[board]\ncolumns = 7\nrows = 6\nsquare_m = {SQUARE}\n"


def described(folder, height_px, extra=""):
    folder.mkdir(exist_ok=True)
    (folder / "dataset.toml").write_text(
        'format = "robolaser-dataset/1"\nname = "r"\n[sensor]\nkind = "stripe"\nstripe_axis = "v"\n'
        f"[image]\nwidth_px = {WIDTH}\nheight_px = {height_px}\n[target]\nplaced = false\n{extra}"
    )


def posed(folder, columns, rows):
    """Write poses.csv with these image columns, a list of names a pose."""
    lines = [",".join(["pose", "time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", *columns])]
    lines += [",".join([f"p{i}", str(i), *"000000", "1", *names]) for i, names in enumerate(rows)]
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")


def taken(folder, name, image):
    cv2.imwrite(str(folder / name), image)
    return name


def scan(folder, *, off=True, poses=3):
    """A stripe that moves a pixel from pose to pose before a lamp, beside a dead lit line."""
    described(folder, LINES)
    room = 20 + profile(STRAIGHT + 80, 2, 140)
    rows = []
    for i in range(poses):
        lit = exposed(room + profile(STRAIGHT + i, 2, 110), 2.0, i)
        again = exposed(room + profile(STRAIGHT + i, 2, 110), 2.0, 10 + i)
        rows.append([taken(folder, f"a{i}.png", lit), taken(folder, f"b{i}.png", again)])
        if off:
            rows[-1].append(taken(folder, f"o{i}.png", exposed(room, 2.0, 20 + i)))
    rows.insert(1, [""] * len(rows[0]))
    posed(folder, ["image", "image_2", "image_off"][: len(rows[0])], rows)
    return folder


@pytest.fixture(scope="module")
def boards(tmp_path_factory):
    """Five poses of a board, each shot twice lit and once unlit."""
    folder = tmp_path_factory.mktemp("boards")
    described(folder, HEIGHT, BOARD)
    rows = []
    for k, one in enumerate(session(light=300.0, ambient=120.0)):
        unlit = replace(one, light=0.0)
        names = [taken(folder, f"{kind}{k}.png", shown.paint(seed)) for kind, shown, seed in
                 (("a", one, k), ("b", one, 50 + k), ("o", unlit, 90 + k))]  # fmt: skip
        rows.append(names)
    rows.append(["", "", ""])
    posed(folder, ["image", "image_2", "image_off"], rows)
    return folder


def test_a_scan_becomes_stripes_beside_its_poses(tmp_path, capsys):
    folder = scan(tmp_path / "scan")
    assert main(["extract", str(folder)]) == 0
    assert "6 images, 0 without" in capsys.readouterr().out
    stripes = open_stripes(folder / "stripes.npy")
    assert set(stripes["pose"]) == {0, 2, 3}
    moved = np.array([0, np.nan, 1, 2])[stripes["pose"]]
    error = stripes["u"] - STRAIGHT[np.rint(stripes["v"]).astype(int)] - moved
    assert abs(error.mean()) < 0.01
    assert 0.7 < error.std() / np.median(stripes["std"]) < 1.4
    assert len(stripes) >= 0.95 * 6 * LINES
    assert not (folder / "points.csv").exists()


def test_without_images_of_the_room_the_brighter_line_wins(tmp_path):
    blocks = list(stripes_from_images(load(scan(tmp_path / "scan", off=False))))
    error = blocks[0]["u"] - STRAIGHT[np.rint(blocks[0]["v"]).astype(int)]
    assert abs(np.median(error) - 80) < 0.05


def test_stripes_are_not_overwritten_unasked(tmp_path, capsys):
    folder = scan(tmp_path / "scan", poses=1)
    assert main(["extract", str(folder)]) == 0
    assert main(["extract", str(folder)]) == 1
    assert "stripes.npy" in capsys.readouterr().err
    assert main(["extract", str(folder), "--force"]) == 0


def test_a_scan_is_copied_whole_to_its_output(tmp_path):
    folder, out = scan(tmp_path / "scan", poses=2), tmp_path / "out"
    assert main(["extract", str(folder), "--output", str(out)]) == 0
    assert not (folder / "stripes.npy").exists()
    again = load(out)
    assert again.poses.image == ("a0.png", "", "a1.png")
    assert again.poses.extra["image_off"] == ("o0.png", "", "o1.png")
    for name in ("a0", "b1", "o1"):
        assert (out / f"{name}.png").read_bytes() == (folder / f"{name}.png").read_bytes()
    stored = open_stripes(out / "stripes.npy")
    np.testing.assert_array_equal(stored, np.concatenate(list(stripes_from_images(load(out)))))


@pytest.mark.parametrize("name", ["a1.png", "b1.png", "o1.png"])
def test_every_image_must_be_there_and_whole(name, tmp_path):
    folder = scan(tmp_path / "scan")
    (folder / name).write_bytes((folder / name).read_bytes()[:40])
    with pytest.raises(ImageError, match=name):
        list(stripes_from_images(load(folder)))
    (folder / name).unlink()
    assert main(["extract", str(folder)]) == 1
    assert not (folder / "stripes.npy").exists()


def test_a_scan_of_nothing_says_so(tmp_path):
    described(tmp_path, LINES)
    posed(tmp_path, ["image"], [[taken(tmp_path, "dark.png", exposed(np.full((LINES, WIDTH), 30.0), 2.0))]])
    with pytest.raises(ImageError, match="stripe_axis"):
        list(stripes_from_images(load(tmp_path)))


def test_a_recording_without_images_says_so(tmp_path):
    described(tmp_path, LINES)
    posed(tmp_path, [], [[]])
    with pytest.raises(ImageError, match="image"):
        list(stripes_from_images(load(tmp_path)))


def test_the_board_is_found_without_the_laser_and_repeats_show_the_same_points(boards):
    found, dataset = points_from_images(load(boards))
    points = dataset.sensors[0].data.points
    assert {frame.skipped for frame in found.frames} == {""}
    assert set(points.repeat) == {1, 2}
    first = {
        (pose, name) for pose, name, shot in zip(points.pose, points.names, points.repeat, strict=True) if shot == 1
    }
    second = {
        (pose, name) for pose, name, shot in zip(points.pose, points.names, points.repeat, strict=True) if shot == 2
    }
    assert len(first & second) > 0.9 * len(first)
    for k, one in enumerate(session(light=300.0, ambient=120.0)):
        here = points.pose == k
        assert here.sum() > 100
        assert np.linalg.norm(one.place(points.pixel[here]) - points.xyz[here, :2], axis=-1).max() < 2e-4
        assert abs(one.above_sheet(points.pixel[here]).mean()) < 1e-5


def test_extracted_repeats_are_read_back(boards, tmp_path):
    assert main(["extract", str(boards), "--output", str(tmp_path / "out")]) == 0
    again = load(tmp_path / "out")
    assert set(again.sensors[0].data.points.repeat) == {1, 2}
    assert [one.name for one in again.members] == ["stripe", "camera"]
    assert len(again.sensors[1].data.points) == 5 * 42
    assert {path.name for path in (tmp_path / "out").glob("*.png")} == {path.name for path in boards.glob("*.png")}


def test_a_scanner_and_its_camera_get_their_points_in_either_order(boards, tmp_path):
    assert main(["extract", str(boards), "--output", str(tmp_path / "out")]) == 0
    toml = tmp_path / "out" / "dataset.toml"
    head, stripe, camera = toml.read_text().split("[[sensors]]\n")
    toml.write_text("[[sensors]]\n".join([head, f"{camera}\n", stripe]))
    once = load(tmp_path / "out")
    assert [one.name for one in once.members] == ["stripe", "camera"]
    assert main(["extract", str(tmp_path / "out"), "--output", str(tmp_path / "again")]) == 0
    np.testing.assert_array_equal(load(tmp_path / "again").points.pixel, once.points.pixel)


@pytest.mark.parametrize(("kept", "file"), [("stripe", "points.csv"), ("camera", "corners.csv")])
def test_images_leave_the_points_of_a_tracker_alone(boards, kept, file, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["extract", str(boards), "--output", str(out)]) == 0
    toml = out / "dataset.toml"
    head, stripe, camera = toml.read_text().split("[[sensors]]\n")
    tracker = 'name = "tracker"\nkind = "point"\npoints = "tracker.csv"\n'
    toml.write_text("\n[[sensors]]\n".join([head, {"stripe": stripe, "camera": camera}[kept], tracker]))
    (out / "tracker.csv").write_text("pose,point,x_m,y_m,z_m\n" + "".join(f"p{i},A,1,{i},2\n" for i in range(5)))
    before = {name: (out / name).read_bytes() for name in (file, "tracker.csv")}
    assert main(["extract", str(out), "--force"]) == 1
    assert main(["extract", str(out), "--output", str(tmp_path / "again")]) == 1
    assert "only a stripe scanner and the camera that it shares have common images" in capsys.readouterr().err
    assert {name: (out / name).read_bytes() for name in before} == before


def test_points_that_another_file_holds_are_not_overwritten_unasked(boards, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["extract", str(boards), "--output", str(out)]) == 0
    (out / "points.csv").rename(out / "light.csv")
    (out / "dataset.toml").write_text((out / "dataset.toml").read_text().replace('"points.csv"', '"light.csv"'))
    (out / "light.csv").write_text("pose,point,u_px,v_px,x_m,y_m,z_m\np0,A,1,1,0,0,0\n")
    assert main(["extract", str(out), "--force"]) == 1
    assert "light.csv, but what is there is not its own earlier result" in capsys.readouterr().err


def test_a_board_whose_placement_is_not_said_to_be_unknown_is_asked_about(boards, tmp_path, capsys):
    folder = tmp_path / "placed"
    shutil.copytree(boards, folder)
    (folder / "dataset.toml").write_text((folder / "dataset.toml").read_text().replace("placed = false", ""))
    for recording, asked in ((folder, True), (boards, False)):
        assert main(["extract", str(recording), "--output", str(tmp_path / str(asked))]) == 0
        assert ("state placed = false" in capsys.readouterr().err) == asked


def test_detections_of_another_board_are_not_taken(boards, monkeypatch):
    seen, known = [], {}
    monkeypatch.setattr(recordings, "look", lambda shots, search, board: seen.append(board) or Look(None, ()))
    for columns in (7, 7, 5):
        with pytest.raises(ImageError, match="gave a point"):
            points_from_images(replace(load(boards), board=Board(columns, 6, SQUARE)), known=known)
    assert [board.columns for board in seen] == [7] * 5 + [5] * 5


def test_a_recording_without_repeats_has_none(boards, tmp_path):
    described(tmp_path, HEIGHT, BOARD)
    for image in boards.glob("a*.png"):
        (tmp_path / image.name).write_bytes(image.read_bytes())
    posed(tmp_path, ["image"], [[f"a{k}.png"] for k in range(5)])
    _, dataset = points_from_images(load(tmp_path))
    assert dataset.points.repeat is None


def test_nothing_is_copied_out_of_the_folder_or_the_output(tmp_path, capsys):
    folder, out = scan(tmp_path / "scan", poses=1, off=False), tmp_path / "deep" / "out"
    (tmp_path / "secret.png").write_bytes(b"secret")
    (folder / "poses.csv").unlink()
    posed(folder, ["image", "image_off"], [["a0.png", ""], ["", "../secret.png"]])
    assert main(["extract", str(folder), "--output", str(out)]) == 1
    assert "image_off" in capsys.readouterr().err
    assert not (tmp_path / "deep" / "secret.png").exists()


def test_an_output_that_is_the_recording_is_none(tmp_path):
    folder = scan(tmp_path / "scan", poses=1)
    before = (folder / "dataset.toml").read_bytes()
    assert main(["extract", str(folder), "--output", f"{folder}/../scan", "--force"]) == 0
    assert len(open_stripes(folder / "stripes.npy"))
    assert (folder / "dataset.toml").read_bytes() == before


def test_an_output_that_is_a_file_is_told_before_any_image_is_read(tmp_path, capsys):
    folder = scan(tmp_path / "scan", poses=1)
    for image in folder.glob("*.png"):
        image.unlink()
    (tmp_path / "file").write_text("mine")
    assert main(["extract", str(folder), "--output", str(tmp_path / "file")]) == 1
    assert str(tmp_path / "file") in capsys.readouterr().err


def test_no_image_is_copied_over_the_users_own(tmp_path, capsys):
    folder, out = scan(tmp_path / "scan", poses=1), tmp_path / "out"
    out.mkdir()
    (out / "a0.png").write_text("mine")
    assert main(["extract", str(folder), "--output", str(out), "--force"]) == 1
    assert "a0.png, but what is there is not its own" in capsys.readouterr().err
    assert [(file.name, file.read_text()) for file in out.iterdir()] == [("a0.png", "mine")]


@pytest.mark.parametrize("key", ["columns", "rows"])
def test_a_board_too_small_to_be_found_is_refused(key, tmp_path, capsys):
    described(tmp_path, HEIGHT, BOARD.replace(f"{key} = {'7' if key == 'columns' else '6'}", f"{key} = 2"))
    posed(tmp_path, ["image"], [[""]])
    assert main(["extract", str(tmp_path)]) == 1
    assert f"[board] {key}" in capsys.readouterr().err


@pytest.mark.parametrize("shape", [(1, 1), (2, 40), (7, 3), (11, 60), (19, 19)])
def test_images_smaller_than_any_board_show_none(shape):
    rng = np.random.default_rng(0)
    for image in (rng.integers(0, 256, shape), np.zeros(shape), np.full(shape, 255)):
        assert find_board(image.astype(np.uint8), columns=3, rows=3) is None
        for axis in ("u", "v"):
            assert len(trace(image.astype(np.uint8), axis)) >= 0


def test_of_a_damaged_image_a_sentence_is_printed_and_nothing_else(tmp_path):
    folder = scan(tmp_path / "scan", poses=1)
    (folder / "a0.png").write_bytes((folder / "a0.png").read_bytes()[:200])
    typed = [sys.executable, "-m", "robolaser", "extract", str(folder)]
    said = subprocess.run(typed, capture_output=True, text=True, check=False).stderr
    assert said.startswith("robolaser: ")
    assert said.count("\n") == 1
