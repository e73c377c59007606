"""Effects are taken in the order in which each explains most beside those before it."""

import numpy as np

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.score_tests import ScoreTest, library, score_tests, stepwise_order
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.noise_estimate import NoiseEstimate
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)


def scores_of_all_effects() -> list[ScoreTest]:
    raw = simulate(
        find_robot("scorbot_er7"), poses=24, points=6, noise=NOISE, seed=3,
        effects={"joint_compliance:joint_2": 1e-4, "encoder_eccentricity:joint_3": 3e-3},
    ).dataset  # fmt: skip
    data = AveragedData.of(raw)
    model = Model(data.dataset)
    x = model.parameters.nominal
    fit = Fit.of(problem_of(model, NoiseEstimate.of(data, model, x).for_weights(), model.parameters), x)
    return score_tests(fit, library(EFFECTS, raw))


def test_each_effect_taken_is_the_one_that_explains_most_beside_those_before() -> None:
    tests = scores_of_all_effects()
    order = stepwise_order(tests, most=4)
    assert len(order) == len(set(order)) == 4
    for i in range(4):
        before = [tests[j].basis for j in order[:i]]

        def net(one: ScoreTest, before: list[np.ndarray] = before) -> float:
            return -left(np.hstack([*before, one.basis]), one.against.at.r) - one.penalty

        others = [one for j, one in enumerate(tests) if j not in order[:i]]
        assert net(tests[order[i]]) >= max(map(net, others)) - 1e-2


def test_of_no_effects_none_is_taken() -> None:
    assert stepwise_order([], most=3) == []


def left(columns: np.ndarray, residuals: np.ndarray) -> float:
    return float(((residuals - columns @ np.linalg.lstsq(columns, residuals, rcond=1e-5)[0]) ** 2).sum())
