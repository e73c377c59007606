"""Several sensors are one: their rows side by side, and each thing's parameters once."""

from dataclasses import replace

import numpy as np
import pytest
from several import together, two_trackers

from robolaser import find_robot
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.result import Calibration, as_json
from robolaser.data.dataset import Dataset, Points
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis.pipeline import examine
from robolaser.errors import DataError
from robolaser.estimation.folds import assign_folds
from robolaser.estimation.noise_estimate import noise_of
from robolaser.geometry.rigid_motion import carry
from robolaser.model.blocks.cell_frames import in_cell
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.radial_distortion import CORNER_M, RadialDistortion
from robolaser.model.forward_model import Model
from robolaser.model.sensors.in_cell import Mounting
from robolaser.simulation import simulate


def tracker_and_socket() -> Dataset:
    """A ball on the flange goes into sockets, and a tracker sees a reflector in the middle of the ball."""
    seated = simulate(find_robot("ur10"), kind="socket", poses=24, noise=Noise(joint_rad=1e-5), seed=2).dataset
    ball = np.array([[calibrate(seated).value(f"tool.ball.{axis}") for axis in "xyz"]])
    seen = carry(seated.flange()[None], seated.points.pose, ball[None])[0]
    shaken = seen + 2e-5 * np.random.default_rng(1).standard_normal(seen.shape)
    tracked = replace(seated, kind="point", noise=Noise(point_m=2e-5))
    points = replace(seated.points, names=("ball",) * len(seen), xyz=shaken)
    return together(seated, {"sockets": (seated, seated.points), "tracker": (tracked, points)})


@pytest.fixture(scope="module")
def trackers() -> Dataset:
    return two_trackers()


def test_trackers_stand_each_in_their_place_and_see_the_same_reflectors(trackers):
    names = Model(trackers).parameters.names
    assert {f"{name}.base.x" for name in ("left", "right")} <= set(names)
    assert [name for name in names if name.startswith("tool.0")] == ["tool.0.x", "tool.0.y", "tool.0.z"]


def test_a_ball_in_a_socket_and_its_reflector_are_one():
    names = Model(tracker_and_socket()).parameters.names
    assert names.count("tool.ball.x") == 1
    assert "base.x" in names
    assert "socket.0.x" in names


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_each_of_two_cameras_has_a_published_frame_of_its_own(mount):
    one = simulate(find_robot("ur10"), kind="camera", poses=6, seed=3).dataset
    other = replace(one, options=Mounting(mount), placed=mount == "flange")
    both = together(one, {"left": (one, one.points), "right": (other, one.points)})
    model = Model(replace(both, members=tuple(replace(member, camera=member.name) for member in both.members)))
    values = {**model.parameters.values(model.parameters.nominal[None]), "right.hand_eye.x": np.ones(1)}
    here = in_cell(model.blocks, values, model.perturb(values))
    assert list(here.published) == ["camera_optical", "right_camera_optical"]
    assert (here.flange if mount == "flange" else here.base)["right_camera_optical"][0, 3] == 1.0
    assert here.flange["camera_optical"][0, 3] == values["left.hand_eye.x"][0]


def test_the_camera_on_the_flange_is_found_behind_a_tracker():
    made = simulate(find_robot("ur10"), kind="camera", poses=6, seed=3).dataset
    tracked = simulate(find_robot("ur10"), kind="pose", poses=6, seed=3).dataset
    model = Model(together(made, {"tracker": (tracked, tracked.points), "camera": (made, made.points)}))
    assert in_cell(model.blocks, *model.at(model.parameters.nominal)[::2]).mount is not None


def test_what_is_shared_is_where_one_sensor_alone_puts_it(trackers):
    alone, both = calibrate(trackers.sensors[0].data), calibrate(trackers)
    names = alone.model.parameters.names
    for name in (name for name in names if name.startswith("tool")):
        assert both.value(name) == pytest.approx(alone.value(name), abs=5 * alone.std[names.index(name)])


def test_each_sensor_has_rows_of_its_own_in_the_result(trackers):
    rows = as_json(calibrate(trackers))["rows"]
    assert [(row["sensor"], row["rows"], row["unit"]) for row in rows] == [("left", 60, "m"), ("right", 40, "m")]
    assert all(row["held_out_rms"] is not None for row in rows)


def test_rotations_of_bodies_stay_angles_beside_what_others_measure():
    noise = Noise(point_m=2e-5, angle_rad=1e-3)
    bodies = simulate(find_robot("ur10"), kind="pose", poses=20, noise=noise, seed=3).dataset
    shaken = bodies.points["xyz"] + 2e-5 * np.random.default_rng(0).standard_normal(bodies.points["xyz"].shape)
    seen = replace(bodies.points, xyz=shaken, columns={})
    both = {"bodies": (bodies, bodies.points), "tracker": (replace(bodies, kind="point"), seen)}
    found = calibrate(together(bodies, both))
    rows = {(row["sensor"], row["unit"]): row["rms"] for row in as_json(found)["rows"]}
    assert rows["bodies", "rad"] == pytest.approx(np.sqrt(3.0) * 1e-3, rel=0.2)
    assert rows["bodies", "m"] == pytest.approx(np.sqrt(3.0) * 2e-5, rel=0.25)
    squares = sum(row["rows"] * row["rms"] ** 2 for row in as_json(found)["rows"] if row["unit"] == "m")
    assert found.objective_m2 == pytest.approx(squares)
    assert as_json(found)["rms_m"] == pytest.approx(np.sqrt(squares / len(found.model.dataset.points)))


def test_rms_m_is_that_of_the_objective_which_is_null_where_some_rows_are_pixels(trackers):
    said = as_json(calibrate(trackers))
    assert said["rms_m"] == pytest.approx(np.sqrt(said["objective_m2"] / len(trackers.points)))
    scanner = simulate(find_robot("ur5"), kind="stripe+camera", poses=8, seed=3).dataset
    assert as_json(calibrate(scanner))["objective_m2"] is None


def test_a_pose_is_held_out_with_all_that_every_sensor_saw_in_it(trackers):
    folds = assign_folds(Model(trackers), seed=1)
    pairs = set(zip(trackers.points.pose.tolist(), folds.of_row.tolist(), strict=True))
    assert len(pairs) == len(trackers.poses)


def test_each_sensor_has_noise_of_its_own(trackers):
    members = (trackers.members[0], replace(trackers.members[1], data=replace(trackers.members[1].data, noise=Noise())))
    errors = 1e-3 * np.random.default_rng(2).standard_normal((len(trackers.points), 3))
    loud = trackers.points["xyz"] + errors * (trackers.points.sensor == 1)[:, None]
    dataset = replace(trackers, members=members, points=replace(trackers.points, xyz=loud))
    noise = noise_of(Model(dataset), calibrate(dataset).x)
    assert noise.sigmas["left.point"] == 2e-5
    assert noise.sigmas["right.point"] == pytest.approx(1e-3, rel=0.25)


def test_a_higher_radial_term_is_of_the_order_that_each_sensors_own_lens_lacks():
    scanner, camera = (
        simulate(find_robot("ur10"), kind=kind, poses=8, seed=1).dataset for kind in ("stripe", "camera")
    )
    both = together(scanner, {"scanner": (scanner, scanner.points), "eye": (camera, camera.points)})
    both = replace(both, members=(replace(both.members[0], camera="scanner"), replace(both.members[1], camera="eye")))
    run = Model(both).run
    image, r = np.full((1, len(both.points), 2), 1e-3), np.sqrt(2e-6)
    stretched = RadialDistortion("camera", k_2=np.array([1e7])).apply(image, run)[0, :, 0] / 1e-3 - 1.0
    eyes = both.points.sensor == 1
    np.testing.assert_allclose(stretched[~eyes], 1e7 * r**4)
    np.testing.assert_allclose(stretched[eyes], 1e7 * r**6 / CORNER_M**2)


def test_a_joint_that_is_off_is_found_by_all_sensors_together():
    found = examine(two_trackers(40, effects={"backlash:elbow_joint": 0.003}), seed=0)
    assert [(str(one.candidate_effect), one.probability > 0.9) for one in found.findings] == [
        ("backlash at elbow_joint", True)
    ]


@pytest.fixture(scope="module")
def two_scanners() -> tuple[Dataset, Dataset]:
    """What one stripe scanner saw, the elbow's play in it, and the same as that of two, each in every other pose."""
    one = simulate(find_robot("ur10"), kind="stripe", poses=16, points=3, noise=Noise(pixel_px=0.1),
                   effects={"backlash:elbow_joint": 0.004}, seed=3).dataset  # fmt: skip
    even = one.points.pose % 2 == 0
    both = together(one, {"left": (one, one.points.take(even)), "right": (one, one.points.take(~even))})
    named = {f"{side}.{name}": item for side in ("left", "right") for name, item in one.parameters.items()}
    return one, replace(
        both,
        members=tuple(replace(member, camera=member.name) for member in both.members),
        parameters={name: replace(item, name=name) for name, item in named.items()},
    )


def test_effects_read_the_values_of_the_scanner_that_they_act_on(two_scanners):
    one, both = two_scanners
    angle = both.parameters["right.theta"]
    turned = replace(angle, nominal=angle.nominal + 0.01)
    both = replace(both, parameters={**both.parameters, "right.theta": turned})
    rights = both.points.sensor == 1
    run, alone = Model(both).run, Model(one).run
    np.testing.assert_array_equal(run.laser_angle, np.where(rights, turned.nominal, angle.nominal))
    np.testing.assert_allclose(run.tilt[~rights], alone.tilt[(one.points.pose % 2 == 0)])


def test_an_arm_is_diagnosed_with_two_stripe_scanners(two_scanners):
    kinds = [kind for kind in EFFECTS if kind.name in ("backlash", "laser_curvature", "stripe_bias")]
    found = examine(two_scanners[1], kinds, seed=0)
    assert [str(one.candidate_effect) for one in found.findings] == ["backlash at elbow_joint"]


def test_two_stripe_scanners_share_a_camera_only_where_both_name_it(two_scanners, tmp_path):
    save(two_scanners[1], tmp_path)
    file = tmp_path / "dataset.toml"
    text, _, _ = file.read_text().partition("[parameters]")
    unnamed = text.replace('camera = "left"\n', "").replace('camera = "right"\n', "")
    assert "camera =" not in unnamed
    file.write_text(unnamed)
    assert [one.camera for one in load(tmp_path).members] == ["left", "right"]
    file.write_text(unnamed.replace('kind = "stripe"', 'kind = "stripe"\ncamera = "camera"'))
    assert [one.camera for one in load(tmp_path).members] == ["camera", "camera"]


def test_what_is_written_reads_the_same(trackers, tmp_path):
    save(trackers, tmp_path / "cell")
    again = load(tmp_path / "cell")
    assert [(one.name, one.file, one.data.kind) for one in again.members] == [
        ("left", "left.csv", "point"), ("right", "right.csv", "point")
    ]  # fmt: skip
    assert again.points.names == trackers.points.names
    assert np.array_equal(again.points["xyz"], trackers.points["xyz"])
    assert [one.data.noise for one in again.members] == [one.data.noise for one in trackers.members]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name = "right"', 'name = "left"', "'left', expected different ones for all sensors"),
        ('points = "right.csv"', 'points = "left.csv"', "'left.csv', expected different ones for all sensors"),
        ('points = "right.csv"', "", "points"),
        (
            '[[sensors]]\nname = "left"',
            '[sensor]\nkind = "point"\n[[sensors]]\nname = "left"',
            "[[sensors]]: there is [sensor], too",
        ),
        ('kind = "point"', 'kind = "pointt"', "sensor left"),
    ],
)
def test_what_is_wrong_with_a_sensor_is_said(trackers, tmp_path, old, new, said):
    save(trackers, tmp_path)
    file = tmp_path / "dataset.toml"
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(DataError) as caught:
        load(tmp_path)
    assert said in str(caught.value)


def test_points_of_one_sensor_may_not_be_missing(trackers, tmp_path):
    save(trackers, tmp_path)
    (tmp_path / "right.csv").unlink()
    with pytest.raises(DataError, match=r"right\.csv"):
        load(tmp_path)


def test_an_unknown_parameter_is_an_error(trackers, tmp_path):
    save(trackers, tmp_path)
    file = tmp_path / "dataset.toml"
    file.write_text(file.read_text() + "\n[parameters]\nwrong.base.x = { nominal = 0, lower = -1, upper = 1 }\n")
    with pytest.raises(DataError, match=r"no parameter 'wrong\.base\.x' here"):
        Model(load(tmp_path)).parameters  # noqa: B018 - asked for what it raises


def test_errors_are_of_the_sensor_of_that_name_although_another_is_of_that_kind():
    eye = simulate("ur5", kind="camera", poses=20, points=20, noise=Noise(pixel_px=0.1), seed=1).dataset
    there = eye.flange()[:, :3, :3] @ (0.05, 0.02, 0.1) + eye.flange()[:, :3, 3]
    shaken = there + 3e-5 * np.random.default_rng(0).standard_normal(there.shape)
    seen = Points(np.arange(20), ("reflector",) * 20, xyz=shaken)
    tracker = replace(eye, kind="point", options=None, image_px=None, board=None, placed=True, points=seen)
    of_each = calibrate(together(eye, {"eye": (eye, eye.points), "camera": (tracker, seen)})).row_errors
    assert [(one.sensor, one.rows, one.unit) for one in of_each] == [("eye", 400, "px"), ("camera", 20, "m")]
    assert of_each[1].rms < 1e-4


def test_a_distance_between_points_that_one_of_two_sensors_sees_is_known(tmp_path):
    made = two_trackers(8)
    one, other = "0", "2"  # which `right` does not see

    def apart(found: Calibration) -> float:
        ends = (np.array([found.value(f"tool.{name}.{axis}") for axis in "xyz"]) for name in (one, other))
        return float(np.linalg.norm(np.subtract(*ends)))

    stated = apart(calibrate(made)) + 4e-3
    known = {"distances_m": ((one, other, stated),)}
    members = tuple(replace(member, data=replace(member.data, **known)) for member in made.members)
    save(replace(made, members=members, **known), tmp_path / "two")
    dataset = load(tmp_path / "two")
    held = calibrate(replace(dataset, noise=replace(dataset.noise, distance_m=1e-6)))
    assert abs(apart(held) - stated) < 2e-3


def test_a_tracker_that_turns_during_the_run_is_where_the_gap_lies(trackers):
    right = trackers.sensor_of_row == 1
    turned = np.array(trackers.points.xyz)
    angle = 4e-4 * trackers.points.pose[right] / len(trackers.poses)
    turned[right] += np.column_stack([-angle * turned[right, 1], angle * turned[right, 0], 0 * angle])
    found = examine(replace(trackers, points=replace(trackers.points, xyz=turned)), seed=0)
    assert found.verdict == "unexplained"
    assert found.where[0].site == "right.measuring_system"
    few = [kind for kind in EFFECTS if kind.name in ("joint_offset", "tracker_scale")]
    assert examine(trackers, few, seed=0).verdict == "no_gap"


def test_a_sensor_that_saw_nothing_is_named(trackers):
    nothing = replace(trackers, points=trackers.points.take(trackers.sensor_of_row == 0))
    with pytest.raises(DataError, match=r"right\.csv has no rows: sensor right saw nothing"):
        calibrate(nothing)
