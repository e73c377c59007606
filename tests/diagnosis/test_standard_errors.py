"""Standard errors hold where poses scatter as wholes, and where effects are at work that nobody found."""

from types import SimpleNamespace

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.standard_errors import between_models, clustered_variances, considered_variances
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.base_shift import BaseShift
from robolaser.model.effects.run import Run
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

POSES, ROWS, WORLDS = 40, 5, 300
CLUSTER = np.repeat(np.arange(POSES), ROWS)


class Regression:
    """Three parameters, and forty further columns that are not fitted."""

    def __init__(self):
        rng = np.random.default_rng(7)
        columns = rng.normal(size=(POSES, 43))[CLUSTER] + 0.3 * rng.normal(size=(len(CLUSTER), 43))
        self.X, self.W = columns[:, :3], columns[:, 3:]
        self.Q = np.linalg.qr(self.X)[0]
        self.influence = np.linalg.pinv(self.X)
        self.noise = np.diag(self.influence @ self.influence.T)

    def left(self, y):
        return y - self.Q @ (self.Q.T @ y)


@pytest.fixture(scope="module")
def fit():
    return Regression()


def test_where_rows_are_independent_clusters_say_what_noise_does(fit):
    errors = np.random.default_rng(1).normal(size=(WORLDS, len(CLUSTER)))
    found = [clustered_variances(fit.influence, fit.Q, fit.left(e), CLUSTER) for e in errors]
    np.testing.assert_allclose(np.mean(found, axis=0), fit.noise, rtol=0.1)


def test_where_poses_scatter_as_wholes_clusters_say_how_far_estimates_are_off(fit):
    rng = np.random.default_rng(2)
    errors = rng.normal(size=(WORLDS, len(CLUSTER))) + rng.normal(size=(WORLDS, POSES))[:, CLUSTER]
    found = [clustered_variances(fit.influence, fit.Q, fit.left(e), CLUSTER) for e in errors]
    true = np.square(errors @ fit.influence.T).mean(axis=0)
    np.testing.assert_allclose(np.mean(found, axis=0), true, rtol=0.25)
    assert (true > 2 * fit.noise).all()


def test_the_order_of_rows_and_unequal_clusters_do_not_matter(fit):
    rng = np.random.default_rng(3)
    kept = rng.permutation(len(CLUSTER))[:150]
    r = rng.normal(size=len(CLUSTER))
    one = clustered_variances(fit.influence[:, kept], fit.Q[kept], r[kept], CLUSTER[kept])
    again = np.sort(kept)
    other = clustered_variances(fit.influence[:, again], fit.Q[again], r[again], CLUSTER[again])
    np.testing.assert_allclose(one, other)


def covered(fit, size, seed):
    """Share of intervals that hold the truth: by noise alone, and with what other effects may add."""
    rng = np.random.default_rng(seed)
    columns, pull = fit.left(fit.W), fit.influence @ fit.W
    hits = []
    for _ in range(WORLDS):
        y = fit.W @ (size * rng.normal(size=40)) + rng.normal(size=len(CLUSTER))
        off = np.abs(fit.influence @ y)
        added = considered_variances(pull, columns, fit.left(y))
        hits.append([off < 1.96 * np.sqrt(fit.noise), off < 1.96 * np.sqrt(fit.noise + added)])
    return np.mean(hits, axis=(0, 2))


def test_intervals_hold_the_truth_beside_effects_that_nobody_found(fit):
    by_noise, with_others = covered(fit, 0.2, seed=4)
    assert by_noise < 0.8
    assert 0.92 < with_others < 0.99


def test_where_nothing_else_is_at_work_next_to_nothing_is_added(fit):
    y = np.random.default_rng(5).normal(size=len(CLUSTER))
    assert (considered_variances(fit.influence @ fit.W, fit.left(fit.W), fit.left(y)) < 0.1 * fit.noise).all()


def fitted(**values):
    return SimpleNamespace(x=np.array(list(values.values())), values=values)


def test_what_may_stand_in_an_effects_place_moves_the_others_by_its_weight():
    final = fitted(offset=1.0, gain=2.0)
    rival = object()
    one = SimpleNamespace(
        without=fitted(gain=2.3), alternatives=((rival, fitted(gain=1.8)),), weights={None: 0.1, rival: 0.5}
    )
    np.testing.assert_allclose(between_models(final, [one]), [0.0, 0.1 * 0.3**2 + 0.5 * 0.2**2])


def test_a_small_error_everywhere_widens_the_interval_of_what_was_found():
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    few = [kind for kind in EFFECTS if kind.name in ("backlash", "joint_offset", "link_geometry", "laser_roll")]

    def std(background):
        effects = {"backlash:joint_3": 1e-3} | background
        found = examine(
            simulate(find_robot("scorbot_er7"), poses=25, points=6, noise=noise, effects=effects, seed=3).dataset,
            few,
            seed=0,
        ).findings
        return (
            next(one for one in found if one.candidate_effect.effect.name == "backlash").parameters["lost_motion"].std
        )

    alone = std({})
    beside = std({f"link_geometry:joint_{k}.{axis}": 8e-5 for k in (2, 3, 4) for axis in ("x", "turn_x", "turn_y")})
    assert beside > 1.1 * alone


@pytest.mark.parametrize("poses", [20, 40])
def test_when_something_moved_is_known_up_to_the_pause_between_two_poses(poses: int) -> None:
    effects = {"base_shift:base": 3e-3, "base_shift:base.moment": 0.4}
    made = simulate(find_robot("ur5e"), kind="point", poses=poses, noise=Noise(point_m=5e-5), effects=effects, seed=2)
    (found,) = examine(made.dataset, [BaseShift], seed=0).findings
    moment, run = found.parameters["moment"], Run(made.dataset)
    assert 0.0 < moment.std < np.diff(np.unique(run.progress_of_all)).max()
    assert abs(moment.value - 0.4) < 2.0 * moment.std
