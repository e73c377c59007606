"""How rows move with what passes a stage agrees with how they move with the parameters of effects there."""

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.score_tests import library
from robolaser.diagnosis.stage_derivatives import StageDerivatives
from robolaser.estimation.noise_estimate import noise_of
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.base_compliance import BaseCompliance
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.effects.link_geometry import LinkGeometry
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

JOINT = "elbow_joint"
OFFSET, PLACED = CandidateEffect(JointOffset, JOINT), CandidateEffect(LinkGeometry, JOINT)
OTHERS = (CandidateEffect(LinkGeometry, "wrist_1_joint"), CandidateEffect(BaseCompliance, "base"))


@pytest.mark.parametrize("kind", ["stripe", "point"])
def test_rows_move_with_joints_and_links_as_with_effects_that_move_these(kind: str) -> None:
    noise = Noise(pixel_px=0.1) if kind == "stripe" else Noise(point_m=3e-5)
    dataset = simulate(find_robot("ur5"), kind=kind, poses=8, noise=noise, seed=3).dataset
    plain, model = Model(dataset), Model(dataset, (*OTHERS, OFFSET, PLACED))
    problem = problem_of(model, noise_of(plain, plain.parameters.nominal), plain.sensor_parameters)
    names, x = problem.parameters.names, problem.parameters.nominal
    for one in OTHERS:
        some = [names.index(one.key(amplitude.name)) for amplitude in one.effect.amplitudes()]
        x[some] = 0.1 * problem.parameters.upper[some]
    slopes = dict(zip(names, (Fit(problem, x).at.slopes / problem.scale).T, strict=True))
    known = StageDerivatives(Fit(problem, x))
    for one, moved in ((OFFSET, known.by_motion(Stage.JOINTS, JOINT)), (PLACED, known.by_motion(Stage.LINKS, JOINT))):
        expected = np.column_stack([slopes[name] for name in one.parameters.names])
        np.testing.assert_allclose(moved, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("kind", ["stripe", "camera", "point"])
def test_columns_of_every_effect_are_those_of_a_fit_where_poses_scatter(kind: str) -> None:
    noise = Noise(pixel_px=0.1) if kind != "point" else Noise(point_m=3e-5)
    dataset = simulate(find_robot("ur5"), kind=kind, poses=8, noise=noise, seed=3).dataset
    model = Model(dataset)
    nominal = noise_of(model, model.parameters.nominal)
    scattering = nominal.at({source.name: 1e-3 for source in nominal.sources_of_poses})
    assert len(scattering.scatter)
    fit = Fit(problem_of(model, scattering, model.sensor_parameters), model.parameters.nominal)
    for one in library(EFFECTS, dataset):
        grid = one.effect.grid(dataset, one.where)[:1]
        expected = fit.at.columns(one, grid)[0] * prior_scales(one)
        found = Columns().by_effect(fit, one, grid)
        np.testing.assert_allclose(found, expected, atol=1e-6 * max(1e-9, np.abs(expected).max()), err_msg=str(one))
