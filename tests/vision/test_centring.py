"""What the middle of a stripe promises, whatever noise, light, course and neighbours; and as a renderer draws it."""

from dataclasses import dataclass

import numpy as np
import pytest
from drawn import HEIGHT, STRAIGHT, WAVY, WIDTH, exposed, profile
from scipy.spatial.transform import Rotation
from true_stripe import TrueStripe, true_stripe

from robolaser.arrays import Image
from robolaser.emulator.world.scene import CameraModel, Projector, RenderedScene
from robolaser.emulator.world.solids import Cuboid, Floor, Sphere
from robolaser.trials.synthetic.scanner import Light, ScannerOptics
from robolaser.vision.stripe_detection import find_line_centres
from robolaser.vision.stripe_trace import trace

NOISE = 2.0
MOST_TIMES_BOUND = 1.15


def bound(breadth, height, noise=NOISE):
    """Cramér-Rao: no unbiased middle of one line scatters less."""
    return np.hypot(noise, 12**-0.5) / height * np.sqrt(2 * breadth / np.sqrt(np.pi))


def errors(image, course):
    found = find_line_centres(image, "v")
    assert len(found) >= 0.98 * HEIGHT
    return found.pixel[:, 0] - course[found.line], found


@pytest.mark.parametrize("breadth", [1.0, 1.5, 2.0, 3.0, 5.0])
def test_no_sub_pixel_place_is_preferred(breadth):
    error, found = errors(exposed(20 + profile(STRAIGHT, breadth, 150)), STRAIGHT)
    phase = np.floor(8 * (STRAIGHT[found.line] % 1)).astype(int)
    assert np.abs(np.bincount(phase, error) / np.bincount(phase)).max() < 0.05
    assert abs(error.mean()) < 0.005


@pytest.mark.parametrize("breadth", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("height", [120, 180])
def test_noise_is_near_the_least_there_can_be(breadth, height):
    error = np.concatenate(
        [errors(exposed(20 + profile(STRAIGHT, breadth, height), NOISE, s), STRAIGHT)[0] for s in range(4)]
    )
    assert error.std() < MOST_TIMES_BOUND * bound(breadth, height)
    assert abs(error.mean()) < 0.005


@pytest.mark.parametrize("noise", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("breadth", [1.5, 3.0])
def test_a_middle_knows_how_uncertain_it_is(breadth, noise):
    error, found = errors(exposed(30 + profile(STRAIGHT, breadth, 130), noise, 3), STRAIGHT)
    assert 0.7 < error.std() / np.median(found.std) < 1.3


@pytest.mark.parametrize("height", [300, 600, 1500])
@pytest.mark.parametrize("breadth", [2.0, 3.0])
def test_a_saturated_plateau_moves_no_middle(breadth, height):
    error, _ = errors(exposed(20 + profile(STRAIGHT, breadth, height), NOISE, 5), STRAIGHT)
    assert abs(error.mean()) < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.1


def test_a_glaring_stripe_is_still_found():
    error, _ = errors(exposed(20 + profile(STRAIGHT, 5, 3000), NOISE, 6), STRAIGHT)
    assert abs(error.mean()) < 0.02
    assert np.abs(error).max() < 0.2


def test_ambient_light_that_rises_moves_no_middle():
    error, _ = errors(exposed(np.linspace(5, 75, WIDTH) + profile(STRAIGHT, 2, 150), 1.0, 7), STRAIGHT)
    assert abs(error.mean()) < 0.02


def test_a_curved_course_is_followed():
    error, _ = errors(exposed(20 + profile(WAVY, 2, 150), NOISE, 8), WAVY)
    assert np.sqrt(np.mean(error**2)) < 0.05


def test_an_aslant_stripe_is_followed():
    course = 160 + 1.0 * np.arange(HEIGHT)
    error, _ = errors(exposed(20 + profile(course, 2.5, 150), NOISE, 9), course)
    assert abs(error.mean()) < 0.01
    assert error.std() < 0.1


@pytest.mark.parametrize("apart", [14, 20, 40])
def test_a_second_line_beside_the_first_moves_it_little(apart):
    light = profile(STRAIGHT, 2, 150) + profile(STRAIGHT + apart, 2, 120)
    found = find_line_centres(exposed(20 + light, 1.0, 10), "v")
    error = np.abs(found.pixel[:, :1] - np.stack([STRAIGHT, STRAIGHT + apart], axis=-1)[found.line])
    assert len(found) >= 2 * 0.98 * HEIGHT
    assert np.median(error.min(axis=1)) < 0.05
    assert error.min(axis=1).max() < 0.3


def test_every_middle_is_a_number_with_a_deviation():
    chaos = np.random.default_rng(13).integers(0, 256, (120, 500)).astype(np.uint8)
    chaos[:, 200:230] = 255
    chaos[60:, 240:244] = 255
    found = find_line_centres(chaos, "v")
    assert len(found) > 20
    assert np.isfinite(found.pixel).all()
    assert (found.std > 0).all()
    assert np.isfinite(found.std).all()


def test_a_broad_lamp_beside_a_faint_stripe_does_not_hide_it():
    light = profile(WAVY, 2, 70)
    light[:, 500:620] += 235
    found = find_line_centres(exposed(10 + light), "v")
    nearest = np.full(HEIGHT, np.inf)
    np.minimum.at(nearest, found.line, np.abs(found.pixel[:, 0] - WAVY[found.line]))
    assert np.all(nearest < 0.05)


def test_a_stripe_cut_by_the_border_has_no_middle():
    course = np.linspace(WIDTH - 30, WIDTH + 5, HEIGHT)
    found = find_line_centres(exposed(20 + profile(course, 5, 800)), "v")
    assert len(found) > HEIGHT // 2
    assert np.abs(found.pixel[:, 0] - course[found.line]).max() < 0.1
    assert course[found.line].max() < WIDTH - 5


def test_an_edge_beside_the_stripe_makes_it_lopsided():
    paper = np.where(np.arange(WIDTH) > WAVY[:, None] + 2, 0.2, 1.0)
    even = find_line_centres(exposed(20 + profile(WAVY, 4, 180)), "v")
    bitten = find_line_centres(exposed(paper * (20 + profile(WAVY, 4, 180))), "v")
    assert np.median(np.abs(bitten.asymmetry)) > 5 * np.median(np.abs(even.asymmetry))


BUILT = {
    "f": 8.06e-3, "s_u": 7.43e-6, "s_v": 7.38e-6, "u_0": 323.4, "v_0": 236.2, "k": 620.0, "b": 0.1412,
    "theta": 0.4451, **dict.fromkeys(("w", "phi", "psi", "t_x", "t_y", "t_z"), 0.0),
}  # fmt: skip
HEIGHT_M = 0.297
FALSE_PX = 2.0


def looking_down(tilt_deg=(0.0, 0.0, 0.0)):
    T = np.eye(4)
    T[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ Rotation.from_euler("xyz", tilt_deg, degrees=True).as_matrix()
    T[2, 3] = HEIGHT_M
    return T


FLAT = (Floor(0.0, 0.4),)
THINGS = (*FLAT, Sphere((0.002, -0.03, 0.012), 0.018), Cuboid((0.0, 0.03, 0.0), (0.03, 0.03, 0.01)))
OPTICS = ScannerOptics(BUILT, (0.0, 0.0, 0.0, 1.0), "xyz", "u")
EYE = CameraModel(OPTICS, OPTICS.lens)
LIGHT = Light(BUILT["b"], np.array(BUILT["theta"]), np.array(0.0), np.array(0.0))


@dataclass(frozen=True)
class Photo:
    """An image, and where its stripe is."""

    image: Image
    stripe: TrueStripe


def pictured(solids, *, power=260.0, speckle=0.1, tilt=(0.0, 0.0, 0.0)):
    scene, T = RenderedScene(solids, EYE, LIGHT, Projector(power, speckle=speckle)), looking_down(tilt)
    rng = np.random.default_rng(1)
    return Photo(scene.expose(*scene.render(T), rng=rng, grain=rng), true_stripe(scene, T))


def judged(photo):
    """Errors of true centres [px] with what they say of themselves, how many are false, and how many there are."""
    stripes = trace(photo.image, "u")
    there = photo.stripe.at
    off = stripes["v"][:, None] - there[np.rint(stripes["u"]).astype(int)]
    nearest = np.where(np.isfinite(off), np.abs(off), np.inf).argmin(axis=1)
    error = off[np.arange(len(off)), nearest]
    true = np.abs(error) < FALSE_PX
    return error[true], stripes["std"][true], int((~true).sum()), int(np.isfinite(there).any(axis=1).sum())


@pytest.mark.parametrize("tilt", [(0.0, 0.0, 0.0), (8.0, -15.0, 12.0)])
def test_a_stripe_on_a_floor_is_found_where_it_is(tilt):
    error, _, false, there = judged(pictured(FLAT, tilt=tilt, speckle=0.0))
    assert false == 0
    assert len(error) >= 0.95 * there
    assert abs(error.mean()) < 0.01
    assert np.sqrt(np.mean(error**2)) < 0.08


@pytest.mark.parametrize("power", [260.0, 2500.0])
def test_bodies_are_seen_and_centres_know_what_speckle_does_to_them(power):
    error, std, false, there = judged(pictured(THINGS, power=power))
    assert false <= 2
    assert len(error) >= 0.96 * there
    assert abs(error.mean()) < 0.03
    assert np.median(np.abs(error)) < 0.12
    assert 0.7 < 1.4826 * np.median(np.abs(error / std)) < 1.4
