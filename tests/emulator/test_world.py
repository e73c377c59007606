from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from true_stripe import TrueStripe, true_stripe

from robolaser.arrays import Array
from robolaser.cell.route import from_table
from robolaser.cli import main
from robolaser.data.cell_config import load_cell
from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import describe
from robolaser.emulator.world.world import EmulatedWorld, load_world
from robolaser.errors import RobolaserError
from robolaser.estimation import optimal_poses
from robolaser.estimation.optimal_poses import planned
from robolaser.geometry.rigid_motion import from_angles, pose
from robolaser.model.sensors.placements import motion
from robolaser.vision.board import find_board
from robolaser.vision.target import target_in

EXAMPLES = Path(__file__).parents[2] / "examples"
CELL, THINGS = EXAMPLES / "cell", EXAMPLES / "scan-cell"
Q = np.array([0.1, -0.7, 1.2, -0.5, 0.2])
PLAY = 0.004
LEVEL = np.array([0.0, -0.9, 1.3, -0.4, 0.0])
"""A posture from which the camera looks straight down."""


@pytest.fixture(scope="module")
def hobby(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new cell of an arm with a camera."""
    folder = tmp_path_factory.mktemp("hobby") / "cell"
    assert main(["new", "cell", "so101", "--camera", "--poses", "2", "--output", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture(scope="module")
def description() -> Dataset:
    return describe(CELL)


def world(description: Dataset, tmp_path: Path, *lines: str) -> EmulatedWorld:
    """A world that has what the lines say, and nothing else."""
    path = tmp_path / "world.toml"
    path.write_text("\n".join(['format = "robolaser-world/1"', *lines]), encoding="utf-8")
    return load_world(path, description)


def effect(name: str, where: str, size: float) -> str:
    return f'[[effect]]\nname = "{name}"\nwhere = "{where}"\nsize = {size}\n'


def stripe(world: EmulatedWorld) -> TrueStripe:
    return true_stripe(world.scene, world.T_base_camera)


def went(world: EmulatedWorld, *path: Array) -> Array:
    for q in path:
        world.follow(q)
    return world.q


def test_without_departures_the_arm_stands_where_its_model_says(description: Dataset, tmp_path: Path) -> None:
    here = world(description, tmp_path, "[floor]")
    v = {name: np.array(item.nominal) for name, item in description.parameters.items()}
    turn = from_angles(v["w"], v["phi"], v["psi"], order="xyz")
    T_flange_camera = pose(turn, np.array([v[f"t_{axis}"] for axis in "xyz"]))
    T_base_flange = description.robot.forward(Q[None, None])[0, 0]
    here.follow(Q)
    np.testing.assert_allclose(here.T_base_camera, T_base_flange @ T_flange_camera, atol=1e-12)
    np.testing.assert_allclose(here.T_base_flange, T_base_flange, atol=1e-12)


def test_a_zero_that_is_off_turns_its_joint_and_no_other(description: Dataset, tmp_path: Path) -> None:
    here = world(description, tmp_path, effect("joint_offset", "joint_3", 0.002))
    np.testing.assert_allclose(went(here, Q, Q + 0.1) - (Q + 0.1), [0, 0, 0.002, 0, 0], atol=1e-12)


def test_the_link_hangs_behind_by_half_the_play(description: Dataset, tmp_path: Path) -> None:
    here = world(description, tmp_path, effect("backlash", "joint_2", PLAY))
    far = Q + np.array([0, 0.3, 0, 0, 0])
    up = went(here, Q, far) - far
    down = went(here, Q) - Q
    np.testing.assert_allclose(up, [0, -PLAY / 2, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(down, [0, PLAY / 2, 0, 0, 0], atol=1e-12)


def test_within_the_play_the_link_rests(description: Dataset, tmp_path: Path) -> None:
    here = world(description, tmp_path, effect("backlash", "joint_2", PLAY))
    rests = went(here, Q, Q + 0.2)
    for back in (0.1, 0.9, 0.3):
        np.testing.assert_allclose(went(here, Q + 0.2 - back * PLAY)[1], rests[1], atol=1e-12)


def test_small_steps_bring_the_link_where_one_stride_does(description: Dataset, tmp_path: Path) -> None:
    for start, end in ((0.0, 0.001), (0.0, 0.1), (0.1, 0.0985)):
        one, many = (world(description, tmp_path, effect("backlash", "joint_2", PLAY)) for _ in range(2))
        path = Q + np.linspace(start, end, 50)[:, None]
        np.testing.assert_allclose(went(many, *path), went(one, path[0], path[-1]), atol=1e-12)


def test_a_camera_without_a_laser_shows_the_board_where_opencv_projects_it(hobby: Path) -> None:
    cell = load_cell(hobby)
    board = cell.description.board
    here = load_world(hobby / "world.toml", cell.description)
    truth = here.truth
    here.follow(from_table(hobby / "poses.csv", cell.robot)[0].q)
    (found,) = target_in(here.photograph(np.random.default_rng(1), lit=True), board)
    x, y = np.meshgrid(np.arange(board.columns), np.arange(board.rows))
    corners = board.square_m * np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=-1)
    values = {name: np.array([value]) for name, value in truth.items()}
    T = np.linalg.inv(here.T_base_flange @ motion(values, "hand_eye")[0]) @ here.scene.solids[-1].T_base_board
    K = np.array([[truth["fx"], 0.0, truth["cx"]], [0.0, truth["fy"], truth["cy"]], [0.0, 0.0, 1.0]])
    lens = np.array([truth[name] for name in ("k1", "k2", "p1", "p2", "k3")])
    pixel, _ = cv2.projectPoints(corners, cv2.Rodrigues(T[:3, :3])[0], T[:3, 3], K, lens)
    off = np.linalg.norm(found.reshape(-1, 2) - pixel.reshape(-1, 2), axis=-1)
    assert np.isfinite(off).sum() >= 8
    assert np.nanmedian(off) < 0.1


def test_a_camera_says_what_is_not_known_of_it(hobby: Path, tmp_path: Path) -> None:
    camera = describe(hobby)
    known = "[truth]\nfx = 600\nfy = 600\ncx = 320\ncy = 240\n"
    known += "".join(f"hand_eye.{name} = 0\n" for name in ("x", "y", "z", "w", "phi", "psi"))
    with pytest.raises(RobolaserError, match=r"\[truth\] fx"):
        world(camera, tmp_path)
    with pytest.raises(RobolaserError, match="droop cannot be at 'shoulder'"):
        world(camera, tmp_path, known, effect("droop", "shoulder", 0.1))


def test_while_nothing_moves_noise_is_new_and_speckle_stays(tmp_path: Path, description: Dataset) -> None:
    still = world(description, tmp_path, "[light]\nspeckle = 0.3", "[camera]\nnoise_grey = 0.0", "[floor]")
    noisy = world(description, tmp_path, "[light]\nspeckle = 0.3", "[floor]")
    rng = np.random.default_rng(0)
    for here in (still, noisy):
        here.follow(LEVEL)
    one, again = (still.photograph(rng, lit=True) for _ in range(2))
    np.testing.assert_array_equal(one, again)
    assert (noisy.photograph(rng, lit=True) != noisy.photograph(rng, lit=True)).mean() > 0.3
    still.follow(LEVEL + 0.001)
    assert (still.photograph(rng, lit=True) != one).any()


def test_from_planned_postures_the_board_of_the_example_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(optimal_poses, "LEAST_CANDIDATES", 16)
    cell = load_cell(CELL)
    assert cell.warnings == ()
    here = load_world(CELL / "world.toml", cell.description)
    found = []
    for q in planned(cell.description, count=4, seed=3):
        here.follow(q)
        image = here.photograph(np.random.default_rng(1), lit=True)
        assert np.isfinite(stripe(here).at).sum() > 500
        found.append(find_board(image, columns=9, rows=6) is not None)
    assert sum(found) >= 3


def test_the_truth_is_within_the_bounds_of_the_example() -> None:
    description = describe(CELL)
    here = load_world(CELL / "world.toml", description)
    place = dict(zip(("target.x", "target.y", "target.z"), here.scene.solids[-1].T_base_board[:3, 3], strict=True))
    for name, value in {**here.truth, **place}.items():
        assert description.parameters[name].lower < value < description.parameters[name].upper
    assert here.faults == {("backlash", "joint_2"): 0.003}


def test_the_stripe_passes_over_ball_and_step_of_the_other_example() -> None:
    here = load_world(THINGS / "world.toml", load_cell(THINGS).description)
    table = np.genfromtxt(THINGS / "poses.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    q = np.stack([table[f"q_joint_{i}"] for i in range(1, 6)], axis=-1)
    solids = set()
    for row in q[::12]:
        here.follow(row)
        solids |= set(np.unique(stripe(here).solid))
    assert solids == {-1, 0, 1, 2}


@pytest.mark.parametrize(
    ("lines", "named"),
    [
        (["[flor]"], "floor"),
        (["[floor]\nhight_m = 0.1"], "height_m"),
        (["[[sphere]]\nradius_m = 0.1"], "centre_m"),
        (["[[sphere]]\ncentre_m = [0, 0, 0]\nradius_m = -1"], "radius_m"),
        (["[sphere]\nradius_m = 0.1"], r"\[\[sphere\]\]"),
        (["[truth]\nf = 'long'"], "f"),
        (["[camera]\nambient_grey = [1]"], "ambient_grey"),
        ([effect("backlsh", "joint_2", 0.1)], "backlash"),
        ([effect("backlash", "joint_9", 0.1)], "joint_2"),
        ([effect("backlash", "joint_2", -0.1)], "backlash has no sign"),
        ([effect("backlash", "joint_2", 0.1), effect("backlash", "joint_2", 0.2)], "one backlash at most"),
        (["floor = 3"], "floor"),
        (["[[sphere]]\ncentre_m = [0, 0, 0]\nradius_m = 0.1\ntone = -1"], "tone"),
        (["[[block]]\norigin_m = [0, 0, 0]\nsize_m = [0.1, 0, 0.1]"], "size_m"),
        (["[[block]]\norigin_m = [0, 0, 0]\nsize_m = [1, 1, 1]\nquat = [0, 0, 0, 0]"], "length 0"),
        (["[board]\norigin_m = [0, 0, 0]\nquat = [1, 1, 0, 0]"], r"\[board\] quat"),
        (["[camera]\nblur_px = -1"], "0 or more"),
        (["[light]\nspeckle = -0.1"], "0 or more"),
        (["[truth]\nf = 0"], "positive"),
        ([effect("backlash", "joint_2", 0.1) + "\nengagment = 0.1"], r"engagment"),
        (["[light"], "TOML"),
    ],
)
def test_a_world_that_cannot_be_says_why(lines: list[str], named: str, description: Dataset, tmp_path: Path) -> None:
    with pytest.raises(RobolaserError, match=named):
        world(description, tmp_path, *lines)


def test_a_world_needs_an_arm_a_camera_and_a_drawn_board(description: Dataset, tmp_path: Path) -> None:
    with pytest.raises(RobolaserError, match="--world"):
        world(replace(description, robot=None), tmp_path)
    with pytest.raises(RobolaserError, match="square_m"):
        world(replace(description, board=None), tmp_path, "[board]\norigin_m = [0, 0, 0]")
    (tmp_path / "w.toml").write_text('format = "robolaser-dataset/1"', encoding="utf-8")
    with pytest.raises(RobolaserError, match="format"):
        load_world(tmp_path / "w.toml", description)
