from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import pytest
from asked import simulate_as_asked

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.errors import DependencyMissing, EffectError, RobolaserError, UsageError
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.stages import Stage
from robolaser.motion.simulation import simulate_motion
from robolaser.robot.by_name import find_robot, known_robots
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, Simulated, paper, simulate, sizes_of
from robolaser.simulation.nominal import DRAWN
from robolaser.simulation.sensors import camera

KINDS = ("stripe", "camera", "point", "pose", "profile", "socket")
BENT = {"joint_offset:joint_2": 0.01, "link_geometry:joint_3.turn_x": 0.004, "link_geometry:joint_3": 2e-3}


@pytest.fixture(autouse=True, scope="module")
def few_views() -> Iterator[None]:
    """Choose poses of cameras among a quarter of the candidates."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(camera, "BATCH", 1000)
        yield


@pytest.fixture(scope="module")
def robot() -> Robot:
    return find_robot("scorbot_er7")


def rms(simulated: Simulated, *, effects: bool = True) -> float:
    model = Model(simulated.dataset, simulated.effects if effects else ())
    x = np.array([[simulated.truth[name] for name in model.parameters.names]])
    return float(np.sqrt(model.cost(x)[0] / len(simulated.dataset.points)))


def small(robot: Robot, kind: str = "stripe", **more: object) -> Simulated:
    return simulate_as_asked(robot, kind=kind, poses=6, points=12 if kind == "camera" else 3, seed=2, **more)


@cache
def plain_cell(kind: str) -> Dataset:
    return small(find_robot("scorbot_er7"), kind, speed=0.05).dataset


@pytest.mark.parametrize("kind", KINDS)
def test_with_effects_the_truth_leaves_nothing_but_the_nominal_model_does(robot, kind):
    simulated = small(robot, kind, effects=BENT | ({"laser_roll": 0.1} if kind == "stripe" else {}))
    assert rms(simulated) < 1e-11
    assert rms(simulated, effects=False) > 1e-4


OF_ARM = (Stage.JOINTS, Stage.LINKS, Stage.FLANGE)
"""What acts there is the same for every sensor: two measure it."""
MEASURED = [(effect, kind) for effect in EFFECTS for kind in (KINDS[1::3] if effect.stage in OF_ARM else KINDS)]


@pytest.mark.parametrize(("effect", "kind"), MEASURED, ids=lambda one: one if isinstance(one, str) else one.name)
def test_with_any_effect_the_truth_leaves_nothing_or_it_is_refused(robot, effect, kind):
    asked_of_lens = kind == "camera" and effect.site == "camera"  # a lens is described without what is asked for
    places = effect.locations(plain_cell(kind)) or (("camera",) if asked_of_lens else ())
    if not places:
        with pytest.raises(RobolaserError):
            small(robot, kind, speed=0.05, effects={effect.name: 1e-3})
        return
    place = places[min(1, len(places) - 1)]
    asked = {f"{effect.name}:{place}.{number}": typical for number, *_, typical in effect.amplitudes()}
    simulated = small(robot, kind, speed=0.05, effects=asked)
    assert rms(simulated) < (1e-7 if effect.name == "focus_breathing" else 1e-10)  # images settle to 1e-6 px
    assert rms(simulated, effects=False) > 1e-6
    shapes = {each.name: each.nominal for each in effect.nonlinear_parameters()}
    assert {name: simulated.truth[f"{effect.name}.{place}.{name}"] for name in shapes} == shapes


def test_an_effects_inner_number_may_be_given_within_its_bounds(robot):
    wave = {"transmission_error:joint_2": 3e-4, "transmission_error:joint_2.cycles": 160.0}
    assert small(robot, effects=wave).truth["transmission_error.joint_2.cycles"] == 160.0
    with pytest.raises(UsageError, match="cycles is 400, but its bounds are 10 and 330"):
        small(robot, effects={**wave, "transmission_error:joint_2.cycles": 400.0})


def test_a_coupled_joint_follows_one_near_by_and_never_itself(robot):
    truth = small(robot, effects={"joint_coupling": 1e-3}).truth
    others = [truth[f"joint_coupling.{joint}.other"] for joint in robot.joints]
    assert all(0 < abs(other - own) <= 2 for own, other in enumerate(others, 1))


@pytest.mark.parametrize("kind", KINDS)
def test_gross_errors_spoil_the_share_of_rows_that_was_asked_for_and_no_others(robot, kind):
    points = 6 if kind == "camera" else 3
    clean = simulate(robot, kind=kind, poses=12, points=points, seed=2)
    spoilt = simulate(robot, kind=kind, poses=12, points=points, seed=2, effects={"outliers": 0.25})
    count = len(clean.dataset.points)
    assert len(spoilt.gross) == round(0.25 * count)
    assert not len(clean.gross)
    assert spoilt.effects == ()
    model = Model(spoilt.dataset)
    off = model.residuals(np.array([[spoilt.truth[name] for name in model.parameters.names]]))[0]
    assert set(np.flatnonzero(np.linalg.norm(off, axis=-1) > 1e-9)) == set(spoilt.gross)


def test_more_than_half_the_rows_cannot_be_gross(robot):
    with pytest.raises(UsageError, match="share of outliers"):
        small(robot, effects={"outliers:image": 0.6})


def test_gross_errors_are_no_part_of_a_model(robot):
    with pytest.raises(UsageError):
        candidate_effects(["outliers"], small(robot).dataset)


@pytest.mark.parametrize("stripe_axis", ["u", "v"])
@pytest.mark.parametrize("placed", [True, False])
def test_the_target_is_flat_and_seen_wherever_it_lies(robot, placed, stripe_axis):
    simulated = small(robot, placed=placed, stripe_axis=stripe_axis, effects=BENT | {"laser_roll": -0.05})
    dataset = simulated.dataset
    assert rms(simulated) < 1e-11
    assert (dataset.points.xyz[:, 2] == 0.0).all()
    assert ("target.psi" in simulated.truth) is not placed
    assert dataset.stripe_axis == stripe_axis


def test_every_pixel_is_inside_the_image_and_every_point_before_the_camera(robot):
    simulated = simulate(robot, poses=20, points=8, effects={"laser_roll": 0.1}, seed=4)
    dataset = simulated.dataset
    assert ((dataset.points.pixel >= 0) & (dataset.points.pixel <= np.array(dataset.image_px) - 1)).all()
    model = Model(dataset, simulated.effects)
    values = {name: np.array([value]) for name, value in simulated.truth.items()}
    seen = scanner_geometry.in_camera(dataset.points.pixel[None], values, model.perturb(values), dataset.stripe_axis)
    assert (seen[0, :, 2] > 0.1).all()


@pytest.mark.parametrize("kind", KINDS)
def test_no_pose_is_outside_the_limits(robot, kind):
    q = small(robot, kind, noise=Noise(joint_rad=1e-4), effects=BENT).dataset.poses.q
    assert ((q > robot.lower) & (q < robot.upper)).all()


@pytest.mark.parametrize("kind", KINDS)
def test_time_goes_on_at_a_pace_that_the_arm_can_follow(robot, kind):
    poses = small(robot, kind).dataset.poses
    assert (np.abs(np.diff(poses.q, axis=0)).max(axis=1) / np.diff(poses.time_s) < 1.0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_files(robot, kind, tmp_path):
    noise = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=1e-5)
    for folder in ("one", "two"):
        save(small(robot, kind, noise=noise, effects=BENT).dataset, tmp_path / folder)
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


def test_another_seed_gives_another_cell(robot):
    one, two = simulate(robot, poses=3, points=3, seed=1), simulate(robot, poses=3, points=3, seed=2)
    assert one.truth["f"] != two.truth["f"]
    assert not np.array_equal(one.dataset.poses.q, two.dataset.poses.q)


def test_noise_moves_the_points_but_not_the_cell(robot):
    clean, noisy = small(robot), small(robot, noise=Noise(pixel_px=0.1, target_m=1e-4))
    assert clean.truth == noisy.truth
    np.testing.assert_array_equal(clean.dataset.poses.q, noisy.dataset.poses.q)


def test_noise_is_as_strong_as_asked_and_repeats_share_the_targets(robot):
    asked = {"poses": 30, "points": 20, "repeats": 3, "seed": 5}
    noise = Noise(pixel_px=0.2, target_m=1e-4, joint_rad=1e-4)
    clean, noisy = simulate_as_asked(robot, **asked).dataset, simulate_as_asked(robot, **asked, noise=noise).dataset
    pixel, target = noisy.points.pixel - clean.points.pixel, noisy.points.xyz - clean.points.xyz
    assert np.std(pixel) == pytest.approx(0.2, rel=0.05)
    assert np.std(target) == pytest.approx(1e-4, rel=0.06)
    assert np.std(noisy.poses.q - clean.poses.q) == pytest.approx(1e-4, rel=0.2)
    np.testing.assert_allclose(np.ptp(target.reshape(-1, 3, 3), axis=1), 0.0, atol=1e-15)
    assert (np.ptp(pixel.reshape(-1, 3, 2), axis=1) > 0).all()
    assert list(noisy.points.repeat[:4]) == [0, 1, 2, 0]


def test_a_trackers_noise_is_as_strong_as_asked(robot):
    asked = {"kind": "point", "poses": 100, "points": 3, "seed": 5}
    clean = simulate_as_asked(robot, **asked).dataset.points.xyz
    noisy = simulate_as_asked(robot, **asked, noise=Noise(point_m=2e-5)).dataset.points.xyz
    assert np.std(noisy - clean) == pytest.approx(2e-5, rel=0.1)


def test_a_data_set_says_only_what_it_is_told_of_its_noise(robot):
    noise = Noise(pixel_px=0.1, target_m=1e-4)
    assert small(robot, noise=noise).dataset.noise == noise
    assert small(robot, noise=noise, stated=Noise(target_m=1e-4)).dataset.noise == Noise(target_m=1e-4)
    assert small(robot).dataset.noise == Noise()


@pytest.mark.parametrize("kind", KINDS)
def test_a_simulated_data_set_loads_and_says_no_more_than_a_cell_would(robot, kind, tmp_path):
    simulated = small(robot, kind, noise=Noise(pixel_px=0.2, joint_rad=1e-5), effects=BENT)
    save(simulated.dataset, tmp_path / "set")
    dataset = load(tmp_path / "set")
    assert not dataset.warnings
    np.testing.assert_array_equal(dataset.poses.q, simulated.dataset.poses.q)
    told = " ".join(path.read_text() for path in (tmp_path / "set").iterdir())
    assert "joint_offset" not in told
    assert "link_geometry" not in told


def test_known_distances_between_sockets_are_the_true_ones(robot):
    simulated = small(robot, "socket")
    assert len(simulated.dataset.distances_m) == 2
    for one, other, distance in simulated.dataset.distances_m:
        ends = [np.array([simulated.truth[f"socket.{name}.{part}"] for part in "xyz"]) for name in (one, other)]
        assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(distance, abs=1e-12)
        assert distance > 0.005


def test_the_true_scanner_is_one_that_a_workshop_could_build(robot):
    for seed in range(5):
        truth = simulate(robot, poses=2, points=2, seed=seed).truth
        for name, (lower, _, upper) in DRAWN.items():
            assert lower <= truth[name] <= upper
        assert truth["s_u"] == pytest.approx(7.4e-6, rel=0.02)
        assert truth["k"] <= 1000


def test_the_papers_experiment_has_five_points_in_five_poses_and_table_2s_bounds(robot):
    dataset = paper(robot).dataset
    assert len(dataset.points) == 25
    assert len(dataset.poses) == 5
    assert (np.bincount(dataset.points.pose) == 5).all()
    assert dataset.noise == Noise()
    assert (dataset.points.xyz[:, 2].std(), dataset.points.pixel.shape) == (pytest.approx(3e-4, rel=0.5), (25, 2))
    bounds = {name: (item.lower, item.upper) for name, item in dataset.parameters.items()}
    table_2 = {
        "f": (6e-3, 10e-3), "s_u": (5e-6, 1e-4), "s_v": (5e-6, 1e-4), "u_0": (290, 340), "v_0": (200, 250),
        "k": (0, 1e5), "b": (0.1, 0.2), "theta": (0, np.pi / 4), "t_x": (0.05, 0.1), "t_y": (-0.01, 0),
        "t_z": (-0.1, -0.05),
    } | dict.fromkeys(("w", "phi", "psi"), (-np.pi / 36, np.pi / 36))  # fmt: skip
    assert bounds == {name: pytest.approx(pair, abs=1e-12) for name, pair in table_2.items()}


def test_the_papers_experiment_fixes_all_but_the_gauge(robot):
    simulated = paper(robot)
    model = Model(simulated.dataset)
    x = np.array([simulated.truth[name] for name in model.parameters.names])
    step = 1e-6 * np.diag(model.parameters.width)
    forward, backward = model.residuals(x + step), model.residuals(x - step)
    values = np.linalg.svd(((forward - backward) / 2e-6).reshape(len(x), -1), compute_uv=False) * 1e3
    assert values[10] > 2.0
    assert values[12] > 2e-3
    assert values[13] < 1e-5


ONE_OF_A_MAKE = list({(entry.maker, len(entry.joints)): entry for entry in known_robots()}.values())
"""For these: the postures of the other sensors are searched for, or are those of a tracker."""
SIMULATED = [(entry, kind) for entry in known_robots() for kind in ("stripe", "point")]
SIMULATED += [(entry, kind) for entry in ONE_OF_A_MAKE for kind in ("camera", "pose", "profile", "socket")]


@pytest.mark.parametrize(("entry", "kind"), SIMULATED, ids=lambda one: one if isinstance(one, str) else one.name)
def test_every_robot_that_is_known_can_be_simulated(entry, kind):
    try:
        robot = find_robot(entry.name)
    except DependencyMissing:
        pytest.skip("its package is not installed")
    simulated = small(robot, kind)
    assert rms(simulated) < 1e-11
    assert ((simulated.dataset.poses.q >= robot.lower) & (simulated.dataset.poses.q <= robot.upper)).all()


@pytest.mark.parametrize(
    ("demand", "error", "message"),
    [
        ({"kind": "sonar"}, UsageError, "point or pose or profile or socket or stripe"),
        ({"poses": 0}, UsageError, "number of poses 0"),
        ({"stripe_axis": "x"}, UsageError, "stripe_axis 'x': expected u or v"),
        ({"kind": "profile", "mount": "foo"}, UsageError, "mount 'foo': expected flange or base"),
        ({"kind": "socket", "repeats": 2}, UsageError, "number of repeats"),
        ({"kind": "socket", "poses": 2, "points": 3}, UsageError, "each of 3 sockets"),
        ({"effects": {"joint_offset:joint_2": 0.5}}, UsageError, "Are these degrees"),
        ({"effects": {"joint_offset:joint_9": 0.01}}, UsageError, "joint_9"),
        ({"effects": {"joint_offset:joint_2.gain": 0.01}}, UsageError, "gain"),
        ({"effects": {"laser_rol": 0.01}}, RobolaserError, "laser_roll"),
        ({"effects": {"laser_roll": 0.5, "joint_offset": -0.1}, "poses": 20, "points": 8},
         EffectError, "20 poses .* only 1[0-9] still .* smaller effects"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_a_reason(robot, demand, error, message):
    with pytest.raises(error, match=message):
        simulate_as_asked(robot, **{"poses": 4, "points": 2, "seed": 1} | demand)


def test_what_is_no_seed_is_refused_wherever_one_is_taken(robot):
    of_robot = [partial(made, robot) for made in (simulate, simulate_motion)]
    of_data = [partial(made, plain_cell("point")) for made in (robolaser.diagnose, robolaser.plan)]
    for seeded in (*of_robot, *of_data, robolaser.Plan):
        for seed in (-1, 1.5):
            with pytest.raises(UsageError, match=f"seed is {seed}, expected a whole number"):
                seeded(seed=seed)


def test_sizes_are_read_as_they_are_typed():
    assert sizes_of(["laser_roll=0.1", "joint_offset:joint_2=-2e-3"]) == {
        "laser_roll": 0.1,
        "joint_offset:joint_2": -0.002,
    }
    for text in ("laser_roll", "laser_roll=", "=1", "laser_roll=nan", "laser_roll=1°"):
        with pytest.raises(UsageError, match="NAME"):
            sizes_of([text])
    with pytest.raises(UsageError, match=r"laser_roll is stated twice, with 0.1 and 0.2"):
        sizes_of(["laser_roll=0.1", "laser_roll=0.2"])


def test_an_effect_without_a_place_sits_at_every_place(robot):
    simulated = small(robot, effects={"joint_offset": 0.002})
    assert [candidate_effect.where for candidate_effect in simulated.effects] == list(robot.joints)
    assert simulated.truth["joint_offset.joint_4.offset"] == 0.002


def test_an_arm_that_moves_at_the_exposure_says_how_fast(robot):
    assert small(robot).dataset.poses.qd is None
    assert 0.1 < np.abs(small(robot, speed=0.2).dataset.poses.qd).max() <= 0.2


def test_readings_are_rounded_to_the_steps_and_distances_known_only_so_well_as_is_stated(robot):
    exact = simulate_as_asked(robot, kind="socket", poses=12, points=3, seed=2).dataset
    step, sigma = 2e-3, 1e-3
    noise = Noise(joint_step_rad=step, distance_m=sigma)
    noisy = simulate_as_asked(robot, kind="socket", poses=12, points=3, seed=2, noise=noise).dataset
    assert step / 4 < np.abs(noisy.poses.q - exact.poses.q).max() <= step / 2
    assert np.allclose(np.remainder(noisy.poses.q / step + 0.5, 1.0), 0.5)
    apart = [a[2] - b[2] for a, b in zip(noisy.distances_m, exact.distances_m, strict=True)]
    assert 0.0 < np.abs(apart).max() < 4 * sigma


@pytest.mark.parametrize("mount", ["flange", "base"])
@pytest.mark.parametrize("kind", ["camera", "profile"])
def test_a_sensor_that_all_sessions_share_sees_its_target_in_each_of_them(kind, mount):
    made = simulate(find_robot("ur5"), kind=kind, poses=10, options=CellOptions(mount=mount, sessions=2), seed=1)
    model = Model(made.dataset)
    truth = np.array([[made.truth[name] for name in model.parameters.names]])
    assert not any(name.startswith("hand_eye.") and "@" in name for name in made.truth)
    np.testing.assert_allclose(model.residuals_at(model.parameters.values(truth)), 0.0, atol=1e-8)
    assert len(np.unique(made.dataset.points.pose)) == 20
