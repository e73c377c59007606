"""Campaigns with one sensor: what it keeps between them, every campaign measures with."""

import numpy as np
import pytest

from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate


@pytest.mark.parametrize("mount", ["flange", "base"])
@pytest.mark.parametrize("kind", ["camera", "profile"])
def test_a_sensor_that_all_sessions_share_sees_its_target_in_each_of_them(kind: str, mount: str) -> None:
    made = simulate(find_robot("ur5"), kind=kind, poses=10, options=CellOptions(mount=mount, sessions=2), seed=1)
    model = Model(made.dataset)
    truth = np.array([[made.truth[name] for name in model.parameters.names]])
    assert not any(name.startswith("hand_eye.") and "@" in name for name in made.truth)
    np.testing.assert_allclose(model.residuals_at(model.parameters.values(truth)), 0.0, atol=1e-8)
    assert len(np.unique(made.dataset.points.pose)) == 20
