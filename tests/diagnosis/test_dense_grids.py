"""Sums over poses tell of each frequency and each moment what its columns tell."""

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.dense_grids import fourier_sums, gains_of_steps, gains_of_waves
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import Fit, best_amplitudes
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.score_tests import normal_equations
from robolaser.model.effects.base_shift import BaseShift
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.transmission_error import TransmissionError
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.fixture(scope="module")
def fitted() -> Fit:
    noise = Noise(point_m=2e-5)
    cell = simulate(
        find_robot("scorbot_er7"), kind="point", poses=60, effects={"joint_offset:joint_3": 1e-3}, noise=noise
    )
    return Preparation.of(cell.dataset, 1).fit(())


def gains(fit: Fit, candidate_effect: CandidateEffect, grid: Array) -> list[float]:
    """By how much columns lower chi-squared, one value of the nonlinear parameter after the other."""
    white = Columns().by_effect(fit, candidate_effect, grid)
    found, r = [], fit.at.r
    for columns in np.split(fit.at.project(white), len(grid), axis=1):
        after = r + columns @ best_amplitudes(columns, r)
        found.append(float(r @ r - after @ after))
    return found


def test_a_fourier_sum_is_the_sum_of_its_terms() -> None:
    rng = np.random.default_rng(1)
    angle, columns, frequencies = rng.uniform(-6.0, 6.0, 200), rng.normal(size=(200, 3)), np.linspace(10.0, 330.0, 700)
    plain = np.exp(1j * frequencies[:, None] * angle) @ columns
    assert fourier_sums(angle, columns, frequencies) == pytest.approx(plain, abs=1e-9 * np.abs(columns).sum())


def test_what_waves_explain_is_what_their_columns_explain(fitted: Fit) -> None:
    wave = CandidateEffect(TransmissionError, "joint_3")
    robot, q = fitted.model.dataset.arm
    grid = wave.effect.grid(fitted.model.dataset, wave.where)
    normal = normal_equations(fitted, Columns().by_joint(fitted, wave.where), fitted.pose_of_number, len(q))
    angle = q[:, robot.joints.index(wave.where)]
    fast = gains_of_waves(normal, angle, grid[:, 0], wave.effect.harmonics, prior_scales(wave))
    assert fast == pytest.approx(gains(fitted, wave, grid), rel=1e-5)


def test_what_steps_explain_is_what_their_columns_explain(fitted: Fit) -> None:
    step = CandidateEffect(BaseShift, "base")
    grid = step.effect.grid(fitted.model.dataset, step.where)
    white = Columns().by_effect(fitted, step, np.zeros((1, 1)))
    fast = gains_of_steps(fitted, white, fitted.model.run.progress, grid[:, 0])
    assert fast == pytest.approx(gains(fitted, step, grid), rel=1e-5)
