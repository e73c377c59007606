"""One stripe through an image of anything: which light is it, and which is not."""

import numpy as np
import pytest
from drawn import HEIGHT, ROW, STRAIGHT, WAVY, WIDTH, exposed, profile, speckled

from robolaser.data.stripe_file import STRIPE
from robolaser.vision.images import laser_alone
from robolaser.vision.stripe_trace import trace


def missed(stripes, course):
    """Distance of each middle from where the light is, (n,) [px]."""
    return stripes["u"] - course[np.rint(stripes["v"]).astype(int)]


def test_a_stripe_is_traced_in_every_line():
    stripes = trace(exposed(20 + profile(WAVY, 2, 150), 2, 1), "v")
    assert stripes.dtype == STRIPE
    assert len(stripes) >= 0.95 * HEIGHT
    assert np.all(np.diff(stripes["v"]) > 0)
    assert np.abs(missed(stripes, WAVY)).max() < 0.15
    assert np.abs(stripes["intensity"] - 150).max() < 12


def test_a_turned_image_gives_the_same_stripe():
    image = exposed(20 + profile(WAVY, 2, 150), 2, 1)
    upright, lying = trace(image, "v"), trace(np.ascontiguousarray(image.T), "u")
    np.testing.assert_allclose(upright["u"], lying["v"], atol=1e-4)
    np.testing.assert_allclose(upright["v"], lying["u"], atol=1e-4)


def test_images_without_a_stripe_have_none():
    for seed in range(5):
        assert len(trace(exposed(np.full((HEIGHT, WIDTH), 60.0), 6, seed), "v")) == 0
    for grey in (0, 40, 255):
        assert len(trace(np.full((HEIGHT, WIDTH), grey, np.uint8), "v")) == 0


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("apart", [25, 60])
def test_a_mirror_image_beside_the_stripe_is_not_taken(share, apart):
    light = profile(STRAIGHT, 2, 150) + profile(STRAIGHT + apart, 2, 150 * share)
    stripes = trace(exposed(20 + light, 2, 2), "v")
    assert len(stripes) >= 0.95 * HEIGHT
    assert np.abs(missed(stripes, STRAIGHT)).max() < 0.3


def test_a_mirror_image_does_not_fill_the_gap_of_the_stripe():
    direct, mirrored = profile(STRAIGHT, 2, 150), profile(STRAIGHT + 40, 2, 70)
    direct[120:180] = 0
    stripes = trace(exposed(20 + direct + mirrored, 2, 3), "v")
    assert np.abs(missed(stripes, STRAIGHT)).max() < 0.3
    assert len(stripes) >= HEIGHT - 60 - 4


def test_a_glint_brighter_than_the_stripe_is_not_taken():
    light = profile(STRAIGHT, 2, 120)
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    for v, u in ((50, 200), (140, 420), (141, 350), (260, 100)):
        light += 600 * np.exp(-0.5 * (((row - v) / 2.5) ** 2 + ((column - u) / 3.0) ** 2))
    stripes = trace(exposed(20 + light, 2, 4), "v")
    assert np.abs(missed(stripes, STRAIGHT)).max() < 0.3
    assert len(stripes) > 0.85 * HEIGHT


def test_a_step_in_depth_is_kept_and_its_edge_left_out():
    course = STRAIGHT + np.where((ROW >= 100) & (ROW < 180), 45, 0)
    stripes = trace(exposed(20 + profile(course, 2, 150), 2, 5), "v")
    assert np.abs(missed(stripes, course)).max() < 0.2
    assert HEIGHT - 4 <= len(stripes) < HEIGHT


def test_small_things_are_kept():
    course = STRAIGHT + np.where((ROW >= 100) & (ROW < 112), -70, 0)
    line = np.rint(trace(exposed(20 + profile(course, 2, 150), 2, 6), "v")["v"])
    assert np.sum((line >= 100) & (line < 112)) >= 10


def test_a_gap_has_no_middles():
    light = profile(STRAIGHT, 2, 150)
    light[90:170] = 0
    stripes = trace(exposed(30 + light, 3, 7), "v")
    line = np.rint(stripes["v"])
    assert not np.any((line >= 90) & (line < 170))
    assert len(stripes) >= HEIGHT - 80 - 2


def test_a_broad_lamp_is_not_taken():
    light = profile(STRAIGHT, 2, 120)
    light[:, 500:590] += 200
    stripes = trace(exposed(20 + light, 2, 8), "v")
    assert np.abs(missed(stripes, STRAIGHT)).max() < 0.3
    assert len(stripes) >= 0.98 * HEIGHT


@pytest.mark.parametrize("contrast", [0.0, 0.1, 0.2, 0.3])
def test_deviations_hold_whether_noise_or_speckle_makes_them(contrast):
    stripes = trace(exposed(20 + speckled(profile(STRAIGHT, 2.5, 120), contrast, 9), 2, 9), "v")
    assert 0.7 < 1.4826 * np.median(np.abs(missed(stripes, STRAIGHT) / stripes["std"])) < 1.4


def test_without_the_laser_lamps_edges_and_textures_vanish():
    room = 30 + 40 * np.random.default_rng(10).random((HEIGHT, 1)) + 30 * (np.arange(WIDTH) // 9 % 2)
    room = room + profile(STRAIGHT + 90, 2, 130)
    lit = exposed(room + profile(STRAIGHT, 2, 80), 2, 11)
    stripes = trace(laser_alone(lit, exposed(room, 2, 12)), "v")
    assert len(stripes) >= 0.98 * HEIGHT
    assert abs(missed(stripes, STRAIGHT).mean()) < 0.01
    assert np.abs(missed(stripes, STRAIGHT)).max() < 0.3
    assert np.sum(np.abs(missed(trace(lit, "v"), STRAIGHT)) < 1) < 0.5 * HEIGHT


def test_a_difference_keeps_its_noise_and_so_its_deviations():
    light = profile(STRAIGHT, 2, 120)
    stripes = trace(laser_alone(exposed(3 + light, 2, 13), exposed(np.full_like(light, 3.0), 2, 14)), "v")
    assert 0.7 < missed(stripes, STRAIGHT).std() / np.median(stripes["std"]) < 1.4


def test_a_saturated_stripe_stays_saturated_in_the_difference():
    light = profile(STRAIGHT, 3, 800)
    ambient = np.linspace(5, 90, WIDTH) * np.ones((HEIGHT, 1))
    stripes = trace(laser_alone(exposed(ambient + light, 2, 15), exposed(ambient, 2, 16)), "v")
    assert abs(missed(stripes, STRAIGHT).mean()) < 0.05
    assert np.sqrt(np.mean(missed(stripes, STRAIGHT) ** 2)) < 0.1


def test_a_stripe_is_found_down_to_the_faintest_that_lines_join():
    for height, share in ((40, 0.98), (20, 0.9)):
        stripes = trace(exposed(20 + profile(STRAIGHT, 2, height), 2, 17), "v")
        assert len(stripes) >= share * HEIGHT
        assert np.abs(missed(stripes, STRAIGHT)).max() < 1.0
