"""How rows move with what passes a stage agrees with how they move with the parameters of effects there."""

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.stage_derivatives import StageDerivatives
from robolaser.estimation.noise_estimate import noise_of
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
