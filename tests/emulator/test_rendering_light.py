from dataclasses import replace

import numpy as np
import pytest
from scenes import SHEET, above, eye, near, placed, spotless

from robolaser.arrays import Array
from robolaser.emulator.rendering import Ball, CameraModel, Cuboid, EmulatedScene, Floor, Photograph, photograph

FLOOR = EmulatedScene((Floor(),))
STEP = Cuboid(placed(near(0.005, 0.0, 0.0)), (0.05, 0.06, 0.02))
STEPPED = EmulatedScene((Floor(), STEP))
BALL = EmulatedScene((Floor(), Ball(near(0.0, 0.0, 0.018), 0.018)))
ENDS = 4  # lines at which the blur meets the image's border


def lines(picture: Photograph) -> Array:
    grey = picture.truth.grey
    return grey if picture.truth.view.eye.stripe_axis == "v" else grey.T


def centroids(picture: Photograph, at: Array, reach: int = 9) -> Array:
    """Of the light around one place on each line; NaN where there is no place."""
    out = np.full(len(at), np.nan)
    for line in np.flatnonzero(np.isfinite(at)):
        column = np.arange(int(at[line]) - reach, int(at[line]) + reach + 2)
        if column[0] >= 0 and column[-1] < lines(picture).shape[1]:
            light = lines(picture)[line, column]
            out[line] = light @ column / light.sum()
    return out


@pytest.mark.parametrize("axis", ["u", "v"])
@pytest.mark.parametrize("bent", [{}, {"roll": 0.05, "curvature": 0.02}], ids=["flat", "bent"])
def test_the_light_is_centred_on_the_true_stripe(axis: str, bent: dict[str, float]) -> None:
    picture = spotless(FLOOR, axis, sheet=replace(SHEET, **bent))
    true = picture.truth.stripe.at[:, 0]
    assert np.isfinite(true).all()
    off = (centroids(picture, true) - true)[ENDS:-ENDS]
    assert np.nanmax(np.abs(off)) < 0.01


def test_on_a_ball_it_leans_to_the_bright_side_by_its_breadth_squared() -> None:
    lean = []
    for width in (0.2e-3, 0.4e-3):
        picture = spotless(BALL, "v", 0, 0, 0, sheet=replace(SHEET, width_m=width))
        stripe = picture.truth.stripe
        on_ball = (stripe.solid == 1).any(axis=1) & (np.isfinite(stripe.at).sum(axis=1) == 1)
        assert on_ball.sum() > 60
        lean.append(np.nanmedian((centroids(picture, stripe.at[:, 0]) - stripe.at[:, 0])[on_ball]))
    assert abs(lean[1]) < 0.15
    assert lean[1] / lean[0] == pytest.approx(4.0, rel=0.25)


@pytest.mark.parametrize("scene", [FLOOR, STEPPED, BALL], ids=["floor", "step", "ball"])
def test_the_true_stripe_lies_on_the_sheet_and_projects_onto_its_pixels(scene: EmulatedScene) -> None:
    stripe, T = spotless(scene).truth.stripe, above(8, 5, 20)
    row, k = np.nonzero(np.isfinite(stripe.at))
    seen = (stripe.point[row, k] - T[:3, 3]) @ T[:3, :3]
    assert np.abs(SHEET.off(seen)).max() < 1e-7
    pixel = eye().pixels(seen)
    np.testing.assert_allclose(pixel, np.stack([stripe.at[row, k], row], axis=-1), atol=1e-4)


def test_a_step_hides_the_floor_behind_it_from_the_light() -> None:
    with_step, without = (spotless(scene, "v", 0, 0, 0).truth.stripe for scene in (STEPPED, FLOOR))
    top = (with_step.solid == 1).any(axis=1)
    floor = (with_step.solid == 0).any(axis=1)
    assert np.isfinite(without.at).all()
    assert top.sum() > 100
    assert floor.sum() > 100
    assert not (top & floor).any()
    jump = np.nanmedian(with_step.at[top]) - np.nanmedian(with_step.at[floor])
    assert abs(jump) > 20
    dark = lines(spotless(STEPPED, "v", 0, 0, 0))[top]
    where = np.rint(without.at[top, 0]).astype(int)
    assert dark[np.arange(top.sum()), where][ENDS:-ENDS].max() < 0.1


def test_light_that_falls_beside_a_step_leaves_a_gap_in_its_shadow() -> None:
    turned = EmulatedScene((Floor(), replace(STEP, T_base_block=placed(near(0.005, 0.0, 0.0), 0, 0, 40))))
    stripe = spotless(turned, "v", 0, 0, 0).truth.stripe
    assert np.isnan(stripe.at).all(axis=1).any()


def test_without_the_laser_there_is_no_stripe() -> None:
    on, off = (spotless(STEPPED, lit=lit, ambient=100.0) for lit in (True, False))
    assert np.isfinite(on.truth.stripe.at).any()
    assert np.isnan(off.truth.stripe.at).all()
    dark = spotless(STEPPED, lit=True, ambient=0.0).truth.grey
    np.testing.assert_allclose(on.truth.grey - off.truth.grey, dark, atol=1e-9)


def test_twice_the_exposure_is_twice_the_grey() -> None:
    once, twice = (spotless(BALL, ambient=30.0, exposure=exposure) for exposure in (0.4, 0.8))
    np.testing.assert_allclose(twice.truth.grey, 2 * once.truth.grey)
    assert np.abs(twice.image.astype(float) - 2.0 * once.image).max() <= 1.5


def test_too_much_light_ends_at_255() -> None:
    picture = spotless(FLOOR, sheet=replace(SHEET, power=3000.0))
    assert picture.image.max() == 255
    assert picture.truth.grey.max() > 600
    np.testing.assert_array_equal(picture.image, np.clip(np.rint(picture.truth.grey), 0, 255))
    assert (picture.image[240] == 255).sum() >= 4


def test_speckle_has_the_contrast_asked_for() -> None:
    settings = {"sheet": replace(SHEET, power=300.0)}
    smooth = spotless(FLOOR, **settings)
    rough = spotless(FLOOR, speckle=0.2, **settings)
    bright = smooth.truth.grey > 40
    ratio = rough.image[bright] / smooth.truth.grey[bright]
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)
    assert ratio.std() == pytest.approx(0.2, rel=0.1)


def test_noise_has_the_strength_asked_for() -> None:
    picture = spotless(FLOOR, lit=False, ambient=250.0, noise_grey=3.0)
    noise = (picture.image - picture.truth.grey)[np.abs(picture.truth.grey - 128) < 12]
    assert len(noise) > 1000
    assert noise.std() == pytest.approx(3.0, rel=0.05)


def test_brighter_is_noisier() -> None:
    dim, bright = (spotless(FLOOR, lit=False, ambient=ambient, noise_grey=3.0) for ambient in (60.0, 400.0))
    dim_noise, bright_noise = ((one.image - one.truth.grey).std() for one in (dim, bright))
    assert bright_noise > 1.15 * dim_noise


def test_a_shiny_floor_shows_the_mirror_image_of_the_stripe() -> None:
    tall = Cuboid(placed(near(0.0, -0.03, 0.0)), (0.06, 0.03, 0.03))
    turned = (40, 0, 0)
    scene = EmulatedScene((Floor(shine=0.4), tall))
    shiny, matt = (spotless(scene, "v", *turned, reflections=reflections) for reflections in (True, False))
    stripe = matt.truth.stripe
    side = (stripe.solid == 1) & (stripe.point[..., 2] < 0.03 - 1e-6)
    row, k = np.nonzero(side)
    assert len(row) > 50
    T = above(*turned)
    beneath = stripe.point[row, k] * [1, 1, -1]
    pixel = eye().pixels((beneath - T[:3, 3]) @ T[:3, :3])
    second = shiny.truth.grey - matt.truth.grey
    assert second.max() > 2.0
    assert second.max() < 0.5 * matt.truth.grey.max()
    picture = replace(shiny, truth=replace(shiny.truth, grey=second))
    at = np.full(480, np.nan)
    inner = np.unique(np.rint(pixel[:, 1]).astype(int))[ENDS:-ENDS]
    at[inner] = np.interp(inner, *pixel[np.argsort(pixel[:, 1])].T[::-1])
    off = (centroids(picture, at) - at)[inner]
    assert np.nanmedian(np.abs(off)) < 0.05


def test_a_shiny_side_throws_a_second_line_onto_the_floor() -> None:
    tall = Cuboid(placed(near(0.0, -0.03, 0.0)), (0.06, 0.03, 0.03), shine=0.4)
    shiny, matt = (
        spotless(EmulatedScene((Floor(), tall)), "v", 40, 0, 0, reflections=reflections, blur_px=0.0)
        for reflections in (True, False)
    )
    second = shiny.truth.grey - matt.truth.grey
    on_floor = (second > 1.0) & (shiny.truth.solid == 0)
    assert on_floor.sum() > 300
    assert second.max() < 0.5 * matt.truth.grey.max()
    side = -0.045
    T = above(40, 0, 0)
    behind = shiny.truth.point[on_floor] * [1, -1, 1] + [0, 2 * side, 0]
    off = SHEET.off((behind - T[:3, 3]) @ T[:3, :3])
    assert abs(np.average(off, weights=second[on_floor])) < 0.1 * SHEET.width_m
    assert np.sqrt(np.average(off**2, weights=second[on_floor])) == pytest.approx(SHEET.width_m, rel=0.1)


def test_the_same_seed_gives_the_same_picture() -> None:
    one, other = (
        photograph(BALL, eye(), SHEET, above(8, 5, 20), lit=True, rng=np.random.default_rng(4)) for _ in range(2)
    )
    np.testing.assert_array_equal(one.image, other.image)


def test_small_eyes_see_the_same_scene_coarsely() -> None:
    fine = spotless(STEPPED, lit=False, ambient=200.0).truth.grey
    truth = eye().truth
    half = {
        "s_u": 2 * truth["s_u"],
        "s_v": 2 * truth["s_v"],
        "u_0": truth["u_0"] / 2 - 0.25,
        "v_0": truth["v_0"] / 2 - 0.25,
    }
    small = CameraModel({**truth, **half}, width_px=320, height_px=240, lens_error=eye().lens_error)
    coarse = photograph(
        STEPPED, small, SHEET, above(8, 5, 20), lit=False, rng=np.random.default_rng(0), noise_grey=0.0, ambient=200.0
    )
    pooled = fine.reshape(240, 2, 320, 2).mean(axis=(1, 3))
    assert np.median(np.abs(pooled - coarse.truth.grey)) < 0.5
