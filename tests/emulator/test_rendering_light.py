from dataclasses import replace

import numpy as np
import pytest
from scenes import above, grey, heading, light, near, photograph, scene
from true_stripe import TrueStripe, true_stripe

from robolaser.arrays import Array
from robolaser.emulator.world.scene import Projector, RenderedScene
from robolaser.emulator.world.solids import Cuboid, Floor, Sphere

STEP = Cuboid(near(0.005, 0.0, 0.0), (0.05, 0.06, 0.02))
FLOOR, STEPPED = (Floor(),), (Floor(), STEP)
BALL = (Floor(), Sphere(near(0.0, 0.0, 0.018), 0.018))
T, STRAIGHT_DOWN = above(), above(0, 0, 0)
ENDS = 4  # lines at which the blur meets the image's border


def centroids(scene: RenderedScene, T_base_camera: Array, at: Array, reach: int = 9) -> Array:
    """Of the light around one place on each line; NaN where there is no place."""
    image = grey(scene, T_base_camera)
    image = image if scene.eye.optics.stripe_axis == "v" else image.T
    out = np.full(len(at), np.nan)
    for line in np.flatnonzero(np.isfinite(at)):
        column = np.arange(int(at[line]) - reach, int(at[line]) + reach + 2)
        if column[0] >= 0 and column[-1] < image.shape[1]:
            out[line] = image[line, column] @ column / image[line, column].sum()
    return out


@pytest.mark.parametrize("axis", ["u", "v"])
@pytest.mark.parametrize("bent", [light(), light(roll=0.05, cone=0.02)], ids=["flat", "bent"])
def test_the_light_is_centred_on_the_true_stripe(axis: str, bent: object) -> None:
    plain = replace(scene(*FLOOR, stripe_axis=axis), light=bent)
    true = true_stripe(plain, T).at[:, 0]
    assert np.isfinite(true).all()
    assert np.nanmax(np.abs((centroids(plain, T, true) - true)[ENDS:-ENDS])) < 0.01


def test_on_a_ball_it_leans_to_the_bright_side_by_its_breadth_squared() -> None:
    lean = []
    for width in (0.2e-3, 0.4e-3):
        ball = scene(*BALL, projector=Projector(width_m=width, speckle=0.0))
        stripe = true_stripe(ball, STRAIGHT_DOWN)
        on_ball = (stripe.solid == 1).any(axis=1) & (np.isfinite(stripe.at).sum(axis=1) == 1)
        assert on_ball.sum() > 60
        lean.append(np.nanmedian((centroids(ball, STRAIGHT_DOWN, stripe.at[:, 0]) - stripe.at[:, 0])[on_ball]))
    assert abs(lean[1]) < 0.15
    assert lean[1] / lean[0] == pytest.approx(4.0, rel=0.25)


def test_a_step_hides_the_floor_behind_it_from_the_light() -> None:
    def stripe(*solids: Cuboid | Floor) -> TrueStripe:
        return true_stripe(scene(*solids), STRAIGHT_DOWN)

    with_step, without = stripe(*STEPPED), stripe(*FLOOR)
    top = (with_step.solid == 1).any(axis=1)
    floor = (with_step.solid == 0).any(axis=1)
    assert np.isfinite(without.at).all()
    assert top.sum() > 100
    assert floor.sum() > 100
    assert not (top & floor).any()
    jump = np.nanmedian(with_step.at[top]) - np.nanmedian(with_step.at[floor])
    assert abs(jump) > 20
    dark = grey(scene(*STEPPED), STRAIGHT_DOWN)[top]
    where = np.rint(without.at[top, 0]).astype(int)
    assert dark[np.arange(top.sum()), where][ENDS:-ENDS].max() < 0.1


def test_light_that_falls_beside_a_step_leaves_a_gap_in_its_shadow() -> None:
    stripe = true_stripe(scene(Floor(), replace(STEP, quat=heading(40))), STRAIGHT_DOWN)
    assert np.isnan(stripe.at).all(axis=1).any()


def test_without_the_laser_there_is_only_the_light_of_the_room() -> None:
    stepped = scene(*STEPPED, ambient_grey=100.0)
    alone = grey(scene(*STEPPED), T)
    assert alone.max() > 50
    np.testing.assert_allclose(grey(stepped, T) - grey(stepped, T, lit=False), alone, atol=1e-9)


def test_too_much_light_ends_at_255() -> None:
    bright = scene(*FLOOR, projector=Projector(power_grey=3000.0, speckle=0.0))
    image, light = photograph(bright, T), grey(bright, T)
    assert image.max() == 255
    assert light.max() > 600
    np.testing.assert_array_equal(image, np.clip(np.rint(light), 0, 255))
    assert (image[240] == 255).sum() >= 4


def test_speckle_has_the_contrast_asked_for() -> None:
    rough = scene(*FLOOR, projector=Projector(power_grey=300.0, speckle=0.2))
    light = grey(rough, T)
    bright = light > 40
    ratio = photograph(rough, T)[bright] / light[bright]
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)
    assert ratio.std() == pytest.approx(0.2, rel=0.1)


def test_noise_has_the_strength_asked_for() -> None:
    noisy = scene(*FLOOR, ambient_grey=290.0, noise_grey=3.0)
    light = grey(noisy, T, lit=False)
    noise = (photograph(noisy, T, lit=False) - light)[np.abs(light - 128) < 12]
    assert len(noise) > 1000
    assert noise.std() == pytest.approx(3.0, rel=0.05)


def test_brighter_is_noisier() -> None:
    noise = []
    for ambient in (60.0, 400.0):
        noisy = scene(*FLOOR, ambient_grey=ambient, noise_grey=3.0)
        noise.append((photograph(noisy, T, lit=False) - grey(noisy, T, lit=False)).std())
    assert noise[1] > 1.15 * noise[0]


def test_the_same_seed_gives_the_same_picture() -> None:
    ball = scene(*BALL, projector=Projector(), ambient_grey=60.0, noise_grey=2.0)
    one, other = (photograph(ball, T, seed=4) for _ in range(2))
    np.testing.assert_array_equal(one, other)
