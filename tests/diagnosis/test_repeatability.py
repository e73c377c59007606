"""Whole poses scatter: that is noise of every sensor, and no cause passes for it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from cells import on_flange_poses
from worlds import kinds

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.gross_errors import rows_sentence
from robolaser.diagnosis.noise_remarks import noise_remarks
from robolaser.diagnosis.pose_noise import explained
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.profile_likelihood import profile
from robolaser.diagnosis.score_tests import library
from robolaser.estimation.noise_estimate import Excess
from robolaser.model.effects.effect import Effect
from robolaser.model.effects.link_geometry import LinkGeometry
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

STATED = {"stripe": Noise(pixel_px=0.1, target_m=3e-5), "point": Noise(point_m=2e-5)}
JOINT_RAD = 1e-4
OF_JOINTS = kinds("joint_offset", "backlash", "settling", "encoder_scale", "encoder_eccentricity", "joint_compliance")
GEARS = kinds("transmission_error")


@cache
def diagnosed(kind: str, *, effect: str = "", size: float = 0.0, joint_rad: float = JOINT_RAD) -> Diagnosis:
    dataset = simulate(
        find_robot("scorbot_er7"), kind=kind, poses=40, points=8 if kind == "stripe" else 3,
        noise=replace(STATED[kind], joint_rad=joint_rad), effects={effect: size} if effect else None,
        options=CellOptions(stated=STATED[kind]), seed=4,
    ).dataset  # fmt: skip
    return examine(dataset, OF_JOINTS + GEARS, seed=0)


def test_a_gain_counts_as_the_logarithm_of_what_it_leaves_of_the_scatter():
    rng, freedoms = np.random.default_rng(0), 30
    squares = rng.chisquare(1, freedoms)
    squares *= freedoms / squares.sum()
    large = np.full(freedoms, 1e8)  # nothing but scatter
    for gain in (5.0, 60.0, 3000.0):
        factor, change = profile(squares * (1.0 + gain / freedoms), large, 1.0)
        assert factor == pytest.approx(np.sqrt(1.0 + gain / freedoms), rel=1e-2)
        assert freedoms + gain + change == pytest.approx(freedoms + freedoms * np.log1p(gain / freedoms), abs=0.1)


def test_scatter_as_assumed_changes_nothing():
    factor, change = profile(np.full(50, 1.0), np.full(50, 3.0), 1.0)
    assert factor == pytest.approx(1.0, abs=0.01)
    assert change == pytest.approx(0.0, abs=1e-2)


def test_without_scatter_the_likelihood_is_that_of_chi_squared():
    assert profile(np.zeros(0), np.zeros(0), 1.0) == (1.0, 0.0)


@pytest.mark.parametrize("kind", ["stripe", "point"])
def test_scatter_alone_is_no_gap(kind):
    diagnosis = diagnosed(kind)
    assert diagnosis.verdict == "no_gap"
    assert not diagnosis.findings
    assert diagnosis.noise["joint"].value == pytest.approx(JOINT_RAD, rel=0.3)


def tracked(
    arm: str, poses: int, off: Callable[[Array], Array], suspects: Sequence[type[Effect]], **stated: float
) -> Diagnosis:
    """Of an arm before a tracker whose readings q (n, j) are off by so much."""
    noise = Noise(point_m=3e-5, **stated)
    dataset = simulate(find_robot(arm), kind="point", poses=poses, noise=noise, seed=1).dataset
    q = dataset.poses.q
    return examine(replace(dataset, poses=replace(dataset.poses, q=q + off(q))), suspects, seed=0)


def chance(rad: float) -> Callable[[Array], Array]:
    return lambda q: np.random.default_rng(1).normal(0.0, rad, len(q))[:, None] * (np.arange(q.shape[1]) == 1)


REPEATS = {"joint_rad": 1e-5, "repeatability_m": 5e-5}


def test_a_joint_that_scatters_over_ten_poses_is_no_gear_of_some_frequency():
    found = tracked("ur5", 10, chance(7e-4), OF_JOINTS + GEARS, **REPEATS)
    assert not found.findings
    assert found.pose_scatter.where == "shoulder_lift_joint"


@pytest.mark.parametrize("edge", [0.1, 10.0])
def test_a_joint_with_a_wave_of_several_periods_does_not_scatter(edge):
    def wave(q: Array) -> Array:
        return 2e-3 * np.tanh(edge * np.sin(3.0 * q)) / np.tanh(edge) * (np.arange(q.shape[1]) == 1)

    found = tracked("ur5", 60, wave, OF_JOINTS)
    assert (found.verdict, found.pose_scatter) == ("unexplained", None)


def off_at(joint: int, size: float) -> Callable[[Array], Array]:
    return lambda q: size * np.sin(2.3 * q[:, [1]] + q[:, [2]]) * (np.arange(q.shape[1]) == joint)


@pytest.mark.parametrize(("joint", "known"), [(1, {"shoulder_lift_joint"}), (3, {"wrist_1_joint"})])
def test_what_else_is_wrong_with_an_arm_whose_joint_scatters_is_located_beside_the_scatter(joint, known):
    found = tracked("ur5", 60, lambda q: chance(3e-3)(q) + off_at(joint, 3e-3)(q), OF_JOINTS)
    assert found.pose_scatter.where == "shoulder_lift_joint"
    assert {one.site for one in found.classes if one.name == "unknown" and one.probability > 0.9} <= known


def test_one_joint_that_scatters_no_more_than_joints_may_is_no_gap():
    assert tracked("ur5", 25, chance(3e-4), OF_JOINTS + GEARS).verdict == "no_gap"


def test_two_joints_that_turn_by_the_sum_of_their_angles_do_not_scatter():
    def by_one_wheel(q: Array) -> Array:
        return 4e-3 * np.sin(q[:, [3]] + q[:, [4]]) * np.isin(np.arange(q.shape[1]), (3, 4))

    suspects = GEARS + kinds("joint_offset", "joint_coupling", "encoder_eccentricity", "joint_compliance")
    found = tracked("scorbot_er7", 36, by_one_wheel, suspects, **REPEATS)
    assert found.pose_scatter is None
    assert {place.site for place in found.where} <= {"joint_4", "joint_5"}


def test_a_joint_that_skips_neither_scatters_nor_has_a_wrong_zero():
    def skipping(q: Array) -> Array:
        return 1e-3 * (q > np.median(q, axis=0)) * (np.arange(q.shape[1]) == 1)

    found = tracked("ur5", 25, skipping, OF_JOINTS + GEARS, **REPEATS)
    assert found.pose_scatter is None
    assert not found.findings
    assert [(one.name, one.site) for one in found.classes] == [("unknown", "shoulder_lift_joint")]


def test_scatter_counts_in_the_noise_floor():
    still, shaken = diagnosed("point", joint_rad=1e-6), diagnosed("point")
    assert still.gap.noise_floor_m == pytest.approx(np.sqrt(3) * 2e-5, rel=0.15)
    assert shaken.gap.noise_floor_m > 1.5 * still.gap.noise_floor_m
    assert shaken.gap.after_m == pytest.approx(shaken.gap.noise_floor_m, rel=0.15)


@pytest.mark.parametrize(
    ("kind", "effect", "size"), [("stripe", "backlash:joint_3", 2e-3), ("point", "joint_compliance:joint_2", 1e-4)]
)
def test_the_scatter_is_found_beside_an_effect_and_does_not_swallow_it(kind, effect, size):
    diagnosis = diagnosed(kind, effect=effect, size=size)
    assert [str(found.candidate_effect) for found in diagnosis.findings] == [effect.replace(":", " at ")]
    assert diagnosis.findings[0].probability > 0.9
    assert diagnosis.noise["joint"].value == pytest.approx(JOINT_RAD, rel=0.3)


def test_a_smooth_cause_that_the_library_lacks_is_not_swallowed():
    dataset = simulate(
        find_robot("scorbot_er7"), poses=40, points=8, noise=STATED["stripe"],
        effects={"joint_compliance:joint_2": 1e-4},
    ).dataset  # fmt: skip
    diagnosis = examine(dataset, effects=[], seed=0)
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.where[0].site == "joint_2"


def test_stated_noise_that_the_rows_of_a_pose_contradict_gives_way_to_the_larger():
    noise = Noise(pixel_px=0.1, target_m=6e-5)
    dataset = simulate(
        find_robot("ur5"), poses=30, points=10, noise=noise, options=CellOptions(repeats=2), seed=5
    ).dataset
    suspects = kinds("joint_offset", "target_warp", "radial_distortion")
    diagnosis = examine(replace(dataset, noise=Noise(pixel_px=0.04, target_m=2.4e-5)), suspects, seed=0)
    assert diagnosis.verdict == "no_gap"
    assert diagnosis.noise["pixel"].value == pytest.approx(0.1, rel=0.1)
    assert diagnosis.noise["target"].value == pytest.approx(6e-5, rel=0.15)


def test_poses_of_one_measurement_each_may_scatter_beside_stated_noise():
    """As poses of several measurements may: what scatters may be the measuring system's whole body, or the flange."""
    stated = Noise(point_m=2e-5, angle_rad=2e-5, joint_rad=1e-5)
    dataset = simulate(
        find_robot("ur5"), kind="pose", poses=40, noise=replace(stated, joint_rad=4e-5),
        options=CellOptions(stated=stated), seed=1,
    ).dataset  # fmt: skip
    with_joints, without = (examine(one, effects=[], seed=0) for one in (dataset, on_flange_poses(dataset)))
    assert with_joints.verdict == without.verdict == "no_gap"
    assert with_joints.noise["probe_turn"].origin == without.noise["flange_turn"].origin == "estimated"


def test_noise_of_a_camera_on_measured_flange_poses_is_said_to_be_from_its_repeats():
    cell = simulate(
        find_robot("ur5"), kind="camera", poses=12, noise=Noise(pixel_px=0.1),
        options=CellOptions(repeats=3, stated=Noise()), seed=1,
    ).dataset  # fmt: skip
    noise = examine(on_flange_poses(cell), effects=[], seed=0).noise
    assert {name: one.origin for name, one in noise.items()} == {
        "pixel": "repeats", "flange": "estimated", "flange_turn": "estimated",
    }  # fmt: skip


@pytest.mark.parametrize(("times", "fits"), [(1.0, True), (2.0, True), (2.0, False), (5.0, False)])
def test_noise_is_said_to_be_larger_than_stated_only_where_the_verdict_took_it_so(times, fits):
    made = simulate(find_robot("ur5e"), kind="point", poses=12, noise=Noise(point_m=1e-4), seed=3).dataset
    final = examine(made, effects=[], seed=0).weighed.final
    larger = replace(final.noise.at({"point": times * 1e-4}), origin={"point": "estimated"})
    fitted = Fit(final.problem.with_noise(replace(final.noise.at({"point": 9e-4}), origin=larger.origin)), final.x)
    remarks = [text for text in noise_remarks(fitted, larger, made, fits=fits) if "larger one is used" in text]
    assert len(remarks) == (times == 2.0)
    odd = rows_sentence(fitted, larger, "explained" if fits else "unexplained", made, np.array([], np.int64))
    assert ("Rows scatter 5 times" in odd) == (times == 5.0)


@pytest.mark.parametrize(("times", "verdict"), [(2.5, "no_gap"), (10, "unexplained")])
def test_stated_noise_that_is_far_too_small_makes_no_gross_errors(times, verdict):
    """Up to a few times it is taken for a slip of the pen; beyond that, something else may move the rows."""
    dataset = simulate(
        find_robot("scorbot_er7"), poses=30, points=8, noise=Noise(pixel_px=0.1),
        options=CellOptions(stated=Noise(pixel_px=0.1 / times)), seed=3,
    ).dataset  # fmt: skip
    diagnosis = examine(dataset, effects=[], seed=1)
    assert diagnosis.verdict == verdict
    assert ("times as much as [noise] states: correct it" in diagnosis.sentence) == (times == 10)
    assert "not random" not in diagnosis.sentence
    assert not len(diagnosis.outliers)
    assert diagnosis.gap.calibrated_m == diagnosis.gap.after_m
    assert diagnosis.noise["pixel"].value == pytest.approx(0.1, rel=0.1)
    assert any(f"pixel_px = {0.1 / times:.2g}" in remark for remark in diagnosis.noise_remarks)


def test_noise_is_contradicted_by_a_quarter_and_four_standard_deviations():
    assert Excess.of(400.0 * 1.3**2, 400.0).is_above
    assert not Excess.of(400.0 * 1.2**2, 400.0).is_above
    assert not Excess.of(10.0 * 1.3**2, 10.0).is_above
    assert Excess.of(400.0 / 1.3**2, 400.0).is_below


def test_chi_squared_of_any_freedoms_has_the_normal_deviate_of_its_quantiles():
    assert Excess.of(chi2_quantile := 149.449, 100.0).sigma == pytest.approx(3.09, abs=0.02), chi2_quantile


def test_an_arm_that_shrinks_with_its_sockets_explains_no_scatter():
    effects = {"link_geometry:joint_3": 0.004}
    dataset = simulate(
        find_robot("scorbot_er7"), kind="socket", effects=effects, noise=Noise(joint_rad=1e-4),
        options=CellOptions(stated=Noise()), seed=4,
    ).dataset  # fmt: skip
    start = Preparation.of(dataset, 1).fit([])
    arm = start.model.with_effects(tuple(library([LinkGeometry], dataset)))
    problem = problem_of(arm, start.noise, start.sensor)
    fit = Fit(problem, np.r_[start.x, np.zeros(len(problem.parameters) - len(start.x))])
    every = fit.noise.correlate(fit.at.Q[: len(fit.at.white)].T).T
    assert left_by(every, fit.at.plain) < 1e-6
    assert left_by(explained(fit, smooth=False), fit.at.plain) > 1e-2


def left_by(columns: Array, residuals: Array) -> float:
    """Share of residuals that columns do not explain."""
    e = residuals.ravel()
    U, s, _ = np.linalg.svd(columns / np.linalg.norm(columns, axis=0), full_matrices=False)
    U = U[:, s > 1e-9 * s[0]]
    return float(np.linalg.norm(e - U @ (U.T @ e)) / np.linalg.norm(e))


def test_coarse_readings_are_no_gap_where_their_step_is_stated():
    step = 4e-3
    made = simulate(
        find_robot("ur5"), kind="point", poses=50, noise=Noise(point_m=3e-5, joint_rad=step / 12.0**0.5),
        options=CellOptions(stated=Noise(point_m=3e-5, joint_step_rad=step)), seed=2,
    )  # fmt: skip
    assert examine(made.dataset, OF_JOINTS, seed=0).verdict == "no_gap"
    unsaid = replace(made.dataset, noise=Noise(point_m=3e-5))
    assert examine(unsaid, OF_JOINTS, seed=0).verdict == "unexplained"
