"""A named form against a function of unknown form at the same joint."""

from dataclasses import replace

import numpy as np
import pytest
from worlds import kinds

from robolaser import find_robot
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.candidate_sites import FORCE
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.gaussian_process_basis import rough
from robolaser.diagnosis.local_unknown import local_unknown_chi2, posture_unknown_chi2, probability_of_local_unknown
from robolaser.diagnosis.localization import localize
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.refits import PostureRivals, Refits
from robolaser.diagnosis.sparse_shapes import dents, plays, ramps, sparse_shape_chi2, waves
from robolaser.diagnosis.thresholds import CHI2_OF_UNMODELLED_CAUSE, CHI2_PER_EFFECT, SMALL_SHARE
from robolaser.model.effects.base_shift import BaseShift
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.hand_eye_sag import HandEyeSag
from robolaser.model.effects.link_geometry import LinkGeometry
from robolaser.simulation import CellOptions, simulate
from robolaser.trials.building import Ranges
from robolaser.trials.making import make


def fitted(effects: dict[str, float] | None = None) -> Fit:
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    dataset = simulate(find_robot("scorbot_er7"), poses=40, points=8, noise=noise, effects=effects, seed=3).dataset
    return Preparation.of(dataset, 1).fit(())


def test_a_rough_function_may_have_corners_and_a_constant_slope_between_them() -> None:
    x = np.linspace(-1.0, 2.0, 60)
    step = np.clip((x - 0.5) / 0.6, -0.5, 0.5)
    basis = rough(x)
    assert np.abs(step - basis @ np.linalg.lstsq(basis, step, rcond=None)[0]).max() < 0.05


def unlike(function: np.ndarray, shapes: np.ndarray) -> float:
    """Share of a function's square that is left by the nearest of some shapes, but for a constant."""
    function, shapes = function - function.mean(), shapes - shapes.mean(axis=1, keepdims=True)
    seen = shapes[np.square(shapes).sum(axis=1) > 0]
    cosines = seen @ function / (np.linalg.norm(seen, axis=1) * np.linalg.norm(function))
    return float(1.0 - np.square(cosines).max())


def test_dead_zones_steps_corners_hysteresis_dents_and_oval_discs_are_sparse_shapes_and_other_waves_are_none() -> None:
    rng = np.random.default_rng(3)
    x, places = rng.uniform(-1.0, 2.0, 60), rng.uniform(0.0, 0.4, (80, 2))
    for function in (np.clip((x - 0.5) / 0.3, -0.5, 0.5), np.where(x > 0.21, 1.0, 0.0), np.maximum(x - 0.4, 0.0)):
        assert unlike(function, ramps(x)) < 0.01
    at, followed = x[0], []
    for one in x:
        at = min(max(at, one - 0.31), one + 0.31)
        followed.append(at)
    assert unlike(np.array(followed), plays(x, np.arange(60))) < 0.02
    assert unlike(np.exp(-0.5 * np.square((places - 0.11) / 0.05).sum(axis=1)), np.vstack(list(dents(places)))) < 0.05
    assert unlike(np.sin(2.0 * x + 0.7), waves(x)) < 0.01
    assert unlike(np.sin(6.0 * x), np.vstack([ramps(x), plays(x, np.arange(60)), waves(x)])) > 0.3


def test_where_nothing_is_wrong_no_joint_has_a_function_of_unknown_form() -> None:
    fit = fitted()
    assert all(local_unknown_chi2(fit, joint) < CHI2_PER_EFFECT for joint in ("joint_2", "joint_3", "joint_4"))
    assert posture_unknown_chi2(fit) < CHI2_PER_EFFECT
    assert all(sparse_shape_chi2(fit, site) < CHI2_PER_EFFECT for site in ("joint_2", "joint_3", "joint_4", "target"))


def test_what_is_wrong_at_a_joint_is_a_function_there_and_hardly_elsewhere() -> None:
    fit = fitted({"encoder_eccentricity:joint_3": 0.003})
    assert local_unknown_chi2(fit, "joint_3") > 0.8 * (fit.chi2 - fit.freedoms)
    assert local_unknown_chi2(fit, "joint_5") < local_unknown_chi2(fit, "joint_3")


def test_a_form_that_explains_no_more_than_any_function_of_its_joint_is_as_probable() -> None:
    price = CHI2_PER_EFFECT + CHI2_OF_UNMODELLED_CAUSE
    assert probability_of_local_unknown(100.0, 0.0, 300.0, 200.0 + price) == pytest.approx(0.5)
    assert probability_of_local_unknown(100.0, 0.0, 300.0, 150.0) < 1e-6
    assert probability_of_local_unknown(100.0, 0.0, 300.0, 270.0) > 1.0 - 1e-6


def test_a_form_beside_which_much_is_left_at_its_joint_is_wrong() -> None:
    assert probability_of_local_unknown(100.0, 60.0, 1100.0, 0.0) > 1.0 - 1e-6


def test_a_form_beside_which_a_little_is_left_is_only_a_little_different() -> None:
    left = 60.0
    assert probability_of_local_unknown(0.0, left, 1.01 * left / SMALL_SHARE, 0.0) < 1e-6
    assert probability_of_local_unknown(0.0, 0.0, 3000.0, 3050.0) < 1e-6
    assert probability_of_local_unknown(0.0, 0.0, 2000.0, 2150.0) > 1.0 - 1e-6


@pytest.mark.parametrize(
    ("kind", "seed", "site"), [("dead_zone", 92002, "wrist_2_joint"), ("dented_target", 92036, "target")]
)
def test_a_sparse_shape_that_explains_more_than_a_form_is_the_unknown(kind: str, seed: int, site: str) -> None:
    world = make(find_robot("ur5"), kind, seed=seed, ranges=Ranges(poses=(30, 45), points=(5, 7)))
    found = examine(world.dataset, seed=1)
    assert all(one.probability < 0.9 for one in found.findings)
    assert ([one.name for one in found.classes], found.where[0].site) == (["unknown"], site)


def test_a_joint_that_slipped_is_no_bumped_base() -> None:
    world = make(find_robot("scorbot_er7"), "slipping", seed=43072, ranges=Ranges(poses=(30, 45), points=(5, 7)))
    moving = kinds("base_shift", "base_drift", "mount_shift", "hand_eye_drift", "thermal_drift", "laser_drift")
    found = examine(world.dataset, moving + kinds("joint_offset", "backlash", "encoder_scale"), seed=1)
    assert [one.name for one in found.classes] == ["unknown"]
    assert found.where[0].site == "joint_2"


@pytest.mark.parametrize(("steps", "is_unknown"), [(True, False), (False, True)])
def test_a_base_that_was_moved_once_is_no_base_that_wanders(steps: bool, is_unknown: bool) -> None:
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=2e-5), seed=8).dataset
    share = np.linspace(0.0, 1.0, 40)
    moved = np.where(share > 0.45, 1.0, 0.0) if steps else np.sin(5.0 * share)
    xyz = made.points["xyz"] + 5e-4 * moved[made.points.pose][:, None] * np.array([1.0, 0.5, 0.2])
    shift = CandidateEffect(BaseShift, "base")
    start = Preparation.of(replace(made, points=replace(made.points, xyz=xyz)), 1).fit([shift])
    refits = Refits(start, [shift])
    fit = refits.refit(start, refits.score_tests(start))
    assert (refits.locally_unmodelled(fit, shift) > 0.9) is is_unknown


def test_a_projector_that_turns_in_the_course_of_a_run_is_found_at_the_laser() -> None:
    fit = fitted({"laser_drift": 0.002})
    first = localize(fit)[0]
    assert first.site == "laser"
    assert first.likelihood_ratio > 0.7 * (fit.chi2 - fit.freedoms)


def test_scatter_of_whole_poses_is_no_remainder_of_an_effect() -> None:
    noise, effects = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-4), {"backlash:joint_2": 8e-4}
    stated = Noise(pixel_px=0.1, target_m=3e-5)
    made = simulate(
        find_robot("scorbot_er7"), poses=40, points=8, noise=noise, effects=effects,
        options=CellOptions(stated=stated), seed=3,
    )  # fmt: skip
    start = Preparation.of(made.dataset, 1).fit(())
    start = Fit.of(start.problem.with_noise(start.noise.with_scatter_times(0.01)), start.x)
    refits = Refits(start, made.effects)
    assert refits.locally_unmodelled(refits.refit(start, refits.score_tests(start)), made.effects[0]) == 0.0


def test_an_effect_is_doubted_by_the_weight_of_models_that_do_without_it() -> None:
    sag, turned = CandidateEffect(HandEyeSag, "hand_eye"), CandidateEffect(LinkGeometry, "joint_3")
    rivals = PostureRivals((frozenset({sag, turned}), frozenset({sag}), frozenset()), (0.2, 0.5, 0.2))
    assert rivals.unmodelled([turned]) == pytest.approx(0.7)
    assert rivals.unmodelled([sag]) == rivals.unmodelled([sag, turned]) == pytest.approx(0.2)


def test_a_cable_is_a_force_at_the_flange_and_not_several_effects_with_certainty() -> None:
    cable = make(find_robot("scorbot_er7"), "hose", seed=9018, ranges=Ranges(poses=(24, 28), points=(4, 5)))
    bending = kinds("joint_compliance", "link_compliance", "base_compliance", "hand_eye_sag", "joint_coupling")
    turning = kinds("joint_offset", "encoder_scale", "encoder_eccentricity", "backlash", "settling", "link_geometry")
    diagnosis = examine(cable.dataset, bending + turning, seed=1)
    assert all(found.probability < 0.9 for found in diagnosis.findings)
    assert (diagnosis.where[0].site, diagnosis.where[0].coordinate) == ("joint_4", FORCE)


LINKS = {"link_geometry:wrist_1_joint.turn_x": 0.0116, "link_geometry:shoulder_lift_joint": 6e-4,
         "link_geometry:elbow_joint.z": 7e-4}  # fmt: skip


def test_effects_of_a_form_that_a_joint_does_not_have_do_not_explain_a_gap_though_they_predict_new_poses() -> None:
    noise = Noise(point_m=3e-5, joint_rad=4e-5)
    options = CellOptions(stated=Noise(point_m=3e-5))
    made = simulate("ur5", kind="point", poses=150, points=1, noise=noise, options=options, effects=LINKS, seed=2)
    poses = made.dataset.poses
    of_lift = 1e-3 * (2.0 / np.pi) * np.arcsin(np.sin(1.5 * poses.q[:, [1]])) * (np.arange(6) == 1)
    suspects = kinds("joint_offset", "encoder_scale", "encoder_eccentricity", "transmission_error", "link_geometry")
    found = examine(replace(made.dataset, poses=replace(poses, q=poses.q + of_lift)), suspects, seed=0)
    assert (found.verdict, found.where[0].site) == ("unexplained", "shoulder_lift_joint")
    sure = {one.name: one.site for one in found.classes if one.probability > 0.95}
    assert sure == {"arm_geometry": "", "unknown": "shoulder_lift_joint"}


def test_a_joint_that_another_one_pulls_along_depends_on_it_and_does_not_scatter() -> None:
    """A form that no effect has."""
    cell = simulate("scorbot_er7", kind="point", poses=30, noise=Noise(point_m=2e-5), seed=3).dataset
    read = cell.poses.q.copy()
    read[:, 2] -= 0.002 * read[:, 1] ** 2
    followed = kinds("joint_coupling", "joint_offset", "joint_compliance", "encoder_scale", "backlash", "settling")
    found = examine(replace(cell, poses=replace(cell.poses, q=read)), followed, seed=1)
    assert found.verdict == "unexplained"
    assert found.pose_scatter is None
    assert (found.where[0].site, found.where[0].coordinate) == ("joint_3", "angle of joint_2")


def test_a_base_that_creeps_is_found_at_the_base() -> None:
    """Slowly, which no effect is: it would be as well a first joint that is placed elsewhere and elsewhere."""
    cell = simulate("ur5", kind="point", poses=30, noise=Noise(point_m=2e-5), seed=4).dataset
    creep = np.linspace(0.0, 1.0, 30)[cell.points.pose, None] * [3e-4, 0.0, 2e-4]
    crept = replace(cell, points=replace(cell.points, xyz=cell.points.xyz + creep))
    found = examine(crept, kinds("base_shift", "thermal_drift", "joint_offset"), seed=1)
    assert found.verdict == "unexplained"
    assert (found.where[0].site, found.where[0].coordinate) == ("base", "time")


def test_a_place_is_listed_once() -> None:
    noise = Noise(pixel_px=0.1, target_m=2e-5)
    made = simulate(find_robot("ur5e"), poses=36, noise=noise, effects={"radial_distortion": 2e8}, seed=5)
    suspects = kinds("tangential_distortion", "stripe_bias", "laser_roll", "laser_curvature", "joint_offset")
    places = [(one.site, one.coordinate) for one in examine(made.dataset, suspects, seed=1).where]
    assert places[0] == ("camera", "image position")
    assert len(set(places)) == len(places)


SLIP_RAD, TURN_PX = 6e-4, np.array([0.6, 0.5])


def slipped(site: str) -> Dataset:
    """Poses in which an encoder, the bracket, the load or the base is another one from the middle of the run on.

    A bracket that turns a little shifts all corners alike; two joints yield to a load.
    """
    shift = {"base_shift:base.x": 2e-4, "base_shift:base.y": -3e-4, "base_shift:base.turn_y": 3e-4}
    noise, effects = Noise(pixel_px=0.1, repeatability_m=1e-5), shift if site == "base" else None
    dataset = simulate("ur5", kind="camera", poses=40, noise=noise, effects=effects, seed=7).dataset
    q, pixel = dataset.poses.q.copy(), dataset.points.pixel.copy()
    late = len(q) // 2
    if site == "hand_eye":
        pixel += np.where(dataset.points.pose[:, None] >= late, TURN_PX, 0.0)
    elif site == "payload":
        q[late:, 1:3] += 1e-5 * 9.81 * dataset.robot.jacobian(q[None])[0, late:, 2, 1:3]
    elif site != "base":
        q[late:, dataset.robot.joints.index(site)] += SLIP_RAD
    return replace(dataset, poses=replace(dataset.poses, q=q), points=replace(dataset.points, pixel=pixel))


@pytest.mark.parametrize("site", ["shoulder_lift_joint", "hand_eye", "payload", "base"])
def test_what_slips_at_a_moment_explains_what_another_shift_then_would_and_not_what_a_base_does(site: str) -> None:
    fit = Preparation.of(slipped(site), 1).fit(())
    assert ((sparse_shape_chi2(fit, "base") / (fit.chi2 - fit.freedoms)) > 0.9) == (site != "base")
