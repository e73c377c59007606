"""Points that are far off are gross errors for certain only where the others of their pose are not."""

from dataclasses import replace

import numpy as np
import pytest
from several import two_trackers
from worlds import kinds

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.findings import gap_of
from robolaser.diagnosis.gross_errors import gross_sentence, outlying_poses, probability
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.estimation.certainty import CERTAIN
from robolaser.estimation.noise_weighted_fit import fit_by_noise
from robolaser.model.forward_model import Model
from robolaser.report.diagnosis.advice import to_do
from robolaser.simulation import CellOptions, simulate

FEW = kinds("joint_offset", "backlash", "base_shift", "thermal_drift", "tool_sag")


@pytest.fixture(scope="module")
def sound() -> Dataset:
    return simulate("ur5", kind="point", poses=40, noise=Noise(point_m=3e-5), seed=1).dataset


def off(dataset: Dataset, rows: np.ndarray) -> Dataset:
    xyz = np.array(dataset.points.xyz)
    xyz[rows] += 2e-3
    return replace(dataset, points=replace(dataset.points, xyz=xyz))


def test_an_arm_that_scatters_more_than_its_tracker_has_no_gross_errors_where_it_is_stretched() -> None:
    stated, scatter = Noise(point_m=2e-5), Noise(point_m=2e-5, joint_rad=4e-4)
    options = CellOptions(stated=stated)
    made = simulate("scorbot_er7", kind="point", poses=60, points=3, noise=scatter, options=options, seed=7)
    assert not len(examine(made.dataset, [], seed=0).outliers)


def test_single_points_are_gross_errors_for_certain(sound: Dataset) -> None:
    found = examine(off(sound, np.flatnonzero(sound.points.pose < 3)[::3]), FEW, seed=0)
    (told,) = [one for one in diagnosis_json(found)["effects"] if one["effect"] == "outliers"]
    assert told["probability"] == 1.0
    assert "3 rows of points.csv are gross errors" in found.sentence


def test_a_pose_that_is_off_as_a_whole_is_likely_a_gross_error_and_is_named(sound: Dataset) -> None:
    found = examine(off(sound, np.flatnonzero(sound.points.pose == 7)), FEW, seed=0)
    (told,) = [one for one in diagnosis_json(found)["effects"] if one["effect"] == "outliers"]
    assert 0.5 < told["probability"] < CERTAIN
    assert f"All points of pose {sound.poses.names[7]} are off together" in found.sentence
    assert any(f"measurements of pose {sound.poses.names[7]};" in one for one in to_do(found))


def test_few_scattered_points_and_whole_poses_are_gross_errors(sound: Dataset) -> None:
    scattered = np.random.default_rng(4).random(len(sound.points)) < 0.05
    rows = np.flatnonzero(scattered | np.isin(sound.points.pose, [7, 30]))
    found = examine(off(sound, rows), FEW, seed=0)
    assert found.verdict == "no_gap"
    assert found.outliers.tolist() == rows.tolist()


def test_a_reflector_that_slips_half_way_is_no_gross_error(sound: Dataset) -> None:
    rows = np.flatnonzero((sound.points.number == 1) & (sound.points.pose >= 20))
    found = examine(off(sound, rows), FEW, seed=0)
    assert found.verdict == "unexplained"
    assert not len(found.outliers)


def test_a_reflector_that_slipped_on_the_flange_is_named_though_noise_of_rows_could_be_as_large() -> None:
    made = simulate("ur5", kind="point", poses=40, points=3, noise=Noise(point_m=3e-5), seed=2).dataset
    rows = np.flatnonzero((made.points.number == 1) & (made.points.pose >= 17))
    slip = (made.flange()[:, :3, :3] @ [3e-3, 0.0, 1e-3])[made.points.pose[rows]]
    xyz = np.array(made.points.xyz)
    xyz[rows] += slip
    found = examine(replace(made, points=replace(made.points, xyz=xyz)), FEW, seed=0)
    assert (found.verdict, len(found.outliers)) == ("unexplained", 0)
    assert "Nearly all of the error is in the rows of point 1: has it moved?" in found.sentence


def test_of_several_sensors_the_file_is_named_that_holds_the_rows() -> None:
    both = two_trackers(4)
    first = np.array([sensor.rows[0] for sensor in both.sensors])
    assert "One row of right.csv is a gross error" in gross_sentence(both, first[1:])
    assert "2 rows of left.csv and right.csv are gross errors" in gross_sentence(both, first)


def test_nothing_is_said_without_gross_errors(sound: Dataset) -> None:
    none = np.zeros(0, dtype=np.int64)
    assert gross_sentence(sound, none) == ""
    assert outlying_poses(sound, none) == ()
    assert probability(sound, none, "no_gap") == 1.0


def test_beside_what_is_unexplained_no_gross_error_is_certain(sound: Dataset) -> None:
    first = np.zeros(1, dtype=np.int64)
    assert probability(sound, first, "explained") == 1.0
    assert 0.5 < probability(sound, first, "unexplained") < CERTAIN


@pytest.mark.parametrize(("pose", "image"), [(5, 12), (1, 3), (10, 8)])
def test_an_image_of_another_pose_is_left_out_whole(pose: int, image: int) -> None:
    made = simulate("ur5", kind="camera", poses=28, points=15, noise=Noise(pixel_px=0.15), seed=2).dataset
    elsewhere = made.points.pose == pose
    pixel = made.points["pixel"].copy()
    pixel[elsewhere] = made.points["pixel"][made.points.pose == image]
    wrong = replace(made, points=replace(made.points, pixel=pixel))
    fit = fit_by_noise(Model(wrong), calibrate(made, Plan(weights="noise", seed=0)).x, seed=0)
    np.testing.assert_array_equal(fit.outliers, elsewhere)


def test_the_gap_and_its_interval_are_of_the_rows_that_a_search_keeps(sound: Dataset) -> None:
    preparation = Preparation.of(sound, 0)
    _, fewer = preparation.without(np.arange(len(sound.points)) == len(sound.points) - 1, preparation.fit([]))
    held_out = HeldOut(fewer, 0, preparation.calibration)
    gap = gap_of(fewer, fewer, fewer.noise, held_out, 0)
    assert gap.after_m == pytest.approx(rms(held_out.of(fewer).in_metres))
    assert gap.after_ci95_m[0] < gap.after_m < gap.after_ci95_m[1]
    assert gap.calibrated_m == preparation.calibration.held_out_rms_m != gap.after_m


def test_a_known_distance_that_is_wrong_is_named() -> None:
    sound = simulate("ur5", kind="socket", poses=40, noise=Noise(joint_rad=5e-5, distance_m=2e-5), seed=1).dataset
    names, known = (f"plate.{name}" for name in sound.points.names), sound.distances_m
    made = replace(
        sound,
        points=replace(sound.points, names=tuple(names)),
        distances_m=tuple((f"plate.{one}", f"plate.{other}", length) for one, other, length in known),
    )
    (one, other, length), *rest = made.distances_m
    found = examine(replace(made, distances_m=((one, other, length - 1e-3), *rest)), effects=[], seed=0)
    assert found.wrong_input is not None
    ((name, would_be),) = found.wrong_input.parameters.items()
    assert (found.verdict, found.wrong_input.where, name) == ("explained", "target", f"socket.{one}-{other}.distance")
    assert would_be.std is not None
    assert would_be.value == pytest.approx(length, abs=4.0 * would_be.std)
    assert "Measure it again, and correct it under [target], distances_m." in found.sentence
    assert examine(made, effects=[], seed=0).verdict == "no_gap"


def test_a_known_distance_is_no_cause_of_an_error_that_remains_without_it() -> None:
    made = simulate("ur5", kind="socket", poses=40, effects={"joint_offset:elbow_joint": 5e-3}, seed=1).dataset
    (one, other, length), *rest = made.distances_m
    found = examine(replace(made, distances_m=((one, other, length - 5e-3), *rest)), effects=[], seed=0)
    assert (found.verdict, found.wrong_input) == ("unexplained", None)
    assert f"The known distance between {one} and {other} is" in found.sentence
    assert "shorter than in the model: measure it again." in found.sentence
    assert any(advice.startswith("Measure the known distance") for advice in to_do(found))


@pytest.mark.parametrize("wrong", [1, 2])
def test_known_distances_that_agree_show_the_arm_s_scale_and_one_alone_is_measured_again(wrong: int) -> None:
    made = simulate("ur5e", kind="socket", poses=60, noise=Noise(joint_rad=1e-5), seed=1).dataset
    known = [(*ends, length * (1.001 if i < wrong else 1.0)) for i, (*ends, length) in enumerate(made.distances_m)]
    found = examine(
        replace(made, distances_m=tuple(known)), kinds("arm_scale", "link_geometry", "joint_offset"), seed=1
    )
    named = [str(one.candidate_effect) for one in found.findings if one.probability > 0.9]
    assert named == (["arm_scale at base"] if wrong == 2 else [])
    assert ("Measure it again" in found.sentence) == (wrong == 1)
    assert any(advice.startswith("Correct the data set first") for advice in to_do(found)) == (wrong == 1)
    assert not any(advice.startswith("Nothing needs repair") for advice in to_do(found))


def test_rows_that_scatter_far_more_than_is_stated_are_no_noise_and_it_is_said_why(sound: Dataset) -> None:
    found = examine(replace(sound, noise=Noise(point_m=2e-6)), effects=[], seed=0)
    assert found.verdict == "unexplained"
    assert "Rows scatter 15 times as much as [noise] states" in found.sentence
