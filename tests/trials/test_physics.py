"""Laws of the arms that MuJoCo moves: rigid as drawn, deflected by torque over stiffness, at rest on their springs."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, PHYSICAL
from robolaser.trials.synthetic.fault_models.loads import PlayUnderWeight
from robolaser.trials.synthetic.mujoco_arm import BRACKET, FOOT, MujocoArm, Spring

pytest.importorskip("mujoco", reason="MuJoCo is not installed")

from robolaser.trials.making import make

SMALL = Ranges(poses=(10, 11), points=(5, 5))
STIFF = 2e4


@pytest.fixture(scope="module", params=["scorbot_er7", "panda"])
def robot(request):
    return find_robot(request.param)


@pytest.fixture(scope="module")
def q(robot):
    lower, upper = np.maximum(robot.lower, -1.5), np.minimum(robot.upper, 1.5)
    return np.random.default_rng(3).uniform(lower, upper, (4, len(robot.joints)))


@pytest.fixture(params=PHYSICAL)
def fault(request, built):
    run, model = built.cell.run, FAULT_MODELS[request.param]
    return model.sample(model.locations(run)[-1], model.sizes[1], run, np.random.default_rng(2))


def test_a_rigid_arm_stands_where_the_package_says(robot, q):
    flange, bracket = MujocoArm(robot).at_rest(q)
    np.testing.assert_allclose(flange, robot.forward(q[None])[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(bracket, flange, rtol=0, atol=1e-12)


def test_two_engines_agree_on_the_weight_of_every_link(robot, q):
    gears = [Spring(joint, STIFF) for joint in robot.joints]
    np.testing.assert_allclose(MujocoArm(robot, gears).weights(q), robot.gravity_torques(q), atol=1e-5)


def test_a_drive_gives_way_by_torque_over_stiffness_to_first_order(robot, q):
    joint = robot.chain[1]
    sunk = q.copy()
    sunk[:, joint] -= robot.gravity_torques(q)[:, joint] / STIFF
    at_rest, _ = MujocoArm(robot, [Spring(robot.joints[joint], STIFF)]).at_rest(q)
    first_order, rigid = robot.forward(sunk[None])[0], robot.forward(q[None])[0]
    assert np.abs(at_rest - first_order).max() < 5e-3 * np.abs(at_rest - rigid).max()


def test_a_soft_base_tilts_by_its_overturning_moment(robot, q):
    arm = MujocoArm(robot, [Spring(FOOT, STIFF, axis, np.zeros(3)) for axis in np.eye(3)[:2]], 2.0)
    tilted, _ = arm.at_rest(q)
    turn = tilted[:, :3, :3] @ np.swapaxes(robot.forward(q[None])[0][:, :3, :3], 1, 2)
    np.testing.assert_allclose(
        np.stack([turn[:, 2, 1], turn[:, 0, 2]], axis=-1), -arm.weights(q) / STIFF, rtol=0.05, atol=2e-6
    )
    np.testing.assert_allclose(turn[:, 1, 0], 0.0, atol=1e-5)


def test_a_bracket_moves_beyond_the_flange_only(robot, q):
    hinge = Spring(BRACKET, 50.0, np.array([0.0, 1.0, 0.0]), np.zeros(3))
    flange, bracket = MujocoArm(robot, [hinge], 0.5).at_rest(q)
    np.testing.assert_allclose(flange, robot.forward(q[None])[0], rtol=0, atol=1e-12)
    assert np.abs(bracket[:, :3, :3] - flange[:, :3, :3]).max() > 1e-4


def test_the_weight_pushes_a_joint_with_play_to_the_end_that_hangs_lower(built):
    run = built.cell.run
    joint = run.joints[1]
    play = PlayUnderWeight(joint, 2e-3, 0.01)
    moved = run.robot.forward(run.q[None])[0] - play.flange(run.robot.forward(run.q), run)
    torque = run.torques(run.payload_kg)[:, run.column(joint)]
    sunk = run.q.copy()
    sunk[:, run.column(joint)] -= np.sign(torque) * play.size / 2
    by_half = run.robot.forward(run.q[None])[0] - run.robot.forward(sunk)
    assert np.abs(moved - by_half).max() < 0.25 * np.abs(by_half).max()


def test_a_fault_gives_way_by_its_size_at_most(fault, built):
    if fault.form == "play_under_weight":
        pytest.skip("its size is that of its play")
    run = built.cell.run
    assert np.abs(fault.arm(run, fault.stiffness(run)).weights(run.q)).max() / fault.stiffness(run) == pytest.approx(
        fault.size
    )


def test_of_no_size_nothing_gives_way(fault, built):
    plain, still = built.cell.seen(()), built.cell.seen((replace(fault, size=0.0),))
    np.testing.assert_allclose(still.pixel, plain.pixel, rtol=0, atol=1e-7)


def test_of_usual_size_the_data_show_it(fault, built):
    plain, bent = built.cell.seen(()), built.cell.seen((fault,))
    assert np.nanmax(np.abs(plain.pixel - bent.pixel)) > 0.05


def test_worlds_of_the_kind_physics_are_moved_by_mujoco(built):
    worlds = [make(find_robot("scorbot_er7"), "physics", seed=seed, ranges=SMALL) for seed in range(3)]
    forms = [item["form"] for world in worlds for item in world.truth["each"]]
    assert forms
    assert set(forms) <= set(PHYSICAL)
