"""Where a scan puts points, and how sure it is of them."""

import tracemalloc
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np
import pytest
from scanned import calibrated, dataset, laser_planes, line_centres, recorded, written
from several import together

from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError, ScanError
from robolaser.model.effects import candidate_effects
from robolaser.model.effects.effect import Effect, parameter
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.stages import Stage
from robolaser.scan import Cloud, cloud, prepare, read_calibration
from robolaser.scan.cloud_files import Subsample
from robolaser.scan.ply import VERTEX, positions_of
from robolaser.simulation import simulate

EFFECTS = {
    "none": ([], {}),
    "arm": (
        ["joint_offset:joint_2", "link_geometry:joint_3", "backlash:joint_2", "encoder_scale:joint_1"],
        {
            "joint_offset.joint_2.offset": 0.004,
            "link_geometry.joint_3.x": 0.001,
            "backlash.joint_2.lost_motion": 0.005,
            "backlash.joint_2.start": 0.7,
            "encoder_scale.joint_1.scale": 0.002,
        },
    ),
    "course": (
        ["thermal_drift:joint_3", "hand_eye_drift", "laser_drift", "base_shift"],
        {
            "thermal_drift.joint_3.growth": 0.004,
            "hand_eye_drift.hand_eye.x": 0.002,
            "hand_eye_drift.hand_eye.turn_y": 0.01,
            "laser_drift.laser.angle": 0.006,
            "base_shift.base.turn_z": 0.01,
            "base_shift.base.x": 0.003,
        },
    ),
    "light": (
        ["laser_roll", "laser_curvature", "radial_distortion", "tangential_distortion", "stripe_bias"],
        {
            "laser_roll.laser.angle": 0.02,
            "laser_curvature.laser.curvature": 0.1,
            "laser_curvature.laser.cone": 0.02,
            "tangential_distortion.camera.p_1": 0.4,
            "tangential_distortion.camera.p_2": -0.3,
            "radial_distortion.camera.k_2": 2e7,
            "stripe_bias.laser.slope": 0.4,
        },
    ),
    "target": (["target_scale"], {"target_scale.target.scale": 0.01}),
}


@pytest.fixture(scope="module")
def data():
    return dataset()


@pytest.fixture(params=EFFECTS)
def effects(request):
    return EFFECTS[request.param]


def scan_of(calibration, recording, folder):
    return prepare(read_calibration(written(calibration, folder / "calibration")), recording)


def places(scan):
    return np.concatenate([positions_of(piece) for piece in scan.cloud.pieces()])


def elsewhere(data, **changes):
    """The same poses as another run."""
    poses = replace(data.poses, time_s=data.poses.time_s + 1.0, **changes)
    return replace(data, name="another run", poses=poses)


def test_the_calibrated_data_set_is_scanned_to_where_its_model_sees_it(data, effects, tmp_path):
    names, numbers = effects
    calibration = calibrated(data, names, numbers)
    scan = scan_of(calibration, recorded(data, tmp_path / "data"), tmp_path)
    model = Model(data, candidate_effects([name for name in names if not name.startswith("target")], data))
    kept = calibration.model.parameters.columns(model.parameters.names)
    values = model.parameters.values(calibration.x[None, kept])
    perturb = model.perturb(values)
    seen = scanner_geometry.in_base(model.blocks.sensor.dataset, values, model.flange(values, perturb), perturb)[0]
    np.testing.assert_allclose(places(scan), seen, atol=2e-7)
    assert scan.warnings == ()


@final
@dataclass(frozen=True)
class Smudge(Effect):
    """A lens that somebody touched: an effect of a user's own."""

    name: ClassVar[str] = "smudge"
    title: ClassVar[str] = "a smudge"
    reference: ClassVar[str] = "made up"
    stage: ClassVar[Stage] = Stage.IMAGE
    site: ClassVar[str] = "camera"

    size: np.ndarray = parameter(unit="m", bound=1e-3, prior_scale=1e-5)

    def apply(self, value, run):
        return value + self.size[:, None, None] * np.sin(1e3 * value)


def test_effects_of_ones_own_are_scanned_too(data, tmp_path):
    scan = scan_of(calibrated(data), recorded(data, tmp_path / "data", line_centres(data, per_pose=200)), tmp_path)
    straight = places(scan)
    part = scan.cloud.parts[0]
    part = replace(part, scanner=replace(part.scanner, effects=(Smudge("camera", np.array([1e-5])),)))
    smudged = np.concatenate([positions_of(piece) for piece in Cloud((part,)).pieces()])
    wanted = part.scanner.in_base(cloud.as_points(np.concatenate([read() for read in part.source.pieces])))
    np.testing.assert_allclose(smudged, wanted[np.isfinite(wanted).all(axis=1)], atol=2e-6)
    assert len(smudged) > 1000
    assert len(smudged) != len(straight) or np.abs(smudged - straight).max() > 1e-5


def test_std_is_how_far_noise_moves_a_point(data, tmp_path):
    rng = np.random.default_rng(5)
    stripes = line_centres(data, per_pose=1, std=0.2).repeat(2000)
    shaken = stripes.copy()
    shaken["v"] += rng.normal(scale=0.2, size=len(stripes))
    joints = rng.normal(scale=1e-4, size=(len(data.poses), len(data.robot.joints)))
    calibration = replace(calibrated(data), noise={"joint": 0.0})
    still = scan_of(calibration, recorded(data, tmp_path / "still", stripes), tmp_path)
    moved = scan_of(calibration, recorded(data, tmp_path / "moved", shaken), tmp_path)
    std = np.concatenate([piece["std"] for piece in still.cloud.pieces()])
    found = (np.linalg.norm(places(moved) - places(still), axis=1) ** 2).reshape(-1, 2000).mean(axis=1) ** 0.5
    np.testing.assert_allclose(found, std.reshape(-1, 2000).mean(axis=1), rtol=0.1)
    misread = replace(data, poses=replace(data.poses, q=data.poses.q + joints))
    calibration = replace(calibration, noise={"joint": 1e-4})
    away = scan_of(calibration, recorded(misread, tmp_path / "misread", stripes), tmp_path)
    distance = np.linalg.norm(places(away) - places(still), axis=1).reshape(-1, 2000)[:, 0]
    assert np.sqrt(np.mean((distance / away.cloud.parts[0].arm) ** 2)) == pytest.approx(1.0, abs=0.4)


def test_drifts_of_the_calibrated_run_are_taken_as_at_its_end_and_their_size_is_told(data, tmp_path):
    names, numbers = EFFECTS["course"]
    scan = scan_of(calibrated(data, names, numbers), recorded(elsewhere(data), tmp_path / "data"), tmp_path)
    said = " ".join(scan.warnings)
    for name in ("thermal_drift at joint_3", "hand_eye_drift at hand_eye", "laser_drift at laser", "base_shift"):
        assert name in said
    assert said.count(" mm.") == 3
    last = int(np.argmax(data.poses.time_s))
    same = scan_of(calibrated(data, names, numbers), recorded(data, tmp_path / "same"), tmp_path)
    np.testing.assert_allclose(
        scan.cloud.parts[0].scanner.camera[last], same.cloud.parts[0].scanner.camera[last], atol=1e-12
    )
    np.testing.assert_allclose(
        laser_planes(scan.cloud.parts[0].scanner),
        laser_planes(same.cloud.parts[0].scanner)[last][None].repeat(20, 0),
        atol=1e-12,
    )


def test_what_warms_up_follows_the_thermometer_of_both_runs(data, tmp_path):
    warm = np.linspace(20.0, 30.0, len(data.poses))
    measured = replace(data, poses=replace(data.poses, temperature_c=warm))
    calibration = calibrated(measured, ["laser_drift"], {"laser_drift.laser.angle": 0.01})
    half = np.full(len(warm), 25.0)
    scan = scan_of(calibration, recorded(elsewhere(measured, temperature_c=half), tmp_path / "r"), tmp_path)
    planes = laser_planes(scan.cloud.parts[0].scanner)
    theta = np.arctan2(planes[:, 2], planes[:, 0])
    np.testing.assert_allclose(theta - data.parameters["theta"].nominal, 0.005, atol=1e-9)
    assert scan.warnings == ()


def test_play_follows_the_recordings_own_path(data, tmp_path):
    numbers = {"backlash.joint_2.lost_motion": 0.01, "backlash.joint_2.start": 1.0}
    calibration = calibrated(data, ["backlash:joint_2"], numbers)
    q = data.poses.q.copy()
    q[:, 1] = np.linspace(-0.5, 0.5, len(q))
    up = elsewhere(data, q=q)
    down = elsewhere(data, q=q[::-1].copy())
    cameras = [
        scan_of(calibration, recorded(one, tmp_path / name), tmp_path).cloud.parts[0].scanner.camera
        for name, one in (("up", up), ("down", down))
    ]
    free = [scan_of(calibrated(data), recorded(one, tmp_path / f"{name} free"), tmp_path).cloud.parts[0].scanner.camera
            for name, one in (("up", up), ("down", down))]  # fmt: skip
    hung = [np.linalg.norm((one - none)[3:, :3, 3], axis=1) for one, none in zip(cameras, free, strict=True)]
    assert min(hung[0].min(), hung[1].min()) > 1e-3
    ways = [(one - none)[10, :3, 3] for one, none in zip(cameras, free, strict=True)]
    assert ways[0] @ ways[1] < 0


def test_where_play_stood_at_first_is_told_to_matter_for_the_first_poses_only(data, tmp_path):
    calibration = calibrated(data, ["backlash:joint_2"], {"backlash.joint_2.lost_motion": 0.01})
    q = data.poses.q.copy()
    q[:, 1] = np.linspace(-0.5, 0.5, len(q))
    (said,) = scan_of(calibration, recorded(elsewhere(data, q=q), tmp_path / "r"), tmp_path).warnings
    assert "in 1 of 20 poses" in said


def test_without_a_known_path_play_is_left_out_with_a_word(data, tmp_path):
    calibration = calibrated(data, ["backlash:joint_2"], {"backlash.joint_2.lost_motion": 0.01})
    lost = replace(elsewhere(data), path_known=False)
    scan = scan_of(calibration, recorded(lost, tmp_path / "r"), tmp_path)
    assert "left out" in scan.warnings[0]
    assert " mm." in scan.warnings[0]
    assert not scan.cloud.parts[0].scanner.effects


def test_the_bias_of_tilted_surfaces_is_left_out_where_nobody_knows_the_tilt(data, tmp_path):
    calibration = calibrated(data, ["stripe_bias"], {"stripe_bias.laser.slope": 0.4})
    recording = recorded(data, tmp_path / "r", line_centres(data, per_pose=20))
    (said,) = scan_of(calibration, recording, tmp_path).warnings
    assert "stripe_bias at laser is left out" in said
    assert "30°" in said


def test_joints_in_another_order_are_the_same_joints(data, tmp_path):
    recording = recorded(data, tmp_path / "r")
    order = [2, 0, 1, 4, 3]
    robot = replace(recording.robot, joints=tuple(recording.robot.joints[i] for i in order))
    turned = replace(recording, robot=robot, poses=replace(recording.poses, q=recording.poses.q[:, order]))
    one, other = (scan_of(calibrated(data), each, tmp_path) for each in (recording, turned))
    np.testing.assert_array_equal(one.cloud.parts[0].scanner.camera, other.cloud.parts[0].scanner.camera)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"image_px": (320, 240)}, "image size"),
        ({"stripe_axis": "v"}, "stripe_axis"),
        ({"kind": "point"}, "kind of sensor"),
        ({"robot": None}, "poses"),
    ],
)
def test_a_recording_of_another_scanner_is_refused(data, change, said, tmp_path):
    recording = replace(recorded(data, tmp_path / "r"), **change)
    with pytest.raises(ScanError, match=said):
        scan_of(calibrated(data), recording, tmp_path)


def test_corners_of_a_board_beside_the_stripe_are_no_line_centres(data):
    board = simulate(data.robot, kind="camera", poses=len(data.poses), noise=Noise(pixel_px=0.1), seed=1).dataset
    both = together(data, {"stripe": (data, data.points), "camera": (board, board.points)})
    (piece,) = cloud.source_of(both, 0.1).pieces
    assert len(piece()) == len(data.points)


def test_a_recording_with_nothing_in_it_is_refused(data, tmp_path):
    recording = recorded(data, tmp_path / "r", line_centres(data, per_pose=2))
    (tmp_path / "r" / "stripes.npy").unlink()
    with pytest.raises(ScanError, match=r"stripes\.npy nor points\.csv"):
        scan_of(calibrated(data), recording, tmp_path)


def test_stripes_of_poses_that_are_not_there_are_refused(data, tmp_path):
    stripes = line_centres(data, per_pose=2)
    stripes["pose"][-1] = 99
    with pytest.raises(DataError, match="row 99"):
        scan_of(calibrated(data), recorded(data, tmp_path / "r", stripes), tmp_path)


def test_rays_that_never_meet_the_sheet_give_no_cloud(data, tmp_path):
    stripes = line_centres(data, per_pose=5)
    stripes["v"] = 239.5 - 3000.0 * np.sign(data.parameters["b"].nominal)
    scan = scan_of(calibrated(data), recorded(data, tmp_path / "blind", stripes), tmp_path)
    with pytest.raises(ScanError, match="100 line centres"):
        list(scan.cloud.pieces())


def test_a_scan_holds_a_small_part_of_its_points_at_once(data, tmp_path, monkeypatch):
    monkeypatch.setattr(cloud, "AT_ONCE", 1 << 11)
    scan = scan_of(calibrated(data), recorded(data, tmp_path / "large", line_centres(data, per_pose=15_000)), tmp_path)
    subsample = Subsample(1000)
    tracemalloc.start()
    count = sum(len(piece) for piece in subsample.watch(scan.cloud.pieces()))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count == scan.cloud.counts.points > 150_000
    assert peak < 0.3 * count * VERTEX.itemsize


@pytest.mark.parametrize("most", [1, 7, 100, 1000])
def test_a_survey_is_evenly_taken(most):
    rng = np.random.default_rng(0)
    subsample, sizes = Subsample(most), rng.integers(0, 40, 60)
    pieces, start = [], 0
    for size in sizes.tolist():
        piece = np.zeros(size, VERTEX)
        piece["pose"] = np.arange(start, start + size)
        pieces.append(piece)
        start += size
    assert sum(len(piece) for piece in subsample.watch(pieces)) == start
    kept = subsample.vertices["pose"].astype(int)
    assert len(kept) <= most
    assert kept[0] == 0
    assert len(set(np.diff(kept))) <= 1
    assert len(kept) > most // 2 or len(kept) == start
