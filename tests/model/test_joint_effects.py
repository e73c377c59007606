from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.model.effects.backlash import Backlash
from robolaser.model.effects.encoder_eccentricity import EncoderEccentricity
from robolaser.model.effects.encoder_scale import EncoderScale
from robolaser.model.effects.joint_compliance import JointCompliance
from robolaser.model.effects.joint_coupling import JointCoupling
from robolaser.model.effects.latency import Latency
from robolaser.model.effects.run import Run
from robolaser.model.effects.settling import Settling
from robolaser.model.effects.thermal_drift import ThermalDrift
from robolaser.model.effects.transmission_error import TransmissionError
from robolaser.robot.by_name import find_robot

PLAY = 0.01
ONE = np.ones(1)


def arm(q: Array, *, time_s: Array | None = None, **measured: Array) -> Dataset:
    """The SCORBOT in given postures, (n, 5)."""
    names = tuple(map(str, range(len(q))))
    time_s = np.arange(len(q)) * 10.0 if time_s is None else time_s
    poses = Poses(names, time_s=time_s, q=q, qd=np.full(q.shape, 0.1), **measured)
    return Dataset("arm", poses, Points(np.empty(0, dtype=np.int64), ()), kind="point", robot=find_robot("scorbot_er7"))


def moving(values: list[float], joint: int = 2) -> Dataset:
    q = np.zeros((len(values), 5))
    q[:, joint] = values
    return arm(q)


def lag(dataset: Dataset, play: float = PLAY, start: float = 0.0) -> Array:
    """How far joint 3 is ahead of its reading."""
    q = dataset.poses.q[None]
    return (Backlash("joint_3", np.array([play]), np.array([start])).apply(q, Run(dataset)) - q)[0, :, 2]


def anywhere(seed: int, poses: int = 8) -> Array:
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (poses, 5))


def test_after_long_moves_a_joint_hangs_back_by_half_the_play_on_the_side_it_came_from() -> None:
    np.testing.assert_allclose(lag(moving([0.0, 0.5, 0.9, 0.2, 0.6])), [0, -PLAY / 2, -PLAY / 2, PLAY / 2, -PLAY / 2])


def test_a_move_within_the_play_leaves_the_link_where_it_is() -> None:
    back = moving([0.0, 0.5, 0.5 - 0.3 * PLAY, 0.5 - 0.6 * PLAY])
    np.testing.assert_allclose((back.poses.q[:, 2] + lag(back))[1:], 0.5 - PLAY / 2, atol=1e-15)


def test_a_joint_that_does_not_move_keeps_its_side() -> None:
    np.testing.assert_allclose(lag(moving([0.0, 0.5, 0.5, 0.5]))[1:], -PLAY / 2)


def test_play_depends_on_the_time_of_poses_and_not_on_their_place_in_the_file() -> None:
    whole = arm(anywhere(1))
    shuffle = np.random.default_rng(2).permutation(8)
    np.testing.assert_array_equal(lag(replace(whole, poses=whole.poses.take(shuffle))), lag(whole)[shuffle])


def test_the_first_pose_stands_where_in_the_play_it_is_said_to_stand() -> None:
    assert lag(moving([0.0, 0.5]), start=1.0)[0] == PLAY / 2
    assert lag(moving([0.0, 0.5]), start=-1.0)[0] == -PLAY / 2


def test_a_negative_play_pushes_ahead_by_as_much() -> None:
    whole = arm(anywhere(3))
    np.testing.assert_allclose(lag(whole, -PLAY), -lag(whole, PLAY))


def yielding(joint: int, compliance: float, *, payload: float = 0.0, hardening: float = 0.0) -> JointCompliance:
    return JointCompliance(f"joint_{joint}", compliance * ONE, payload * ONE, hardening * ONE)


def test_a_joint_gives_way_by_its_compliance_times_pinocchios_gravity_torque() -> None:
    dataset = arm(anywhere(4))
    model = pinocchio.buildModelFromXML(dataset.robot.urdf)
    borne = [pinocchio.computeGeneralizedGravity(model, model.createData(), q)[1] for q in dataset.poses.q]
    bent = yielding(2, 1e-4).apply(dataset.poses.q[None], Run(dataset))[0]
    np.testing.assert_allclose(bent[:, 1], dataset.poses.q[:, 1] - 1e-4 * np.array(borne), atol=1e-12)
    np.testing.assert_array_equal(np.delete(bent, 1, axis=1), np.delete(dataset.poses.q, 1, axis=1))


def test_an_arm_gives_way_downwards() -> None:
    dataset = arm(anywhere(5, poses=30))
    for joint in range(2, 5):
        sag = yielding(joint, 1e-4).apply(dataset.poses.q[None], Run(dataset))
        assert ((sag[0] - dataset.poses.q) * dataset.robot.gravity_torques(dataset.poses.q)).sum() < 0


def test_a_payload_is_borne_as_its_energy_says() -> None:
    q = anywhere(6)
    bare, loaded = arm(q), arm(q, payload_kg=np.full(8, 2.0))
    borne = Run(loaded).loads.gravity_torques - Run(bare).loads.gravity_torques
    step = 1e-6 * np.eye(5)[:, None]
    height = bare.robot.forward(q + step)[:, :, 2, 3] - bare.robot.forward(q - step)[:, :, 2, 3]
    np.testing.assert_allclose(borne, 2.0 * 9.81 * height.T / 2e-6, atol=1e-6)


def test_a_weight_at_the_flange_that_nobody_wrote_down_sinks_the_arm_as_one_written_down_does() -> None:
    q = anywhere(6)
    bare, loaded = arm(q), arm(q, payload_kg=np.full(8, 2.0))
    unwritten = yielding(3, 1e-4, payload=2.0 * 1e-4).apply(q[None], Run(bare))
    np.testing.assert_allclose(unwritten, yielding(3, 1e-4).apply(q[None], Run(loaded)), atol=1e-15)


def test_a_hardening_gear_gives_way_less_the_more_it_bears_and_a_softening_one_more() -> None:
    dataset = arm(anywhere(4, poses=30))
    q, run = dataset.poses.q[None], Run(dataset)
    even, hard, soft = ((yielding(2, 1e-4, hardening=h).apply(q, run) - q)[0, :, 1] for h in (0.0, 0.5, -0.5))
    load = np.argsort(np.abs(even))
    assert (np.diff((hard / even)[load]) < 0).all()
    assert (np.diff((soft / even)[load]) > 0).all()
    assert (hard / even)[load[-1]] == pytest.approx(0.5)
    np.testing.assert_allclose(hard + soft, 2 * even, atol=1e-15)


@pytest.mark.parametrize("cycles", [10.0, 50.0, 160.0])
def test_a_transmissions_error_comes_again_after_each_cycle(cycles: float) -> None:
    turn = 2 * np.pi / cycles
    dataset = moving(np.array([0.1, 0.1 + turn, 0.1 - 3 * turn]).tolist())
    wave = TransmissionError("joint_3", 3e-4 * ONE, -1e-4 * ONE, 1e-4 * ONE, 2e-4 * ONE, cycles * ONE)
    error = (wave.apply(dataset.poses.q[None], Run(dataset)) - dataset.poses.q)[0, :, 2]
    phase = cycles * 0.1
    by_hand = 3e-4 * np.sin(phase) - 1e-4 * np.cos(phase) + 1e-4 * np.sin(2 * phase) + 2e-4 * np.cos(2 * phase)
    np.testing.assert_allclose(error, by_hand, atol=1e-15)


def test_some_frequency_of_the_grid_explains_nine_tenths_of_any_wave() -> None:
    rng = np.random.default_rng(7)
    q = rng.uniform(-2.0, 2.0, 200)
    grid = TransmissionError.grid(moving(q.tolist()), "joint_3")[:, 0]
    for cycles in rng.uniform(10.0, 330.0, 40):
        wave = np.sin(cycles * q + rng.uniform(0, 2 * np.pi))
        near = grid[np.argsort(np.abs(grid - cycles))[:2]]
        left = [np.linalg.lstsq(np.column_stack([np.sin(n * q), np.cos(n * q)]), wave)[1][0] for n in near]
        assert min(left) < 0.1 * (wave**2).sum()


def test_a_joint_that_hardly_moves_has_few_frequencies_to_try() -> None:
    assert len(TransmissionError.grid(moving([0.0, 0.01, 0.02]), "joint_3")) < 10


def test_a_scaled_encoder_counts_a_share_of_every_move() -> None:
    dataset = arm(anywhere(8))
    bent = EncoderScale("joint_3", np.array([0.01])).apply(dataset.poses.q[None], Run(dataset))[0]
    np.testing.assert_allclose(np.diff(bent[:, 2]), 1.01 * np.diff(dataset.poses.q[:, 2]))


def test_an_eccentric_disc_reads_right_again_after_a_turn() -> None:
    dataset = moving([0.3, 0.3 + 2 * np.pi, 0.3 + np.pi])
    bent = EncoderEccentricity("joint_3", 1e-3 * ONE, 2e-3 * ONE).apply(dataset.poses.q[None], Run(dataset))[0]
    error = bent[:, 2] - dataset.poses.q[:, 2]
    np.testing.assert_allclose(error[1:], [error[0], -error[0]], atol=1e-15)


def test_a_late_exposure_sees_the_arm_where_it_has_moved_on_to() -> None:
    dataset = arm(anywhere(9))
    bent = Latency("timing", np.array([0.02, -0.02])).apply(dataset.poses.q[None], Run(dataset))
    np.testing.assert_allclose(bent[0], dataset.poses.q + 0.002)
    np.testing.assert_allclose(bent[1], dataset.poses.q - 0.002)


def test_an_arm_at_rest_cannot_tell_a_late_exposure() -> None:
    dataset = arm(anywhere(9))
    still = replace(dataset, poses=replace(dataset.poses, qd=np.zeros((8, 5))))
    unread = replace(dataset, poses=replace(dataset.poses, qd=None))
    assert Latency.missing(still) == "the arm stood still at every exposure"
    assert Latency.missing(unread) == "no joint velocities in the data"


def grown(dataset: Dataset, tau: float = 0.3) -> Array:
    placements = dataset.robot.placements[None, None]
    bent = ThermalDrift("joint_3", tau=tau * ONE, growth=1e-3 * ONE).apply(placements, Run(dataset))[0]
    return np.linalg.norm(bent[:, 2, :3, 3], axis=-1) / np.linalg.norm(dataset.robot.placements[2, :3, 3]) - 1


def test_a_link_grows_with_the_measured_temperature_where_there_is_one() -> None:
    dataset = arm(anywhere(10, poses=4), temperature_c=np.array([21.0, 31.0, 26.0, 21.0]))
    np.testing.assert_allclose(grown(dataset), [0, 1e-3, 5e-4, 0], atol=1e-15)
    assert len(ThermalDrift.grid(dataset, "joint_3")) == 1


def test_without_a_thermometer_a_link_grows_as_what_warms_up_with_time() -> None:
    dataset = arm(anywhere(10, poses=3), time_s=np.array([0.0, 50.0, 100.0]))
    np.testing.assert_allclose(grown(dataset, 0.5), 1e-3 * (1 - np.exp([0.0, -1.0, -2.0])), atol=1e-15)
    assert len(ThermalDrift.grid(dataset, "joint_3")) > 1


def test_where_time_only_orders_the_poses_the_run_goes_on_by_poses() -> None:
    uneven = arm(anywhere(10, poses=3), time_s=np.array([0.0, 1.0, 100.0]))
    np.testing.assert_allclose(Run(replace(uneven, time_is_order=True)).progress, [0, 0.5, 1])
    np.testing.assert_allclose(Run(uneven).progress, [0, 0.01, 1])


def test_growing_leaves_the_links_turn_and_the_other_links_alone() -> None:
    dataset = arm(anywhere(11))
    placements = dataset.robot.placements[None, None]
    bent = ThermalDrift("joint_3", tau=0.3 * ONE, growth=1e-3 * ONE).apply(placements, Run(dataset))
    np.testing.assert_array_equal(bent[0, -1, :, :3, :3], placements[0, 0, :, :3, :3])
    np.testing.assert_array_equal(np.delete(bent[0, -1], 2, axis=0), np.delete(placements[0, 0], 2, axis=0))


def test_a_joint_that_has_not_settled_is_short_of_its_goal_by_a_share_of_its_last_move() -> None:
    dataset = moving([0.0, 0.5, 0.9, 0.2])
    q = dataset.poses.q[None]
    short = (Settling("joint_3", 1e-3 * ONE).apply(q, Run(dataset)) - q)[0, :, 2]
    np.testing.assert_allclose(short, [0.0, -5e-4, -4e-4, 7e-4], atol=1e-15)


def test_the_last_move_is_that_in_time_and_not_in_the_file() -> None:
    whole = arm(anywhere(1))
    shuffle = np.random.default_rng(2).permutation(8)
    mixed = replace(whole, poses=whole.poses.take(shuffle))
    late, again = (Settling("joint_3", 1e-3 * ONE).apply(one.poses.q[None], Run(one))[0] for one in (whole, mixed))
    np.testing.assert_array_equal(again, late[shuffle])


@pytest.mark.parametrize("other", [1, 2, 5])
def test_a_coupled_joint_follows_the_joint_of_that_number(other: int) -> None:
    dataset = arm(anywhere(3))
    q = dataset.poses.q[None]
    follows = (JointCoupling("joint_4", 1e-3 * ONE, other * ONE, -2.0 * ONE).apply(q, Run(dataset)) - q)[0]
    np.testing.assert_allclose(follows[:, 3], 1e-3 * q[0, :, other - 1] + 2e-3, atol=1e-15)
    np.testing.assert_array_equal(np.delete(follows, 3, axis=1), 0)


def test_a_joint_is_coupled_with_its_neighbours_up_to_two_joints_away() -> None:
    dataset = arm(anywhere(3))
    assert set(JointCoupling.grid(dataset, "joint_1")[:, 0]) == {2, 3}
    assert set(JointCoupling.grid(dataset, "joint_3")[:, 0]) == {1, 2, 4, 5}


def test_no_spring_stands_for_what_rounding_alone_makes_of_a_vertical_joint() -> None:
    dataset = arm(np.random.default_rng(1).uniform(-1.0, 1.0, (8, 5)))
    soft = {"compliance": np.array([1e-3]), "payload": np.zeros(1), "hardening": np.zeros(1)}
    base, shoulder, *_ = dataset.robot.joints
    assert JointCompliance(base, **soft).parts(Run(dataset)) == ()
    (spring,) = JointCompliance(shoulder, **soft).parts(Run(dataset))
    assert spring.joint == shoulder
