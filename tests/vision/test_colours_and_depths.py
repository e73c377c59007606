"""A laser in colour, and in more bits than eight."""

import cv2
import numpy as np
import pytest
from PIL import Image

from robolaser.data.image_list import PoseImages
from robolaser.data.importers.image_folder import image_files
from robolaser.vision.images import CameraImages, read_image
from robolaser.vision.stripe_trace import CHANNELS, StripeSearch, find_channel

SIZE = (320, 240)
RNG = np.random.default_rng(5)
ACROSS = 150.0 + 0.1 * np.arange(SIZE[1])
"""Where the stripe's centre is in each row [px]."""
TEXTURE = cv2.GaussianBlur(RNG.uniform(0.2, 1.0, SIZE[::-1]), (0, 0), 1.5)
"""Of what it falls on: in grey as strong as the stripe."""


def stripe(peak: float) -> np.ndarray:
    return peak * np.exp(-0.5 * ((np.arange(SIZE[0]) - ACROSS[:, None]) / 2.0) ** 2)


def picture(colour: tuple[float, float, float], peak: float, bits: int = 8, noise: float = 1.0) -> np.ndarray:
    """A textured surface in white light with a stripe of a colour (blue, green, red), as its file has it."""
    light = (110 * TEXTURE[..., None] * np.ones(3)) + stripe(peak)[..., None] * np.asarray(colour)
    light += noise * np.random.default_rng(1).standard_normal(light.shape)
    top = (1 << bits) - 1
    return np.clip(np.rint(light * top / 255), 0, top).astype(np.uint8 if bits == 8 else np.uint16)


def shots(tmp_path, *images: np.ndarray, off: np.ndarray | None = None) -> PoseImages:
    names = [tmp_path / f"{i}.png" for i in range(len(images) + (off is not None))]
    for name, image in zip(names, (*images, *(() if off is None else (off,))), strict=True):
        cv2.imwrite(str(name), image)
    return PoseImages(0, "p", tuple(names[: len(images)]), None if off is None else names[-1])


def missed(taken: PoseImages, channel: str) -> tuple[int, float]:
    """How many rows show the stripe, and the error of its centre [px]."""
    (found,) = StripeSearch(CameraImages.of(taken.files, SIZE), "v", channel).traces(taken)
    off = found["u"] - ACROSS[np.rint(found["v"]).astype(int)]
    near = np.abs(off) < 3
    return int(near.sum()), float(np.sqrt(np.mean(off[near] ** 2))) if near.any() else np.inf


@pytest.mark.parametrize(
    ("colour", "expected", "dark", "bits"),
    [
        ((0.02, 0.05, 1), "red", False, 8),
        ((0.02, 0.05, 1), "red", True, 8),
        ((0.02, 0.05, 1), "red", False, 12),
        ((0.05, 1, 0.1), "green", False, 8),
        ((1, 0.1, 0), "blue", False, 8),
        ((1, 0.1, 0), "blue", True, 8),
    ],
)
def test_the_channel_is_found_in_which_a_coloured_laser_stands_out(colour, expected, dark, bits, tmp_path) -> None:
    """On texture as strong as itself; with an image without the laser, and by the stripe alone."""
    off = picture(colour, 0.0) if dark else None
    taken = shots(tmp_path, picture(colour, 45.0, bits), off=off)
    channel = find_channel([taken], CameraImages(SIZE, bits), "v")
    assert channel.startswith(expected), channel
    rows, error = missed(taken, channel)
    in_grey, _ = missed(taken, "grey")
    assert rows > 0.8 * SIZE[1]
    assert rows > in_grey or dark
    assert error < 0.25


def test_grey_images_stay_grey_whatever_their_file_holds(tmp_path) -> None:
    grey = picture((1, 1, 1), 120.0)[..., 1]
    for image in (grey, cv2.merge([grey, grey, grey])):
        assert find_channel([shots(tmp_path, image)], CameraImages(SIZE), "v") == "grey"


@pytest.mark.parametrize("bits", [12, 16])
def test_deep_images_keep_what_eight_bits_lose(bits, tmp_path) -> None:
    """A stripe of twelve eight-bit grey in a quiet camera, half of it below one eight-bit step from row to row."""
    deep = picture((1, 1, 1), 12.0, bits, noise=0.02)
    off = picture((1, 1, 1), 0.0, bits, noise=0.02)
    _, error = missed(shots(tmp_path, deep[..., 1], off=off[..., 1]), "grey")
    shallow, dark = (np.asarray(one >> (bits - 8), np.uint8)[..., 1] for one in (deep, off))
    _, coarse = missed(shots(tmp_path, shallow, off=dark), "grey")
    assert error < 0.3 * coarse


def test_the_depth_is_that_of_all_images_of_the_camera(tmp_path) -> None:
    """A dark image of twelve bits, alone at its pose, is not one of ten."""
    (tmp_path / "dark").mkdir()
    lit, dark = picture((1, 1, 1), 150.0, 12)[..., 1], np.minimum(picture((1, 1, 1), 0.0, 12)[..., 1], 1000)
    bright, alone = shots(tmp_path, lit), shots(tmp_path / "dark", dark)
    camera = CameraImages.of((*alone.files, *bright.files), SIZE)
    assert camera.depth == 12
    ((grey, light),) = StripeSearch(camera, "v").lights(alone)
    np.testing.assert_allclose(light, dark / 16.0)
    np.testing.assert_array_equal(grey, dark >> 4)


def test_channels_weigh_blue_green_and_red_as_opencv_orders_them(tmp_path) -> None:
    image = np.zeros((*SIZE[::-1], 3), np.uint8)
    image[...] = (10, 40, 200)
    taken = shots(tmp_path, image)
    seen = {name: float(next(StripeSearch(CameraImages(SIZE), "v", name).lights(taken))[1][0, 0]) for name in CHANNELS}
    assert (seen["blue"], seen["green"], seen["red"]) == (10, 40, 200)
    assert seen["red-excess"] == pytest.approx(200 - 25 + 16)
    assert seen["blue-excess"] == 0


@pytest.mark.parametrize("colours", [cv2.IMREAD_GRAYSCALE, cv2.IMREAD_COLOR, cv2.IMREAD_ANYCOLOR])
def test_an_image_keeps_the_frame_of_its_sensor_however_the_camera_was_held(tmp_path, colours):
    held, scene = Image.Exif(), np.random.default_rng(0).integers(0, 255, (240, 320, 3)).astype(np.uint8)
    held[0x0112] = 6  # EXIF's orientation: a quarter turn, which viewers undo
    for name, exif in (("plain.jpg", Image.Exif()), ("held.jpg", held)):
        Image.fromarray(scene).save(tmp_path / name, exif=exif)
    plain, turned = (read_image(tmp_path / name, SIZE, colours) for name in ("plain.jpg", "held.jpg"))
    np.testing.assert_array_equal(turned, plain)
    assert image_files([tmp_path / "held.jpg"])[2] == SIZE


def test_transparency_is_no_grey_of_the_camera(tmp_path):
    deep = np.full((240, 320, 4), 4000, np.uint16)
    deep[..., 3] = 65535
    cv2.imwrite(str(tmp_path / "0.png"), deep)
    assert CameraImages.of([tmp_path / "0.png"], SIZE).depth == 12
