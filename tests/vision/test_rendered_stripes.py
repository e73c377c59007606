"""The stripe as a renderer draws it, which knows the truth at every pixel."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from true_stripe import TrueStripe, true_stripe

from robolaser.arrays import Image
from robolaser.emulator.world.scene import CameraModel, Projector, RenderedScene
from robolaser.emulator.world.solids import Cuboid, Floor, Sphere
from robolaser.trials.synthetic.scanner import Light, ScannerOptics
from robolaser.vision.stripe_trace import trace

BUILT = {
    "f": 8.06e-3,
    "s_u": 7.43e-6,
    "s_v": 7.38e-6,
    "u_0": 323.4,
    "v_0": 236.2,
    "k": 620.0,
    "b": 0.1412,
    "theta": 0.4451,
    **dict.fromkeys(("w", "phi", "psi", "t_x", "t_y", "t_z"), 0.0),
}
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
