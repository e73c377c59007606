"""A time offset between arm and sensor, from poses in motion whose velocities nobody recorded."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.path_velocities import WARNING, known_velocities, with_path_velocities
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.errors import EffectError
from robolaser.geometry.rigid_motion import exp_so3, pose, to_quaternion
from robolaser.model.effects.latency import Latency
from robolaser.model.effects.requirements import velocities
from robolaser.model.effects.run import Run
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

ROBOT = find_robot("ur5")
DELAY_S = 0.03
RATE = np.array([0.9, 0.7, 1.1, 0.8, 1.3, 1.0])


def path(t: np.ndarray) -> np.ndarray:
    return np.array([0.0, -1.2, 1.4, -1.8, -1.57, 0.0]) + 0.6 * np.sin(RATE * t[:, None] + np.arange(6.0))


def in_motion(delay_s: float, rate_hz: float = 10.0, seconds: float = 12.0) -> Dataset:
    """Poses of a body, seen a little later than the joints of a moving arm are read."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, seconds, 1.0 / rate_hz)
    n = len(t)
    T_world_base, T_flange_body = (pose(exp_so3(rng.normal(size=3)), rng.normal(size=3)) for _ in range(2))
    T = T_world_base @ ROBOT.forward(path(t + delay_s)[None])[0] @ T_flange_body
    T[:, :3, :3] = exp_so3(1e-3 * rng.normal(size=(n, 3))) @ T[:, :3, :3]
    xyz = T[:, :3, 3] + 3e-4 * rng.normal(size=(n, 3))
    return Dataset(
        name="moving",
        kind="pose",
        robot=ROBOT,
        poses=Poses(tuple(map(str, range(n))), time_s=t, q=path(t)),
        points=Points(np.arange(n), ("body",) * n, xyz=xyz, columns={"quaternion": to_quaternion(T[:, :3, :3])}),
        noise=Noise(point_m=3e-4, angle_rad=1e-3),
    )


def test_velocities_along_the_path_are_those_of_the_arm() -> None:
    found = with_path_velocities(in_motion(0.0, rate_hz=30.0))
    expected = 0.6 * RATE * np.cos(RATE * found.poses.time_s[:, None] + np.arange(6.0))
    np.testing.assert_allclose(found.poses.qd[1:-1], expected[1:-1], atol=1e-3)
    assert found.warnings == (WARNING,)


def is_the_delay(value: float, std: float, delay_s: float = DELAY_S) -> bool:
    return abs(value - delay_s) < max(4 * std, 0.02 * delay_s)


def has_the_delay(found: Calibration) -> None:
    at = found.model.parameters.names.index("latency.timing.delay")
    assert is_the_delay(found.x[at], found.std[at])


@pytest.mark.parametrize("kind", ["pose", "point"])
def test_a_time_offset_is_found_without_recorded_velocities(kind: str, tmp_path: Path) -> None:
    save(replace(in_motion(DELAY_S, seconds=6.0), kind=kind), tmp_path / "moving")
    found = calibrate(robolaser.load(tmp_path / "moving"), Plan(effects=("latency",)))
    has_the_delay(found)
    assert WARNING in found.warnings
    assert found.rms_m == pytest.approx(np.sqrt(3.0) * 3e-4, rel=0.15)


def of_flange(dataset: Dataset) -> Dataset:
    """The same with measured flange poses in the place of joint angles."""
    (T,) = ROBOT.forward(dataset.poses.q[None])
    return replace(dataset, robot=None, poses=replace(dataset.poses, q=None, T_base_flange=T))


def test_velocities_of_a_flange_carry_it_from_pose_to_pose() -> None:
    found = with_path_velocities(of_flange(in_motion(0.0, rate_hz=30.0)))
    later = Latency("timing", np.array([0.02])).apply(found.poses.T_base_flange[None], Run(found))
    expected = ROBOT.forward(path(found.poses.time_s + 0.02)[None])
    np.testing.assert_allclose(later[0, 1:-1], expected[0, 1:-1], atol=1e-3)


def test_a_delay_is_named_from_flange_poses_alone() -> None:
    why = robolaser.diagnose(with_path_velocities(of_flange(in_motion(0.01, seconds=6.0))), seed=0)
    (found,) = (one for one in why.effects if one.probability > 0.5)
    assert (why.verdict, found.effect, found.where) == ("explained", "latency", "timing")
    delay = found.parameters["delay"]
    assert is_the_delay(delay.value, delay.std, 0.01)


def test_a_flange_that_stops_at_each_pose_shows_no_delay() -> None:
    stopped = with_path_velocities(slow(of_flange(in_motion(0.0))))
    assert Latency.missing(stopped) == "the flange's poses do not follow one another in motion"


def test_they_are_not_written_as_if_they_had_been_read(tmp_path: Path) -> None:
    save(with_path_velocities(in_motion(0.0)), tmp_path / "moving")
    assert "qd_" not in (tmp_path / "moving" / "poses.csv").read_text().splitlines()[0]


def alone_in_time(*numbers: int) -> Callable[[Dataset], Dataset]:
    """Poses that all others are more than a second away from."""

    def pull(dataset: Dataset) -> Dataset:
        late = np.zeros(len(dataset.poses))
        for number in numbers:
            late[number] += 3.0
            late[number + 1 :] += 6.0
        return replace(dataset, poses=replace(dataset.poses, time_s=dataset.poses.time_s + late))

    return pull


def test_a_gap_in_time_leaves_the_velocities_on_both_sides(tmp_path: Path) -> None:
    moving = in_motion(DELAY_S)
    late = np.where(np.arange(len(moving.poses)) < 60, 0.0, 30.0)
    save(replace(moving, poses=replace(moving.poses, time_s=moving.poses.time_s + late)), tmp_path / "paused")
    has_the_delay(calibrate(robolaser.load(tmp_path / "paused"), Plan(effects=("latency",))))


def test_a_pose_alone_in_time_has_no_velocity_and_latency_waits_for_one(tmp_path: Path) -> None:
    save(alone_in_time(20, 50)(in_motion(DELAY_S)), tmp_path / "moving")
    loaded = robolaser.load(tmp_path / "moving")
    assert np.flatnonzero(np.isnan(loaded.poses.qd).any(axis=1)).tolist() == [20, 50]
    with pytest.raises(EffectError, match=r"not known at 2 poses with points, .* \(pose 20, 50\)"):
        calibrate(loaded, Plan(effects=("latency",)))
    found = calibrate(loaded.of_poses(~np.isnan(loaded.poses.qd).any(axis=1)), Plan(effects=("latency",)))
    has_the_delay(found)


def test_a_pose_alone_in_time_that_shows_nothing_hinders_nobody() -> None:
    pulled = with_path_velocities(alone_in_time(20)(in_motion(0.0)))
    assert known_velocities(pulled) is None
    silent = replace(pulled, points=pulled.points.take(pulled.points.pose != 20))
    assert np.isfinite(known_velocities(silent)).all()
    assert velocities(silent) == ""


def slow(dataset: Dataset) -> Dataset:
    return replace(dataset, poses=replace(dataset.poses, time_s=20.0 * dataset.poses.time_s))


def anyhow(dataset: Dataset) -> Dataset:
    order = np.random.default_rng(0).permutation(len(dataset.poses))
    return replace(dataset, poses=replace(dataset.poses, q=dataset.poses.q[order]))


@pytest.mark.parametrize(
    "but",
    [
        slow,
        anyhow,
        lambda dataset: replace(dataset, path_known=False),
        lambda dataset: replace(dataset, time_is_order=True),
        lambda dataset: replace(dataset, poses=replace(dataset.poses, time_s=None)),
        lambda dataset: replace(dataset, poses=replace(dataset.poses, q=dataset.poses.q[:1].repeat(120, axis=0))),
        lambda _: simulate(ROBOT, kind="pose", poses=12).dataset,
    ],
    ids=["poses far apart in time", "places in any order", "no path", "an order", "no times", "at rest", "stops"],
)
def test_where_the_arm_may_have_stopped_no_velocities_are_made_up(but) -> None:
    dataset = but(in_motion(0.0))
    assert with_path_velocities(dataset) is dataset
