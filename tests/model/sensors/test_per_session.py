"""Several campaigns in one data set: the arm and the sensor are shared, where things stood is each campaign's own."""

from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked
from several import two_trackers

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.cli import main
from robolaser.data.joining import check_same_arm, join_sessions
from robolaser.data.loading import load
from robolaser.data.sessions import Sessions
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import DataError, EffectError, UsageError
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.effects.run import Run
from robolaser.model.forward_model import Model, batches_of, jacobian
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

OFFSET = 0.004
EFFECT = {"joint_offset:joint_3": OFFSET}
ANGLE = "joint_offset.joint_3.offset"
ROBOT = find_robot("scorbot_er7")


def cell(kind="point", sessions=2, **options):
    noise = Noise(pixel_px=0.05) if kind in ("stripe", "camera") else Noise(point_m=2e-5, angle_rad=1e-4)
    return simulate_as_asked(ROBOT, kind=kind, sessions=sessions, **{"poses": 12, "noise": noise, "seed": 4, **options})


def session(dataset, name):
    """One session by itself, as an ordinary data set."""
    one = dataset.of_poses(np.array(dataset.poses.session) == name)
    return replace(one, sessions=None, poses=replace(one.poses, session=None))


def near(model, truth, seed=0):
    """Values near the truth, (1, d)."""
    rng = np.random.default_rng(seed)
    exact = np.array([truth.get(name, 0.0) for name in model.parameters.names])
    return (exact + 1e-4 * rng.uniform(-1, 1, len(exact)) * np.minimum(1.0, model.parameters.width))[None]


@pytest.mark.parametrize("kind", ["point", "pose", "profile", "socket", "stripe", "camera"])
def test_with_the_true_parameters_and_no_noise_nothing_is_left(kind):
    made = cell(kind, noise=None, effects=EFFECT, placed=False)
    model = Model(made.dataset, candidate_effects(["joint_offset:joint_3"], made.dataset))
    values = {name: np.array([value]) for name, value in made.truth.items()}
    assert np.abs(model.residuals_at(values)).max() < 1e-8


@pytest.mark.parametrize("kind", ["point", "pose", "profile", "socket", "stripe", "camera"])
def test_each_session_has_the_residuals_of_the_ordinary_data_set_it_is(kind):
    made = cell(kind, placed=False)
    model = Model(made.dataset)
    x = near(model, made.truth)
    values, whole = model.parameters.values(x), model.residuals(x)
    of_row = made.dataset.session_of_pose[made.dataset.points.pose]
    for number, name in enumerate(made.dataset.sessions.names):
        alone = Model(session(made.dataset, name))
        own = {
            plain: values[made.dataset.sessions.named(plain, name)]
            for plain in alone.blocks.free + alone.blocks.derived
        }
        np.testing.assert_array_equal(alone.residuals_at(own), whole[:, of_row == number])


def test_one_fit_of_two_sessions_finds_the_arm_better_than_either_and_each_base():
    made = cell(effects=EFFECT, poses=16)
    plan = Plan(effects=("joint_offset:joint_3",))
    both = calibrate(made.dataset, plan)
    assert as_json(both)["rows"][0]["rows"] == len(made.dataset.points)
    std = dict(zip(both.model.parameters.names, both.std, strict=True))
    alone = [calibrate(session(made.dataset, name), plan) for name in made.dataset.sessions.names]
    for one in alone:
        assert std[ANGLE] < one.std[one.model.parameters.names.index(ANGLE)]
    assert abs(both.value(ANGLE) - OFFSET) < 4 * std[ANGLE]
    for name in ("base.x@session-1", "base.x@session-2", "base.psi@session-2", "tool.1.z"):
        assert abs(both.value(name) - made.truth[name]) < 4 * std[name]
    assert both.held_out_rms_m < 5e-5


def test_base_and_target_are_each_sessions_own_and_the_rest_is_shared():
    names = Model(cell().dataset).parameters.names
    assert {"base.x@session-1", "base.x@session-2", "tool.0.x"} <= set(names)
    assert "base.x" not in names
    scanner = Model(cell("stripe", placed=False).dataset).parameters.names
    assert {"f", "target.x@session-1", "target.x@session-2"} <= set(scanner)
    sockets = Model(cell("socket").dataset).parameters.names
    assert {"tool.ball.x", "socket.0.x@session-1", "socket.0.x@session-2"} <= set(sockets)


def test_own_replaces_the_list_of_what_is_each_sessions_own():
    dataset = cell().dataset
    names = Model(replace(dataset, sessions=replace(dataset.sessions, own=("tool.*",)))).parameters.names
    assert {"base.x", "tool.0.x@session-1", "tool.0.x@session-2"} <= set(names)


def test_a_parameter_is_given_for_all_sessions_or_for_one():
    every = Parameter("base.x", "m", 2.5, 1.0, 4.0)
    one = Parameter("base.x@session-2", "m", 2.6, 2.0, 3.0)
    dataset = replace(cell().dataset, parameters={item.name: item for item in (every, one)})
    items = {item.name: item for item in Model(dataset).parameters.items}
    assert items["base.x@session-1"] == replace(every, name="base.x@session-1")
    assert items["base.x@session-2"] == one


def test_the_file_gives_a_parameter_of_one_session_by_its_full_name(tmp_path):
    save(cell().dataset, tmp_path / "cell")
    with (tmp_path / "cell" / "dataset.toml").open("a") as file:
        file.write('\n[parameters]\n"base.w@session-2" = { nominal = 0.01, lower = -0.1, upper = 0.1 }\n')
    (item,) = (item for item in Model(load(tmp_path / "cell")).parameters.items if item.given)
    assert item == Parameter("base.w@session-2", "rad", 0.01, -0.1, 0.1)


def test_known_distances_hold_between_the_sockets_of_each_session():
    known = Model(replace(cell("socket").dataset, distances_m=(("0", "1", 0.3),))).known_distances
    assert [names[0][:10] for names in known.first] == ["socket.0.x", "socket.0.x"]
    assert {names[0].rpartition("@")[2] for names in known.second} == {"session-1", "session-2"}


def test_paths_and_drifts_begin_anew_with_each_session():
    dataset = cell().dataset
    run = Run(dataset)
    for name, poses in zip(dataset.sessions.names, run.paths, strict=True):
        alone = Run(session(dataset, name))
        np.testing.assert_array_equal(run.progress[poses], alone.progress)
        np.testing.assert_array_equal(run.approach[poses], alone.approach)
        assert (run.approach[poses[0]] == 0).all()


@pytest.mark.parametrize("effect", [kind.name for kind in EFFECTS if not kind.begins])
def test_an_effect_does_in_a_session_what_it_does_in_a_data_set_of_its_own(effect):
    """Here both have the same poses: else the target's extent and the largest load are those of all."""
    made = cell("stripe", sessions=2, poses=6, speed=0.1)
    twice = join_sessions({"a": session(made.dataset, "session-1"), "b": session(made.dataset, "session-1")}, name="2")
    try:
        effects = candidate_effects([effect], twice)
    except EffectError as impossible:
        pytest.skip(str(impossible))
    model, alone = Model(twice, effects[:1]), Model(session(made.dataset, "session-1"), effects[:1])
    x = near(alone, made.truth, seed=2) + 0.01 * np.isin(alone.parameters.names, alone.effect_parameters.names)
    x = np.clip(x, alone.parameters.lower, alone.parameters.upper)
    both = model.residuals_at(alone.parameters.values(x))
    np.testing.assert_allclose(both, np.concatenate([alone.residuals(x)] * 2, axis=1), atol=1e-12)


def test_a_diagnosis_of_two_sessions_finds_the_effect_that_they_share():
    made = cell(effects=EFFECT, poses=12)
    found = examine(made.dataset, [kind for kind in EFFECTS if kind.name in ("joint_offset", "base_shift")], seed=1)
    assert found.verdict == "explained"
    assert str(found.findings[0].candidate_effect) == "joint_offset at joint_3"
    assert diagnosis_json(found)["gap_mm"]["after"] < 0.05


def test_a_base_that_moved_in_one_of_two_sessions_is_found_there_and_at_its_size():
    dataset = cell("point", poses=20, seed=2).dataset
    late = (dataset.session_of_pose == 1) & (np.arange(40) % 20 >= 10)
    xyz = dataset.points.xyz + late[dataset.points.pose, None] * np.array([1e-3, 0.0, 5e-4])
    found = examine(replace(dataset, points=replace(dataset.points, xyz=xyz)), seed=0)
    (shift,) = found.findings
    assert (str(shift.candidate_effect), found.verdict) == ("base_shift at base", "explained")
    assert np.hypot(*(shift.parameters[axis].value for axis in "xy")) == pytest.approx(1e-3, rel=0.1)
    assert shift.parameters["moment"].value == pytest.approx(0.75, abs=0.02)


def test_a_base_that_moves_once_is_not_simulated_in_every_session():
    with pytest.raises(UsageError, match="base_shift at base happens at one moment"):
        cell(effects={"base_shift:base": 1e-3})


def test_a_data_set_with_sessions_reads_the_same_after_writing(tmp_path):
    dataset = cell().dataset
    dataset = replace(dataset, sessions=replace(dataset.sessions, own=("base.*", "tool.*")))
    save(dataset, tmp_path / "cell")
    again = load(tmp_path / "cell")
    assert again.poses.session == dataset.poses.session
    assert again.sessions == dataset.sessions
    assert "session" not in again.poses.extra
    assert Model(again).parameters.names == Model(dataset).parameters.names


def test_simulate_makes_campaigns_that_share_what_is_not_their_own(tmp_path):
    typed = ["simulate", "--robot", "scorbot_er7", "--sensor", "point", "--poses", "4", "--sessions", "2", "--quiet"]
    assert main([*typed, "--output", str(tmp_path / "cell")]) == 0
    dataset = load(tmp_path / "cell")
    assert dataset.sessions.names == ("session-1", "session-2")
    assert len(dataset.poses) == 8
    assert (dataset.poses.time_s[[0, 4]] == 0).all()


def test_part_of_a_data_set_keeps_the_parameters_of_the_whole():
    """A block of large data may hold poses of one session only."""
    made = cell("stripe", sessions=3, poses=6, points=600, placed=False)
    model = Model(made.dataset)
    x = near(model, made.truth)
    parts = batches_of(model)
    assert len(parts) > 1
    whole, J = model.residuals(x), jacobian(model, x)
    for rows, part in parts:
        np.testing.assert_array_equal(part.residuals(x), whole[:, rows])
        np.testing.assert_allclose(jacobian(part, x), J[:, :, rows], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda rows: [row.replace(",session-2", ",") for row in rows], "column session"),
        (lambda rows: [*rows[:-1], rows[-1].replace(",session-2", ",session-3")], "'session-3' has 1 pose with points"),
    ],
)
def test_a_session_that_is_empty_or_has_too_few_poses_is_an_error(tmp_path, change, said):
    save(cell().dataset, tmp_path / "cell")
    poses = tmp_path / "cell" / "poses.csv"
    poses.write_text("\n".join(change(poses.read_text().splitlines())) + "\n")
    with pytest.raises(DataError) as refused:
        load(tmp_path / "cell")
    assert said in str(refused.value)


def test_an_empty_list_of_what_sessions_own_is_read_and_written_and_shares_all(tmp_path):
    made = cell().dataset
    shared = replace(made, sessions=replace(made.sessions, own=()), parameters={})
    save(shared, tmp_path / "cell")
    again = load(tmp_path / "cell")
    assert again.sessions == shared.sessions
    assert not any("@" in name for name in Model(again).parameters.names)


def test_a_table_of_sessions_without_the_column_is_an_error(tmp_path):
    save(session(cell().dataset, "session-1"), tmp_path / "cell")
    with (tmp_path / "cell" / "dataset.toml").open("a") as file:
        file.write('\n[sessions]\nown = ["tool.*"]\n')
    with pytest.raises(DataError, match=r"poses\.csv lacks column session"):
        load(tmp_path / "cell")


def test_a_camera_that_stands_in_the_cell_is_shared_unless_said_otherwise():
    made = simulate(
        find_robot("ur5"), kind="camera", poses=12, options=CellOptions(mount="base", placed=False), seed=1
    ).dataset
    halves = Sessions(("monday", "friday"))
    both = replace(made, poses=replace(made.poses, session=("monday",) * 6 + ("friday",) * 6), sessions=halves)
    assert "hand_eye.x" in Model(both).parameters.names
    moved = replace(both, sessions=replace(halves, own=("target.*", "hand_eye.*")))
    assert {"hand_eye.x@monday", "hand_eye.x@friday"} <= set(Model(moved).parameters.names)


def test_what_another_campaign_puts_anew_is_what_sessions_own_and_the_tool():
    assert {"left.base.x", "right.base.x", "tool.0.x"} <= set(Model(two_trackers(12)).blocks.setup_parameters)
    standing = simulate(
        find_robot("ur5"), kind="camera", poses=6, options=CellOptions(mount="base", placed=False)
    ).dataset
    assert {name.partition(".")[0] for name in Model(standing).blocks.sensor.setup_parameters} == {"hand_eye", "target"}


def test_what_is_own_must_be_a_parameter_of_the_sensor():
    dataset = cell().dataset
    wrong = replace(dataset, sessions=Sessions(dataset.sessions.names, ("tol.*",)))
    with pytest.raises(DataError, match=r"'tol\.\*' matches no parameter of this sensor, which has base\.\*, tool\.\*"):
        _ = Model(wrong).parameters


def test_only_campaigns_of_one_arm_can_be_joined():
    made = cell(poses=3).dataset
    other = simulate(find_robot("panda"), kind="point", poses=3, seed=1).dataset
    with pytest.raises(DataError, match="cannot be joined with"):
        join_sessions({"a": session(made, "session-1"), "b": other}, name="both")
    check_same_arm(made, made, "joined")
