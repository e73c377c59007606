"""What is held out is predicted by a fit of all the rest, and by nothing else."""

import numpy as np
import pytest

from robolaser.data.dataset import Noise
from robolaser.estimation.cross_validation import _all_but_one, fold_of_rows, held_out
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.r_factor import triangle
from robolaser.geometry.robots import find_robot
from robolaser.model.forward_model import Model
from robolaser.simulation import simulate


@pytest.mark.parametrize("count", [2, 3, 10])
def test_all_triangles_but_one_are_those_of_the_other_rows(count: int) -> None:
    rng = np.random.default_rng(count)
    parts = [rng.normal(size=(30, 5)) for _ in range(count)]
    for left_out, R in enumerate(_all_but_one([triangle(part) for part in parts])):
        rest = np.concatenate(parts[:left_out] + parts[left_out + 1 :])
        np.testing.assert_allclose(R.T @ R, rest.T @ rest, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", ["stripe", "point", "socket"])
def test_rows_are_predicted_as_a_fit_without_their_poses_predicts_them(kind: str) -> None:
    noise = Noise(pixel_px=0.1, target_m=3e-5) if kind == "stripe" else Noise(point_m=3e-5, joint_rad=1e-5)
    model = Model(simulate(find_robot("ur5"), kind=kind, poses=24, noise=noise, seed=3).dataset)
    box, residuals = Box.of(model), Residuals(model)
    x = box.polish(residuals, model.parameters.nominal).x
    errors, _ = held_out(residuals, x, box, seed=1)
    groups = fold_of_rows(model.dataset, 1)
    assert errors is not None
    assert groups is not None
    for group in np.unique(groups)[:4]:
        out = groups == group
        refitted = box.polish(residuals, x, tol=1e-12, kept=~out).x
        there = model.residuals(refitted[None])[0, out]
        apart = np.sqrt(((errors[out] - there) ** 2).mean() / (there**2).mean())
        assert apart < 0.02
