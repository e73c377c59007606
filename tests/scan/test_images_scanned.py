"""Images become a cloud without a word between: repeats, dark images and images of nothing among them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scanned import calibrated, dataset, written

from robolaser.cli import main
from robolaser.data.dataset import Points
from robolaser.data.loading import load
from robolaser.data.writing import save
from robolaser.errors import ScanError
from robolaser.scan import prepare, read_calibration
from robolaser.scan.ply import map_ply

POSES = 6
BLANK = 2  # row whose image shows nothing
THROUGH = 4  # row without an image


def drawn(data, seed, *, lit=True):
    """A straight stripe where this scanner's usually lies, with noise."""
    rng = np.random.default_rng(seed)
    width, height = data.image_px
    across = np.median(data.points.pixel[:, 1])
    light = 150 * np.exp(-0.5 * ((np.arange(height) - across) / 2) ** 2) if lit else np.zeros(height)
    return np.clip(20 + light[:, None] + rng.normal(0, 1.5, (height, width)), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def data():
    return dataset(poses=POSES)


@pytest.fixture(scope="module")
def scanner(data, tmp_path_factory):
    return written(calibrated(data), tmp_path_factory.mktemp("calibration"))


@pytest.fixture
def folder(data, tmp_path):
    """Each pose shot twice; one image shows nothing, one pose has none."""
    folder = tmp_path / "recording"
    folder.mkdir()
    columns = {"image": "a", "image_2": "b"}
    named = {column: [f"{kind}{row}.png" for row in range(POSES)] for column, kind in columns.items()}
    for column, kind in columns.items():
        named[column][THROUGH] = ""
        for row, name in enumerate(named[column]):
            if name:
                cv2.imwrite(str(folder / name), drawn(data, 10 * row + ord(kind), lit=row != BLANK))
    poses = replace(data.poses, image=tuple(named["image"]), extra={"image_2": tuple(named["image_2"])})
    save(replace(data, poses=poses, points=Points(np.empty(0, np.int64), ())), folder)
    return folder


def cloud_of(scanner, folder):
    scan = prepare(read_calibration(scanner), load(folder))
    return scan, np.concatenate(list(scan.cloud.pieces()))


def test_an_image_of_nothing_gives_no_points_and_stops_nobody(scanner, folder):
    scan, cloud = cloud_of(scanner, folder)
    assert scan.cloud.what == "images"
    assert set(cloud["pose"]) == set(range(POSES)) - {BLANK, THROUGH}


def test_an_image_of_nothing_stops_no_scanner_with_effects_either(data, folder, tmp_path):
    found = calibrated(data, ["laser_curvature", "radial_distortion"], {"laser_curvature.laser.curvature": 0.1})
    _, cloud = cloud_of(written(found, tmp_path / "bent"), folder)
    assert set(cloud["pose"]) == set(range(POSES)) - {BLANK, THROUGH}


def test_a_scan_of_the_images_is_a_scan_of_what_is_extracted_from_them(scanner, folder):
    _, direct = cloud_of(scanner, folder)
    assert main(["extract", str(folder)]) == 0
    scan, extracted = cloud_of(scanner, folder)
    assert scan.cloud.what == "stripes.npy"
    np.testing.assert_array_equal(direct, extracted)
    width = load(folder).image_px[0]
    assert len(direct) > 0.95 * 2 * (POSES - 2) * width


def test_only_poses_that_gave_points_are_counted(scanner, folder, tmp_path, capsys):
    assert main(["scan", str(scanner), str(folder), "--output", str(tmp_path / "c.ply")]) == 0
    assert f"of {POSES - 2} poses" in capsys.readouterr().out


@pytest.mark.parametrize("extract", [False, True])
def test_images_of_nothing_alone_are_no_scan(extract, data, scanner, folder):
    for image in folder.glob("*.png"):
        if extract and image.name == "a0.png":
            continue
        cv2.imwrite(str(image), drawn(data, 0, lit=False))
    if extract:
        assert main(["extract", str(folder)]) == 0
        np.save(folder / "stripes.npy", np.load(folder / "stripes.npy")[:0])
    with pytest.raises(ScanError, match=r"stripes\.npy" if extract else "images"):
        cloud_of(scanner, folder)


def test_the_size_of_a_doubt_is_that_in_the_poses_with_images(data, folder, tmp_path):
    calibration = calibrated(data, ["backlash:joint_2"], {"backlash.joint_2.lost_motion": 0.01})
    q = data.poses.q.copy()
    q[:, 1] = np.linspace(-0.5, 0.5, POSES)
    said = load(folder)
    image = ("", *said.poses.image[1:])
    unlike = replace(said, poses=replace(said.poses, q=q, time_s=np.arange(1.0, POSES + 1), image=image, extra={}))
    scan = prepare(read_calibration(written(calibration, tmp_path / "play")), unlike)
    assert "0 mm" not in " ".join(scan.warnings)
    assert not any("backlash" in warning for warning in scan.warnings)  # it had turned round before the first image


def test_nominal_scans_with_the_scanner_as_it_was_drawn(data, folder, tmp_path, capsys):
    moved = written(calibrated(data, ["joint_offset:joint_2"], {"joint_offset.joint_2.offset": 0.02}), tmp_path / "m")
    for name, options in (("found", []), ("drawn", ["--nominal"])):
        assert main(["scan", str(moved), str(folder), "--output", str(tmp_path / f"{name}.ply"), *options]) == 0
        assert ("by the nominal model" in capsys.readouterr().out) is bool(options)
    plain = written(calibrated(data), tmp_path / "plain")
    assert main(["scan", str(plain), str(folder), "--output", str(tmp_path / "plain.ply")]) == 0
    found, drawn_, plainly = (map_ply(tmp_path / f"{name}.ply") for name in ("found", "drawn", "plain"))
    np.testing.assert_array_equal(drawn_["x"], plainly["x"])
    assert np.abs(found["z"] - drawn_["z"]).max() > 1e-3
