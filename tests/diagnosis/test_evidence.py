"""What the evidence rests on, each law by itself."""

from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np
import pytest
from board_cell import begun, cell
from scipy.stats import chi2, kstest
from worlds import kinds

import robolaser
from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.evidence import EffectEvidence, evidence_for
from robolaser.diagnosis.findings import explained_sites
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.localization import localize, p_value
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.diagnosis.score_tests import library, score_tests
from robolaser.errors import UsageError
from robolaser.estimation.folds import assign_folds
from robolaser.estimation.solver import solve
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.effects.effect import Effect, Run, parameter
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate
from robolaser.trials.building import Ranges
from robolaser.trials.making import make


def test_repeats_are_averaged_into_one_row_a_point(clean):
    observed, _ = clean
    assert len(observed.dataset.points) == 40 * 8
    assert (observed.shots == 2).all()
    raw = cell().points.pixel
    np.testing.assert_allclose(observed.dataset.points.pixel[0], raw[observed.group == 0].mean(axis=0))


def test_whitened_residuals_of_a_true_model_are_standard_normal(clean):
    _, fitted = clean
    assert kstest(fitted.at.white, "norm").pvalue > 1e-3
    assert fitted.chi2 == pytest.approx(len(fitted.at.white) - len(fitted.x), abs=4 * np.sqrt(2 * len(fitted.at.white)))


def test_what_an_effect_promises_is_what_a_full_fit_gains():
    _, fitted = begun(cell({"joint_offset:joint_3": 1e-3}))
    (score,) = score_tests(fitted, candidate_effects(["joint_offset:joint_3"], fitted.model.dataset))
    refits = Refits(fitted, [score.candidate_effect])
    gained = fitted.chi2 - refits.refit(fitted, [score]).chi2
    assert gained > 500
    assert score.gain == pytest.approx(gained, rel=0.02)
    assert refits.refit(fitted, [score]).values["joint_offset.joint_3.offset"] == pytest.approx(1e-3, abs=5e-5)


@pytest.mark.parametrize("seed", [5, 8])
def test_of_shapes_that_explain_the_same_the_first_counts_whatever_the_rounding(seed):
    made = simulate(find_robot("scorbot_er7"), kind="point", poses=30, noise=Noise(point_m=3e-5), seed=seed)
    _, fitted = begun(made.dataset)
    (link,) = candidate_effects(["link_compliance:joint_2"], fitted.model.dataset)
    (score,) = score_tests(fitted, [link])
    assert score.nonlinear == tuple(link.effect.grid(fitted.model.dataset, link.where)[0])


def test_a_robust_fit_is_hardly_moved_by_gross_errors():
    dataset = cell()
    pixel = dataset.points.pixel.copy()
    pixel[::16] += 20.0
    spoilt = Preparation.of(replace(dataset, points=replace(dataset.points, pixel=pixel)), 1)
    clean = Preparation.of(dataset, 1)
    moved = Model(dataset).residuals(np.stack([spoilt.calibration.x, clean.calibration.x]))
    assert rms(moved[0] - moved[1]) < 0.5 * rms(moved[1])


def test_an_offset_of_the_last_joint_is_no_gap_since_the_hand_eye_takes_it(clean):
    _, fitted = clean
    (score,) = score_tests(fitted, candidate_effects(["joint_offset:joint_5"], fitted.model.dataset))
    own = np.linalg.norm(score.white)
    assert np.linalg.norm(score.columns) < 0.02 * own


def test_held_out_errors_are_those_of_a_fit_without_the_fold(clean):
    _, fitted = clean
    rows = assign_folds(fitted.model, 0).of_row == 3
    alone = solve(fitted.problem, fitted.problem.parameters.nominal[None], kept=~rows[None])
    want = fitted.problem.plain(alone.x)[0, rows]
    np.testing.assert_allclose(HeldOut(fitted, 0).of(fitted).in_metres[rows], want, atol=3e-6)


def test_a_base_that_was_moved_is_found_though_two_of_three_sockets_do_not_show_how_it_turned():
    effects, noise = {"base_shift:base": 1.6e-4}, Noise(joint_rad=1e-5)
    found = examine(simulate(find_robot("iiwa14"), kind="socket", noise=noise, effects=effects, seed=21).dataset)
    assert [str(one.candidate_effect) for one in found.findings] == ["base_shift at base"]
    assert found.findings[0].probability > 0.9
    assert found.gap.after_m < 0.3 * found.gap.calibrated_m


def test_one_cause_is_a_rival_of_two_that_imitate_it_together():
    effects, noise = {"link_compliance:elbow_joint": 2e-5}, Noise(point_m=5e-5)
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=noise, effects=effects, seed=3)
    _, fitted = begun(made.dataset)
    yielding = ["joint_compliance:shoulder_lift_joint", "joint_compliance:elbow_joint"]
    both = candidate_effects(yielding, fitted.model.dataset)
    (link,) = candidate_effects(list(effects), fitted.model.dataset)
    refits = Refits(fitted, [*both, link])
    final = refits.refit(fitted, score_tests(fitted, both))
    held_out = HeldOut(fitted, 0)
    found = evidence_for(refits, final, both[0], held_out)
    assert found.fits[link].effects == (link,)
    assert found.weights[link] > 0.99


@pytest.mark.parametrize(
    ("effect", "site", "coordinate"),
    [
        ({"encoder_eccentricity:joint_2": 2e-3}, "joint_2", "angle of joint_2"),
        ({"backlash:joint_3": 1.5e-3}, "joint_3", "direction of approach of joint_3"),
        ({"joint_compliance:joint_2": 3e-4}, "joint_2", "gravity torque at joint_2"),
        ({"hand_eye_drift:hand_eye": 1e-3}, "hand_eye", "time"),
        ({"target_warp:target": 5e-4}, "target", "position on the target"),
        ({"latency:timing": 0.02}, "timing", "velocity"),
    ],
)
def test_the_gap_lies_where_it_was_made_and_in_its_coordinate(effect, site, coordinate):
    _, fitted = begun(cell(effect))
    first = localize(fitted)[0]
    assert (first.site, first.coordinate) == (site, coordinate)
    assert first.share > 0.7
    assert first.p_value < 1e-6


def weighed(effect: str, explained: float) -> EffectEvidence:
    (one,) = candidate_effects([effect], cell())
    return EffectEvidence(one, explained, 1.0, 1.0, {one: 1.0}, {}, ())


def test_of_two_effects_at_one_place_the_least_likely_by_chance_counts_in_any_order(clean):
    _, fitted = clean
    weak, strong = weighed("joint_offset:joint_3", 6.5), weighed("backlash:joint_3", 800.0)
    (there,) = explained_sites(fitted, fitted, [weak, strong], 50)
    (back,) = explained_sites(fitted, fitted, [strong, weak], 50)
    assert there == back
    assert there.p_value == pytest.approx(50 * chi2.sf(800.0, 1))


def test_an_explained_place_pays_for_all_candidates_and_its_p_value_is_never_zero(clean):
    _, fitted = clean
    for tried in (1, 60):
        (one,) = explained_sites(fitted, fitted, [weighed("joint_offset:joint_3", 9.0)], tried)
        assert one.p_value == pytest.approx(tried * chi2.sf(9.0, 1))
    (sure,) = explained_sites(fitted, fitted, [weighed("joint_offset:joint_3", 1e6)], 60)
    assert 0.0 < sure.p_value < 1e-300
    assert p_value(1e6, 60) > 0.0


def test_where_nothing_is_left_it_lies_nowhere(clean):
    _, fitted = clean
    assert localize(fitted) == []


def test_poses_before_a_bump_are_no_gross_errors_of_a_tracker():
    world = make(find_robot("ur5"), "base_shift", seed=61002, ranges=Ranges(poses=(30, 45)), tracked=True)
    assert Preparation.of(world.dataset, 1).weighted.outliers.mean() < 0.01


FEW = kinds("joint_offset", "encoder_scale", "laser_roll")


def test_planted_gross_errors_are_marked_and_no_others():
    dataset = cell({"joint_offset:joint_2": 2e-3})
    rng = np.random.default_rng(5)
    spoilt = rng.choice(len(dataset.points), 30, replace=False)
    pixel = dataset.points.pixel.copy()
    pixel[spoilt] += rng.choice([-1, 1], (30, 2)) * rng.uniform(3, 40, (30, 2))
    diagnosis = examine(replace(dataset, points=replace(dataset.points, pixel=pixel)), FEW, seed=0)
    assert set(diagnosis.outliers) == set(spoilt)
    assert [found.candidate_effect.effect.name for found in diagnosis.findings] == ["joint_offset"]


def test_next_poses_keep_the_limits_and_see_the_target():
    dataset = cell({"joint_offset:joint_3": 2e-4}, poses=14)
    diagnosis = examine(dataset, FEW + kinds("link_geometry"), seed=0)
    assert diagnosis.next_poses
    robot = dataset.robot
    for pose in diagnosis.next_poses:
        q = np.array([pose[joint] for joint in robot.joints])
        assert (q >= robot.lower).all()
        assert (q <= robot.upper).all()


def test_an_effect_that_is_taken_out_is_neither_named_nor_a_rival():
    suspects = kinds("backlash", "joint_offset", "encoder_scale", "encoder_eccentricity", "laser_roll")
    diagnosis = examine(cell({"backlash:joint_3": 1.5e-3}), suspects, seed=0, without=("backlash",))
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.where[0].site == "joint_3"
    assert "backlash" not in str(diagnosis_json(diagnosis)["effects"])


def test_to_take_out_what_is_not_there_is_an_error_that_says_what_is():
    with pytest.raises(UsageError, match="backlash"):
        examine(cell(), without=("backlsh",))


@final
@dataclass(frozen=True)
class SaggingShelf(Effect):
    """A joint that errs with the square of its angle: nothing that the library has."""

    name: ClassVar[str] = "sagging_shelf"
    title: ClassVar[str] = "errs with the square of the angle"
    reference: ClassVar[str] = "made up"
    stage: ClassVar[Stage] = Stage.JOINTS
    site: ClassVar[str] = "joint_3"

    sag: Array = parameter(unit="1/rad", bound=0.1, prior_scale=1e-3)

    def apply(self, value: Array, run: Run, /) -> Array:
        bent = np.repeat(value, len(self.sag), axis=0) if len(value) == 1 else value.copy()
        bent[:, :, 2] += self.sag[:, None] * value[:, :, 2] ** 2
        return bent


def test_a_users_own_effect_takes_part_like_ours():
    dataset = cell()
    truth = replace(dataset.poses, q=_sagged(dataset))
    found = robolaser.diagnose(
        replace(dataset, poses=truth),
        effects=[*FEW, *kinds("joint_compliance", "encoder_eccentricity"), SaggingShelf],
        seed=0,
    )
    assert [(one["effect"], one["where"]) for one in found["effects"]] == [("sagging_shelf", "joint_3")]


def _sagged(dataset: Dataset) -> Array:
    """Angles that an encoder with the error would have read, to the second order."""
    q = dataset.poses.q
    read = q.copy()
    read[:, 2] -= 5e-4 * q[:, 2] ** 2
    return read


def test_every_effect_of_the_library_is_somewhere_a_suspect():
    others = [simulate(find_robot("scorbot_er7"), kind=kind, poses=14, seed=1).dataset for kind in ("point", "camera")]
    cells = (cell({"latency:timing": 0.01}), *others)
    assert {one.effect for dataset in cells for one in library(EFFECTS, dataset)} == set(EFFECTS)
