"""Lenses that breathe, prints that are longer one way, holders that bend, arms that grew: in other forms than ours."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_false_explanation import breathing
from worlds import kinds

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.result import Diagnosis
from robolaser.geometry.rigid_motion import from_angles
from robolaser.model.effects import EFFECTS
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, Simulated, simulate

NOISE, UNPLACED = Noise(pixel_px=0.1), CellOptions(placed=False)
(DRIFT,) = kinds("camera_drift")
IN_IMAGES = kinds(
    "focus_breathing", "radial_distortion", "hand_eye_sag", "joint_offset", "target_scale", "target_stretch",
    "target_warp", "arm_scale",
)  # fmt: skip
OF_LENGTHS = kinds("arm_scale", "tracker_scale", "link_geometry", "joint_offset", "joint_compliance")
IN_TIME = kinds("camera_drift", "hand_eye_drift", "base_shift", "thermal_drift", "focus_breathing")


def names(found: Diagnosis) -> list[str]:
    return [one.candidate_effect.effect.name for one in found.findings]


def test_a_lens_that_breathes_by_the_square_of_the_distance_is_named():
    found = examine(breathing(0.02), IN_IMAGES, seed=0)
    assert (found.verdict, names(found)) == ("explained", ["focus_breathing"])
    assert found.findings[0].probability > 0.95


def stretched(along_x: float, along_y: float) -> Dataset:
    """What images show of a print with a scale of its own along each side."""
    made = simulate(find_robot("ur5"), kind="camera", poses=16, points=12, noise=NOISE, options=UNPLACED, seed=6)
    stated = made.dataset.points["xyz"] / np.array([1.0 + along_x, 1.0 + along_y, 1.0])
    return replace(made.dataset, points=replace(made.dataset.points, xyz=stated))


def test_a_print_that_is_longer_along_one_side_is_named():
    found = examine(stretched(0.0, 0.004), IN_IMAGES, seed=0)
    assert (found.verdict, names(found)) == ("explained", ["target_stretch"])


def test_of_a_print_with_two_scales_what_they_have_in_common_may_be_the_arms():
    found = examine(stretched(0.001, 0.003), IN_IMAGES, seed=0)
    sure = [one.candidate_effect.effect.name for one in found.findings if one.probability > 0.95]
    assert (found.verdict, sure) == ("explained", ["target_stretch"])
    assert set(names(found)) <= {"target_stretch", "target_scale", "arm_scale"}


def held_by_a_cantilever(size: float, axis: np.ndarray, seed: int = 5) -> Dataset:
    """Points of a reflector whose holder bends across its axis."""
    made = simulate(find_robot("ur5"), kind="point", poses=30, noise=Noise(point_m=2e-5), seed=seed)
    down = np.einsum("nij,i->nj", made.dataset.flange()[:, :3, :3], np.array([0.0, 0.0, -1.0]))
    return held_elsewhere(made, size * (down - (down @ axis)[:, None] * axis))


def held_elsewhere(made: Simulated, by: np.ndarray) -> Dataset:
    """Points of reflectors that are shifted in the flange's frame at each pose, (n, 3) [m]."""
    in_base = np.einsum("nij,nj->ni", made.dataset.flange()[:, :3, :3], by)[made.dataset.points.pose]
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    return replace(made.dataset, points=replace(made.dataset.points, xyz=made.dataset.points["xyz"] + in_base @ R.T))


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, 0.8, 0.0)])
def test_a_holder_that_bends_across_its_axis_is_named(axis):
    others = kinds("joint_compliance", "link_compliance", "base_compliance", "joint_offset")
    found = examine(held_by_a_cantilever(3e-4, np.array(axis)), kinds("tool_sag") + others, seed=0)
    assert (found.verdict, names(found)) == ("explained", ["tool_sag"])


def test_without_it_in_the_library_a_holder_that_bends_is_no_certain_cause_of_another_class():
    others = [one for one in EFFECTS if one.name != "tool_sag"]
    found = examine(held_by_a_cantilever(3e-4, np.array([0.6, 0.8, 0.0])), effects=others, seed=0)
    assert found.verdict == "unexplained" or all(one.probability < 0.95 for one in found.findings)


OF_HOLDERS = kinds(
    "mount_shift", "tool_drift", "tool_sag", "base_shift", "base_drift", "thermal_drift", "joint_offset", "settling"
)


def before_a_tripod(size: float) -> Dataset:
    """Points of a tracker whose stand gives way with the logarithm of time."""
    made = simulate(find_robot("ur5"), kind="point", poses=60, points=1, noise=Noise(point_m=3e-5), seed=5).dataset
    share = np.log1p(2.0 * np.argsort(np.argsort(made.poses.time_s)) / 59) / np.log(3.0)
    crept = size * share[made.points.pose][:, None] * np.array([0.64, -0.6, 0.48])
    return replace(made, points=replace(made.points, xyz=made.points["xyz"] + crept))


@pytest.mark.parametrize("size", [3e-4, 5e-3])
def test_a_trackers_stand_that_creeps_is_at_the_base_and_nothing_of_the_arm(size):
    found = examine(before_a_tripod(size), OF_HOLDERS, seed=0)
    assert {one.name for one in found.classes if one.probability > 0.5} <= {"base", "unknown"}
    assert found.where[0].site == "base"


def test_a_large_creep_of_a_trackers_stand_is_named():
    found = examine(before_a_tripod(5e-3), OF_HOLDERS, seed=0)
    assert (found.verdict, names(found)) == ("explained", ["base_drift"])


def held_loosely(way: Callable[[np.ndarray], np.ndarray]) -> Dataset:
    """Points of reflectors whose holder moves with the run's progress, as a share of 0.4 mm."""
    made = simulate(find_robot("ur5"), kind="point", poses=30, points=3, noise=Noise(point_m=2e-5), seed=5)
    share = way(np.argsort(np.argsort(made.dataset.poses.time_s)) / 29)
    return held_elsewhere(made, 4e-4 * share[:, None] * np.array([0.6, -0.48, 0.64]))


MOVES = {"mount_shift": lambda t: (t > 0.4) * (0.95 + 0.05 * t), "tool_drift": lambda t: np.log1p(6.0 * t)}
"""A slip after which the holder creeps on, and a creep that slows down with the logarithm of time."""


@pytest.mark.parametrize("effect", MOVES)
def test_a_holder_that_slips_or_creeps_is_named_and_is_no_base_that_moved(effect):
    found = examine(held_loosely(MOVES[effect]), OF_HOLDERS, seed=0)
    assert (found.verdict, names(found)) == ("explained", [effect])
    assert {one.name: one.probability for one in found.classes}["mount"] > 0.99


def test_without_it_in_the_library_a_holder_that_slips_is_an_unknown_cause_at_the_tool():
    found = examine(held_loosely(MOVES["mount_shift"]), OF_HOLDERS[1:], seed=0)
    assert (found.verdict, found.where[0].site) == ("unexplained", "tool")


def grown(share: float, **known: object) -> Dataset:
    """A tracker's data of an arm whose lengths have all grown, the way to the flange as well."""
    made = simulate(find_robot("ur5"), kind="point", poses=30, points=3, noise=Noise(point_m=1e-5), seed=7)
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    flange = made.dataset.flange()[made.dataset.points.pose, :3, 3]
    points = replace(made.dataset.points, xyz=made.dataset.points["xyz"] + share * flange @ R.T)
    return replace(made.dataset, points=points, **known)


def test_an_arm_that_grew_is_certainly_a_matter_of_lengths_and_not_certainly_the_arms():
    found = examine(grown(1e-3), OF_LENGTHS, seed=0)
    assert found.verdict == "explained"
    assert set(names(found)) <= {"arm_scale", "tracker_scale"}
    assert {one.name: one.probability for one in found.classes}["measuring_system"] > 0.99


def test_known_distances_between_reflectors_tell_it_from_the_trackers_scale():
    points = grown(1e-3).points
    first = points["xyz"][points.pose == 0]
    near = points.names[:3]
    known = tuple((near[i], near[j], float(np.linalg.norm(first[i] - first[j]))) for i, j in ((0, 1), (0, 2), (1, 2)))
    assert names(examine(grown(1e-3, distances_m=known), OF_LENGTHS, seed=0)) == ["arm_scale"]


def seen_by(bent: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Dataset:
    """Points that a tracker sees elsewhere: by where they are in its frame, and which way is up there."""
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=2e-5), seed=8)
    up = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))[:, 2]
    xyz = made.dataset.points["xyz"]
    return replace(made.dataset, points=replace(made.dataset.points, xyz=xyz + bent(xyz, up)))


def refracted(xyz: np.ndarray, up: np.ndarray) -> np.ndarray:
    return 4e-5 * np.outer((xyz**2).sum(axis=1), up)


def longer_across(xyz: np.ndarray, up: np.ndarray) -> np.ndarray:
    across = np.cross(up, [1.0, 0.0, 0.0])
    return 2e-3 * np.outer(xyz @ across, across)


@pytest.mark.parametrize("bent", [refracted, longer_across])
def test_a_measuring_system_that_distorts_space_is_an_unknown_cause_there_and_no_error_of_the_arm(bent):
    found = examine(seen_by(bent), seed=0)
    assert (found.verdict, found.where[0].site) == ("unexplained", "measuring_system")
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


def test_a_trackers_scale_that_drifts_is_an_unknown_cause_there_and_no_link_that_warms_up():
    """Its stand may seem to creep, too."""
    made = simulate(find_robot("panda"), kind="point", poses=40, noise=Noise(point_m=2e-5), seed=3).dataset
    longer = 2e-4 * np.log1p(20.0 * made.points.pose / len(made.poses))
    xyz = made.points["xyz"] * (1.0 + longer[:, None])
    alike = kinds("tracker_scale", "arm_scale", "thermal_drift", "base_drift", "tool_drift")
    found = examine(replace(made, points=replace(made.points, xyz=xyz)), alike, seed=0)
    assert (found.where[0].site, found.where[0].coordinate) == ("measuring_system", "time")
    assert {one.name for one in found.classes if one.probability > 0.5} - {"base"} == {"unknown"}


def test_a_reflector_that_is_seen_from_the_side_is_an_unknown_cause_of_the_measuring_system_and_no_scatter():
    made = simulate(find_robot("panda"), kind="point", poses=50, noise=Noise(point_m=2e-5), seed=8)
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    points = made.dataset.points
    view = points["xyz"] / np.linalg.norm(points["xyz"], axis=1)[:, None]
    faces = np.einsum("ij,mjk->mik", R, made.dataset.flange()[points.pose, :3, :3]) @ [0.6, 0.0, 0.8]
    xyz = points["xyz"] + (4e-4 * (1.0 - np.abs((faces * view).sum(axis=1))) ** 2)[:, None] * view
    found = examine(replace(made.dataset, points=replace(points, xyz=xyz)), seed=0)
    assert (found.where[0].site, found.where[0].coordinate) == ("measuring_system", "direction of view")
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


def test_a_bearing_that_wobbles_twice_a_turn_is_an_unknown_cause_at_its_joint_and_no_error_of_lengths():
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=2e-5), seed=8)
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    xyz, poses = made.dataset.points["xyz"], made.dataset.points.pose
    in_base = (xyz - np.array([made.truth[f"base.{axis}"] for axis in "xyz"])) @ R
    turn = made.dataset.arm[1][poses, 0]
    tilt = 8e-4 * np.cos(2.0 * turn)[:, None] * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(len(turn))])
    moved = np.cross(tilt, in_base - np.array([0.0, 0.0, 0.0892])) @ R.T
    found = examine(replace(made.dataset, points=replace(made.dataset.points, xyz=xyz + moved)), seed=0)
    assert (found.verdict, found.where[0].site) == ("unexplained", "shoulder_pan_joint")
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


def test_a_bearing_that_runs_out_is_an_unknown_cause_at_its_joint_and_no_foundation_that_yields():
    made = simulate(find_robot("panda"), kind="point", poses=50, noise=Noise(point_m=2e-5), seed=8)
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    points = made.dataset.points
    turn = made.dataset.arm[1][points.pose, 0]
    runs_out = np.column_stack([1.5e-4 * np.cos(2.0 * turn), 5e-5 * np.sin(turn), 8e-5 * np.sin(2.0 * turn)])
    found = examine(replace(made.dataset, points=replace(points, xyz=points["xyz"] + runs_out @ R.T)), seed=0)
    assert (found.where[0].site, found.where[0].coordinate) == ("panda_joint1", "angle of panda_joint1")
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


WRONG_LENGTHS = {"elbow_joint.z": 0.005, "wrist_1_joint.x": -0.004, "wrist_3_joint.z": 0.0025}


def test_several_links_of_wrong_lengths_are_not_for_certain_a_trackers_scale_that_no_tracker_has():
    effects = {f"link_geometry:{name}": size for name, size in WRONG_LENGTHS.items()}
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=3e-5), effects=effects, seed=3)
    found = examine(made.dataset, OF_LENGTHS, seed=0)
    probabilities = {one.name: one.probability for one in found.classes}
    assert found.verdict == "explained"
    assert probabilities["arm_geometry"] > 0.99
    assert probabilities.get("measuring_system", 0.0) < 0.5
    assert found.gap.after_m < 1.1 * found.gap.noise_floor_m


def test_angles_that_are_biased_by_where_a_body_is_seen_from_are_no_noise_and_nothing_of_the_arm():
    noise = Noise(point_m=5e-5, angle_rad=1e-4, joint_rad=1e-5)
    made = simulate(find_robot("ur5e"), kind="pose", poses=60, noise=noise, seed=1).dataset
    measured, xyz = Rotation.from_quat(made.points["quaternion"]), made.points["xyz"]
    axis = np.random.default_rng(1).standard_normal(3)
    axis /= np.linalg.norm(axis)
    along = measured.inv().apply(xyz / np.linalg.norm(xyz, axis=1)[:, None]) @ axis
    bias = Rotation.from_rotvec(2e-3 * np.outer(np.sign(along) * along**2, np.roll(axis, 1)))
    columns = {**made.points.columns, "quaternion": (measured * bias).as_quat()}
    found = examine(replace(made, points=replace(made.points, columns=columns)), seed=0)
    assert found.verdict == "unexplained"
    assert not [one for one in found.findings if one.probability >= 0.9]
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


def test_a_reflector_that_slips_in_its_nest_is_no_tool_that_was_clamped_anew():
    made = simulate(find_robot("ur5"), kind="point", poses=30, noise=Noise(point_m=3e-5), seed=5)
    points = made.dataset.points
    slipped = np.where(np.arange(30)[:, None] < 18, 0.0, [6e-4, 8e-4, -6e-4])
    alone = np.array([name == points.names[1] for name in points.names])[:, None]
    xyz = np.where(alone, held_elsewhere(made, slipped).points["xyz"], points["xyz"])
    seen = replace(made.dataset, points=replace(points, xyz=xyz))
    found = examine(seen, kinds("mount_shift", "tool_drift", "base_shift"), seed=0)
    assert (found.where[0].site, found.where[0].coordinate) == ("tool", f"time, at {points.names[1]} alone")
    assert "unknown" in {one.name for one in found.classes if one.probability > 0.5}
    assert not [one for one in found.findings if one.probability > 0.5]


@cache
def filmed() -> Dataset:
    return simulate(
        find_robot("ur5"), kind="camera", poses=24, points=12, noise=NOISE, options=UNPLACED, seed=6
    ).dataset


def through(change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Dataset:
    """What a camera sees whose pixels (m, 2) are changed with the share of the run (m, 1) that had passed."""
    seen, time_s = filmed().points, filmed().poses.time_s
    share = (time_s / time_s.max())[seen.pose, None]
    return replace(filmed(), points=replace(seen, pixel=change(seen["pixel"], share)))


def test_a_camera_that_warms_up_is_no_bracket_that_creeps_for_certain():
    """The sensor's chip moves behind the lens, quickly at first and then ever less."""
    found = examine(through(lambda pixel, share: pixel + [1.5, -0.8] * np.sqrt(np.tanh(8.0 * share))), IN_TIME, seed=0)
    assert (found.verdict, names(found)) == ("explained", ["camera_drift"])


def test_a_focal_length_that_comes_and_goes_is_an_unknown_cause_at_the_camera_and_nothing_of_the_arm():
    middle = np.array([640.0, 480.0])
    zoomed = through(lambda pixel, share: pixel + 3e-3 * np.sin(6.0 * share) * (pixel - middle))
    found = examine(zoomed, seed=0)
    assert (found.verdict, found.where[0].site, found.where[0].coordinate) == ("unexplained", "camera", "time")
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]


def test_a_camera_that_stands_in_the_cell_may_as_well_have_a_stand_that_creeps():
    mounts = [CellOptions(mount="flange"), CellOptions(mount="base", placed=False)]
    cells = [simulate(find_robot("ur5"), kind="camera", options=one, poses=8).dataset for one in mounts]
    assert [DRIFT.locations(cell) for cell in cells] == [("camera",), ()]


def test_a_scanner_s_camera_has_the_laser_beside_it_also_where_it_sees_corners():
    made = simulate(find_robot("ur5"), kind="stripe+camera", poses=8).dataset
    assert DRIFT.locations(made) == ()
    corners, stripe = sorted(made.members, key=lambda one: one.data.kind)
    assert DRIFT.locations(replace(made, members=(stripe, replace(corners, camera="another")))) == ("camera",)


def test_of_a_camera_that_turns_neither_bracket_nor_camera_is_certain():
    """All that tells is how the image is bent in its corners."""

    def turned(pixel: np.ndarray, share: np.ndarray) -> np.ndarray:
        f, middle = 1.2 * 1280.0, np.array([640.0, 480.0])
        x, y = (pixel - middle).T / f
        angle = 8e-4 * share[:, 0]
        return np.column_stack([(x + angle * (1.0 + x**2)), (y + angle * x * y)]) * f + middle

    found = examine(through(turned), IN_TIME, seed=0)
    probabilities = {one.name: one.probability for one in found.classes}
    assert found.verdict == "explained"
    assert probabilities.keys() <= {"camera", "mount"}
    assert probabilities.get("camera", 0.0) < 0.95


def test_a_shutter_that_rolls_over_the_image_of_a_moving_camera_is_an_unknown_timing_and_no_scatter():
    """Each row of the image is exposed later than the one above it."""
    at_once, later = (
        simulate(
            find_robot("ur5"), kind="camera", poses=16, points=12, noise=NOISE, options=UNPLACED, effects=late, seed=6
        )
        for late in ({"latency": 0.0}, {"latency": 0.015})
    )
    seen = at_once.dataset.points
    share = seen["pixel"][:, [1]] / 960.0
    rolled = replace(seen, pixel=seen["pixel"] + share * (later.dataset.points["pixel"] - seen["pixel"]))
    found = examine(replace(at_once.dataset, points=rolled), seed=0)
    assert (found.verdict, found.where[0].site, found.where[0].coordinate) == (
        "unexplained",
        "timing",
        "image position",
    )
    assert [one.name for one in found.classes if one.probability > 0.5] == ["unknown"]
