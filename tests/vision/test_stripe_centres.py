"""Where the middle of a stripe is found, against where it was drawn."""

import numpy as np
import pytest

from robolaser.vision.centres import strongest
from robolaser.vision.stripe import stripe_centres

HEIGHT, WIDTH = 300, 640
ROW = np.arange(HEIGHT)
COURSE = 320 + 0.13 * ROW + 4 * np.sin(ROW / 60)


def profile(middle, breadth, height):
    """A Gaussian stripe as the pixels' areas collect it, before it saturates."""
    at = (np.arange(8 * WIDTH) + 0.5) / 8 - 0.5
    fine = height * np.exp(-0.5 * ((at - middle[:, None]) / breadth) ** 2)
    return fine.reshape(len(middle), WIDTH, 8).mean(axis=-1)


def exposed(light, noise=0.0, seed=0):
    light = light + noise * np.random.default_rng(seed).standard_normal(light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def off(image, course=COURSE):
    found = strongest(stripe_centres(image, "v"))
    return found, found.pixel[:, 0] - course[found.line]


@pytest.mark.parametrize("breadth", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("height", [60, 200])
def test_an_unsaturated_stripe_is_found_without_bias(breadth, height):
    found, error = off(exposed(20 + profile(COURSE, breadth, height), noise=1.0))
    assert len(found) == HEIGHT
    assert abs(error.mean()) < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.sqrt(breadth) * 100 / height


@pytest.mark.parametrize("breadth", [2.0, 5.0, 8.0])
@pytest.mark.parametrize("height", [500, 3000])
def test_a_saturated_stripe_is_found_without_bias(breadth, height):
    found, error = off(exposed(20 + profile(COURSE, breadth, height), noise=1.0))
    assert len(found) == HEIGHT
    assert abs(error.mean()) < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.08


def test_lines_without_light_have_no_middle():
    light = profile(COURSE, 3, 200)
    light[100:150] = 0
    found, error = off(exposed(20 + light, noise=1.0))
    assert not set(found.line) & set(range(100, 150))
    assert len(found) == HEIGHT - 50
    assert np.abs(error).max() < 0.3


def test_ambient_light_that_rises_across_the_image_moves_no_middle():
    ambient = np.linspace(10, 90, WIDTH)
    _, error = off(exposed(ambient + profile(COURSE, 3, 120), noise=1.0))
    assert abs(error.mean()) < 0.05


def test_a_second_line_is_offered_beside_the_first():
    light = profile(COURSE, 3, 150) + profile(COURSE + 60, 3, 200)
    found = stripe_centres(exposed(20 + light), "v")
    error = np.abs(found.pixel[:, :1] - np.stack([COURSE, COURSE + 60], axis=-1)[found.line])
    assert np.all(error.min(axis=1) < 0.05)
    assert np.all(np.bincount(found.line) == 2)


def test_a_broad_lamp_beside_a_faint_stripe_does_not_hide_it():
    light = profile(COURSE, 2, 70)
    light[:, 500:620] += 235
    found = stripe_centres(exposed(10 + light), "v")
    nearest = np.full(HEIGHT, np.inf)
    np.minimum.at(nearest, found.line, np.abs(found.pixel[:, 0] - COURSE[found.line]))
    assert np.all(nearest < 0.05)


def test_a_stripe_cut_by_the_border_has_no_middle():
    course = np.linspace(WIDTH - 30, WIDTH + 5, HEIGHT)
    found, error = off(exposed(20 + profile(course, 5, 800)), course)
    assert np.abs(error).max() < 0.1
    assert course[found.line].max() < WIDTH - 5


@pytest.mark.parametrize("grey", [0, 40, 255])
def test_an_even_image_shows_no_stripe(grey):
    assert len(stripe_centres(np.full((HEIGHT, WIDTH), grey, np.uint8), "v")) == 0


def test_a_turned_image_shows_the_same_stripe():
    image = exposed(20 + profile(COURSE, 3, 200), noise=1.0)
    upright, lying = stripe_centres(image, "v"), stripe_centres(np.ascontiguousarray(image.T), "u")
    np.testing.assert_array_equal(upright.line, lying.line)
    np.testing.assert_allclose(upright.pixel, lying.pixel[:, ::-1], atol=1e-12)


def test_an_edge_beside_the_stripe_makes_it_lopsided():
    paper = np.where(np.arange(WIDTH) > COURSE[:, None] + 2, 0.2, 1.0)
    even, _ = off(exposed(paper * 0 + 20 + profile(COURSE, 4, 180)))
    bitten, _ = off(exposed(paper * (20 + profile(COURSE, 4, 180))))
    assert np.median(np.abs(bitten.lopsided)) > 5 * np.median(np.abs(even.lopsided))
