"""The geometry of a whole arm as one effect."""

from dataclasses import replace

import numpy as np
import pytest
from worlds import kinds

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.arm_geometry import marginal_cost, placements_of_arm
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.profile_likelihood import SIZES
from robolaser.diagnosis.thresholds import LARGEST_USUAL
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

PLACEMENT = {effect.name: effect for effect in EFFECTS}["link_geometry"]
JOINTS = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint")


def placements(count: int) -> tuple[CandidateEffect, ...]:
    return tuple(CandidateEffect(PLACEMENT, joint) for joint in JOINTS[:count])


def test_one_or_two_placements_are_no_arm() -> None:
    assert placements_of_arm(placements(2)) == ()
    assert placements_of_arm(placements(3)) == placements(3)


def posterior(J: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of parameters with a prior of unit variance, seen in unit noise."""
    covariance = np.linalg.inv(J.T @ J + np.eye(J.shape[1]))
    return covariance @ J.T @ y, covariance


def minus_twice_log_likelihood(J: np.ndarray, y: np.ndarray, size: float) -> float:
    V = np.eye(len(y)) + size**2 * J @ J.T
    return float(y @ np.linalg.solve(V, y) + np.linalg.slogdet(V)[1])


@pytest.mark.parametrize("true_size", [0.05, 1.0, 5.0])
def test_the_marginal_cost_is_that_of_the_likeliest_size(true_size: float) -> None:
    rng = np.random.default_rng(3)
    J = rng.standard_normal((60, 8)) * np.geomspace(0.1, 30, 8)
    y = J @ (true_size * rng.standard_normal(8)) + rng.standard_normal(60)
    x, covariance = posterior(J, y)
    left = y - J @ x
    cost = left @ left + x @ x + marginal_cost(x, covariance, np.ones(8))
    sizes = SIZES[SIZES <= LARGEST_USUAL]
    assert cost == pytest.approx(min(minus_twice_log_likelihood(J, y, size) for size in sizes), rel=1e-9)


def test_parameters_that_the_data_do_not_see_cost_nothing() -> None:
    assert marginal_cost(np.zeros(3), np.eye(3), np.ones(3)) == pytest.approx(0.0, abs=1e-9)


@pytest.fixture(scope="module")
def sloppy() -> Diagnosis:
    """An arm that is off everywhere a little, before a tracker."""
    rng = np.random.default_rng(4)
    sizes = {f"link_geometry:{joint}": 3e-4 * (1 + rng.random()) for joint in JOINTS}
    sizes |= {f"joint_offset:{joint}": 1e-3 * rng.standard_normal() for joint in JOINTS}
    noise = Noise(point_m=2e-5)
    made = simulate(find_robot("ur5"), kind="point", poses=60, points=3, noise=noise, effects=sizes, seed=4)
    others = kinds("encoder_scale", "joint_compliance", "arm_scale", "tracker_scale")
    return examine(made.dataset, kinds("link_geometry", "joint_offset") + others, seed=0)


def test_an_arm_that_is_off_everywhere_is_explained_by_its_geometry(sloppy: Diagnosis) -> None:
    assert sloppy.verdict == "explained"
    first = sloppy.classes[0]
    assert first.name == "arm_geometry"
    assert first.probability > 0.95
    assert sloppy.gap.after_m < 1.25 * sloppy.gap.noise_floor_m


def test_what_the_data_do_not_determine_has_no_standard_deviation(sloppy: Diagnosis) -> None:
    stds = [one.std for found in sloppy.findings for one in found.parameters.values()]
    assert None in stds
    assert any(std is not None for std in stds)


def test_a_corrected_arm_stays_nominal_along_what_the_data_do_not_see() -> None:
    """In sockets at no known distance nothing tells the scale, nor parallel axes, the base and the last joint apart."""
    effects = {f"link_geometry:{joint}": 1e-3 for joint in JOINTS}
    noise = Noise(point_m=2e-5)
    dataset = simulate(
        find_robot("ur5"), kind="socket", poses=60, points=4, noise=noise, effects=effects, seed=6
    ).dataset
    start = Preparation.of(replace(dataset, distances_m=()), 0).fit(())
    problem = problem_of(start.model.with_effects(placements(len(JOINTS))), start.noise, start.sensor)
    arm = Fit.of(problem, np.append(start.x, np.zeros(len(problem.prior) - len(start.x))))
    _, seen, directions = np.linalg.svd(arm.at.slopes / problem.scale * problem.prior)
    unseen = directions[np.append(seen, np.zeros(len(directions) - len(seen))) < 0.1]
    assert len(unseen) > 8
    moved = (arm.x - problem.parameters.nominal) / problem.prior
    assert np.linalg.norm(moved) > 0.3
    np.testing.assert_allclose(unseen @ moved, 0.0, atol=0.02)


def test_a_variance_that_rounding_makes_zero_has_a_cost_too() -> None:
    singular = np.outer([1.0, 1.0, 0.0], [1.0, 1.0, 0.0])
    assert np.isfinite(marginal_cost(np.ones(3), singular, np.ones(3)))
