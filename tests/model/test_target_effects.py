"""Printed targets: true to their plane, but longer, bowed, in steps or askew; and lengths of who measures them."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser import Plan, calibrate
from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.model.effects.run import Run
from robolaser.model.effects.stripe_bias import StripeBias
from robolaser.model.effects.target_plane import plane_of
from robolaser.model.effects.target_scale import TargetScale
from robolaser.model.effects.target_warp import TargetWarp
from robolaser.model.effects.tracker_scale import TrackerScale
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

ONE, NONE = np.ones(1), np.zeros(1)
TILT = exp_so3(np.array([0.3, -0.2, 0.1]))


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return simulate(find_robot("scorbot_er7"), poses=8, points=6, seed=3).dataset


def sheet(count: int = 100) -> Array:
    """Points on z = 0, 0.4 m by 0.2 m, its corners among them."""
    inner = np.random.default_rng(1).uniform(-1, 1, (count, 2))
    corners = [[-1, -1], [-1, 1], [1, -1], [1, 1]]
    return np.column_stack([np.concatenate([inner, corners]) * (0.2, 0.1), np.zeros(count + 4)])


def of(dataset: Dataset, xyz: Array) -> Run:
    points = dataset.points.take(np.arange(len(xyz)) % len(dataset.points))
    return Run(replace(dataset, points=replace(points, xyz=xyz)))


def test_a_plane_is_found_however_it_lies() -> None:
    plane = plane_of(sheet() @ TILT.T + (0.5, 0.1, 0.2))
    np.testing.assert_allclose(plane.axes[:, 2], TILT[:, 2], atol=1e-12)
    np.testing.assert_allclose(plane.axes.T @ plane.axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(plane.axes) == pytest.approx(1.0)
    assert plane.flatness < 1e-10


def test_the_steps_of_a_target_are_one_plane() -> None:
    xyz = sheet()
    xyz[:, 2] = 0.03 * np.floor(3 * np.random.default_rng(2).random(len(xyz)))
    xyz[:, 0] += 2 * xyz[:, 2]
    np.testing.assert_allclose(plane_of(xyz).axes, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("kind", [TargetScale, TargetWarp, StripeBias])
def test_a_target_in_the_round_has_no_plane_to_bow(dataset: Dataset, kind: type) -> None:
    ball = np.random.default_rng(3).normal(size=(60, 3))
    round_ = of(dataset, 0.2 * ball / np.linalg.norm(ball, axis=1, keepdims=True)).dataset
    assert kind.missing(round_) == "the target points do not lie in one plane, nor in parallel ones"
    assert kind.locations(of(dataset, np.outer(np.linspace(0, 1, 20), [1.0, 2.0, 0.0])).dataset) == ()


def test_a_scaled_grid_grows_in_its_plane_from_its_centre(dataset: Dataset) -> None:
    xyz = sheet() @ TILT.T
    run = of(dataset, xyz)
    grown = TargetScale("target", 0.01 * ONE, NONE, NONE).apply(xyz[None], run)[0]
    apart = np.linalg.norm(xyz[:, None] - xyz, axis=-1)
    np.testing.assert_allclose(np.linalg.norm(grown[:, None] - grown, axis=-1), 1.01 * apart, atol=1e-12)
    np.testing.assert_allclose((grown - xyz) @ run.target.axes[:, 2], 0, atol=1e-12)


def test_where_it_was_fastened_a_scaled_grid_stays(dataset: Dataset) -> None:
    xyz = sheet()
    run = of(dataset, xyz)
    corner = (xyz[-1] - run.target.centre) @ run.target.axes
    grown = TargetScale("target", 0.01 * ONE, corner[:1], corner[1:2]).apply(xyz[None], run)[0]
    np.testing.assert_allclose(grown[-1], xyz[-1], atol=1e-15)
    assert np.linalg.norm(grown[0] - xyz[0]) > 1e-3


def warped(**numbers: float) -> TargetWarp:
    flat = {name: NONE for name, *_ in TargetWarp.amplitudes()}
    return TargetWarp("target", **flat | {name: value * ONE for name, value in numbers.items()})


def test_a_bowed_target_rises_at_its_rim_by_the_sagitta(dataset: Dataset) -> None:
    xyz = sheet()
    bowed = warped(xx=1e-3, yy=4e-3).apply(xyz[None], of(dataset, xyz))[0]
    np.testing.assert_allclose(bowed[-4:, 2], 1e-3 + 4e-3 / 4, atol=1e-12)
    np.testing.assert_array_equal(bowed[:, :2], xyz[:, :2])


def test_a_wave_along_one_axis_is_even_along_the_other_and_never_higher_than_its_number(dataset: Dataset) -> None:
    xyz = sheet()
    along = warped(wave_3_0=1e-3).apply(xyz[None], of(dataset, xyz))[0, :, 2]
    order = np.argsort(xyz[:, 0])
    slid = xyz.copy()
    slid[:-4, 1] = np.random.default_rng(5).permutation(slid[:-4, 1])
    np.testing.assert_array_equal(warped(wave_3_0=1e-3).apply(slid[None], of(dataset, slid))[0, :, 2], along)
    assert np.abs(along).max() == pytest.approx(1e-3, rel=0.05)
    assert (np.diff(np.sign(along[order])) != 0).sum() == 3


def test_a_target_that_stands_higher_or_askew_keeps_its_form(dataset: Dataset) -> None:
    xyz = sheet()
    askew = warped(z=1e-3, x=2e-3, y=-1e-3).apply(xyz[None], of(dataset, xyz))[0]
    assert plane_of(askew).flatness < 1e-10


SCALE = 3e-4


def test_a_tracker_that_reads_too_long_is_found_by_an_arm_whose_links_are_known() -> None:
    made = simulate(find_robot("ur5"), kind="point", poses=25, effects={"tracker_scale": SCALE}, seed=1)
    found = calibrate(made.dataset, Plan(effects=("tracker_scale",)))
    assert found.value("tracker_scale.measuring_system.scale") == pytest.approx(SCALE, rel=0.05)


def test_only_what_reads_lengths_has_a_scale() -> None:
    for kind, reason in (("stripe", "no lengths of its own"), ("socket", "target")):
        assert reason in TrackerScale.missing(simulate(find_robot("ur5"), kind=kind, poses=6, seed=1).dataset)


def test_lengths_that_read_too_long_are_shortened() -> None:
    points = np.random.default_rng(1).normal(size=(1, 5, 3))
    dataset = simulate(find_robot("ur5"), kind="point", poses=6, seed=1).dataset

    np.testing.assert_allclose(
        TrackerScale("measuring_system", np.array([SCALE])).apply(points, Run(dataset)) * (1 + SCALE), points
    )
