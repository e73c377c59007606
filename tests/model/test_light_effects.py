from dataclasses import replace

import cv2
import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import intersect, laser_plane, rays
from robolaser.model.effects.laser_curvature import LaserCurvature
from robolaser.model.effects.laser_drift import LaserDrift
from robolaser.model.effects.radial_distortion import RadialDistortion
from robolaser.model.effects.run import Run
from robolaser.model.effects.stripe_bias import StripeBias
from robolaser.model.effects.tangential_distortion import TangentialDistortion
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

F = 0.008
K = np.diag([F, F, 1.0])


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return simulate(find_robot("scorbot_er7"), poses=10, points=4, seed=3).dataset


@pytest.fixture(scope="module")
def run(dataset: Dataset) -> Run:
    return Run(dataset)


def image(seed: int = 1) -> Array:
    """Image points within a sensor of 640 × 480 pixels, (1, m, 2) [m]."""
    return np.random.default_rng(seed).uniform(-1, 1, (1, 50, 2)) * (2.4e-3, 1.8e-3)


def distorted(points: Array, *coefficients: float) -> Array:
    """By OpenCV, (1, m, 2) [m]."""
    directions = np.column_stack([points[0] / F, np.ones(points.shape[1])])
    return cv2.projectPoints(directions, np.zeros(3), np.zeros(3), K, np.array(coefficients))[0][None, :, 0]


def test_a_decentred_lens_agrees_with_opencv_to_first_order(run: Run) -> None:
    x = image()
    for p in ((1e-4, 0.0), (0.0, 1e-4), (5e-5, -8e-5)):
        ours = TangentialDistortion("camera", *[np.array([-one / F]) for one in p]).apply(x, run) - x
        theirs = x - distorted(x, 0.0, 0.0, *p)
        np.testing.assert_allclose(ours, theirs, atol=2e-3 * np.abs(theirs).max())


def test_a_higher_radial_term_agrees_with_opencv_to_first_order(run: Run) -> None:
    x, k_2 = image(), 1e-3
    ours = RadialDistortion("camera", np.array([-k_2 / F**4])).apply(x, run) - x
    theirs = x - distorted(x, 0.0, k_2, 0.0, 0.0)
    np.testing.assert_allclose(ours, theirs, atol=2e-3 * np.abs(theirs).max())


def test_lenses_of_typical_size_err_by_tenths_of_a_pixel_at_the_corner(run: Run) -> None:
    corner = np.array([[[2.4e-3, 1.8e-3]]])
    for kind in (RadialDistortion, TangentialDistortion):
        numbers = [np.array([typical]) for *_, typical in kind.amplitudes()]
        moved_px = np.linalg.norm(kind("camera", *numbers).apply(corner, run) - corner) / 7.4e-6
        assert 0.1 < moved_px < 1.0


def nominal(dataset: Dataset) -> dict[str, Array]:
    return {name: np.array([item.nominal]) for name, item in dataset.parameters.items()}


@pytest.mark.parametrize("curvature", [-0.5, 0.04, 1.0])
def test_points_on_a_curved_sheet_lie_on_it_and_on_their_rays(dataset: Dataset, run: Run, curvature: float) -> None:
    values = nominal(dataset)
    sheet = laser_plane(values)
    flat = intersect(rays(image(), values["f"], "u"), sheet)
    bent = LaserCurvature("laser", np.array([curvature]), np.zeros(1)).apply(flat, run)
    np.testing.assert_allclose(np.cross(bent, flat), 0, atol=1e-16)
    off = (bent * sheet[..., :3]).sum(axis=-1) - sheet[..., 3]
    np.testing.assert_allclose(off, curvature / 2 * bent[..., 1] ** 2, atol=1e-15)


@pytest.mark.parametrize("cone", [-0.2, 0.01, 0.3])
def test_points_on_a_cone_of_light_lie_on_it_and_on_their_rays(dataset: Dataset, run: Run, cone: float) -> None:
    """The projector stands on the camera's x axis: a point's depth says how far from there its middle is."""
    values = nominal(dataset)
    sheet = laser_plane(values)
    flat = intersect(rays(image(), values["f"], "u"), sheet)
    bent = LaserCurvature("laser", np.zeros(1), np.array([cone])).apply(flat, run)
    np.testing.assert_allclose(np.cross(bent, flat), 0, atol=1e-16)
    off = (bent * sheet[..., :3]).sum(axis=-1) - sheet[..., 3]
    middle = bent[..., 2] / np.cos(values["theta"])
    np.testing.assert_allclose(off, np.tan(cone) * (np.hypot(middle, bent[..., 1]) - middle), atol=1e-14)


def test_a_drifting_sheet_is_one_of_another_angle_that_keeps_its_baseline(dataset: Dataset, run: Run) -> None:
    values = nominal(dataset)
    drifted = LaserDrift("laser", angle=np.array([2e-3]), tau=np.array([0.3])).apply(laser_plane(values), run)[0]
    for row, pose in enumerate(dataset.points.pose):
        turned = values | {"theta": values["theta"] + 2e-3 * (1 - np.exp(-run.progress[pose] / 0.3))}
        np.testing.assert_allclose(drifted[row], laser_plane(turned)[0, 0], atol=1e-15)


def test_a_surface_seen_square_on_has_no_tilt_and_turning_it_tilts_it_by_as_much(dataset: Dataset) -> None:
    """A camera at the flange's origin that looks straight down on the plane z = 0, then tilted about its y axis."""
    angles = np.array([0.0, 0.2, -0.3])
    T = np.zeros((3, 4, 4))
    for i, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        T[i] = [[c, 0, s, 0], [0, -1, 0, 0], [s, 0, -c, 0.3], [0, 0, 0, 1]]
    square = {"w": 0.0, "phi": 0.0, "psi": 0.0, "t_x": 0.0, "t_y": 0.0, "t_z": 0.0}
    parameters = {
        name: replace(item, nominal=square.get(name, item.nominal)) for name, item in dataset.parameters.items()
    }
    centre = np.array([[parameters["u_0"].nominal, parameters["v_0"].nominal]])
    xyz = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
    cell = replace(
        dataset,
        robot=None,
        bracket_quat=(0.0, 0.0, 0.0, 1.0),
        parameters=parameters,
        poses=replace(dataset.poses.take(np.arange(3)), q=None, T_base_flange=T),
        points=replace(dataset.points.take(np.arange(3)), pose=np.arange(3), pixel=centre.repeat(3, axis=0), xyz=xyz),
    )
    tilt = Run(cell).tilt
    np.testing.assert_allclose(np.abs(tilt), np.abs(np.tan(angles)), atol=1e-12)
    assert tilt[1] * tilt[2] < 0


@pytest.mark.parametrize(("axis", "across"), [("u", 1), ("v", 0)])
def test_a_biased_stripe_shifts_across_itself_only(axis: str, across: int) -> None:
    dataset = simulate(
        find_robot("scorbot_er7"), poses=6, points=3, options=CellOptions(stripe_axis=axis), seed=2
    ).dataset
    run = Run(dataset)
    pixel = dataset.points.pixel[None]
    shift = (StripeBias("laser", np.array([0.2])).apply(pixel, run) - pixel)[0]
    np.testing.assert_array_equal(shift[:, 1 - across], 0)
    np.testing.assert_allclose(shift[:, across], 0.2 * run.tilt, atol=1e-12)
    assert np.ptp(run.tilt) > 0.1


def test_the_tilt_is_nearly_the_same_whether_or_not_the_target_is_placed() -> None:
    made = simulate(find_robot("scorbot_er7"), poses=10, points=4, seed=3).dataset
    moved = replace(made, placed=False, points=replace(made.points, xyz=made.points.xyz + np.array([0.1, -0.2, 0.3])))
    np.testing.assert_allclose(Run(moved).tilt, Run(made).tilt, atol=0.1)
