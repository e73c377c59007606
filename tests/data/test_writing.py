import dataclasses

import numpy as np
import pytest

from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.loading import load
from robolaser.data.sensor_format import PIXEL, SensorFormat, sensor_format
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.errors import DataError, OutputError
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.sensors import REGISTERED
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot

WILD = 'a "quoted" \\ back\tslash, ümlaut 光 🤖 \x7f \x01 = [x] # no comment'


def assert_same(found: object, wanted: object, path: str = "dataset") -> None:
    if wanted is None or found is None:
        assert found is wanted, path
    elif isinstance(wanted, np.ndarray):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-15, err_msg=path)
    elif dataclasses.is_dataclass(wanted):
        for field in dataclasses.fields(wanted):
            if field.compare and field.name not in ("folder", "warnings"):
                assert_same(getattr(found, field.name), getattr(wanted, field.name), f"{path}.{field.name}")
    else:
        assert found == wanted, path


def a_stripe_data_set(**changes: object) -> Dataset:
    rng = np.random.default_rng(5)
    robot = find_robot("scorbot_er7")
    n, m = 4, 12
    dataset = Dataset(
        name="floor",
        robot=robot,
        poses=Poses(
            names=("a", "0", "pose, with comma", 'and "quotes"'),
            time_s=np.array([0.0, 0.1, 1 / 3, 1e9 / 7]),
            q=rng.uniform(-0.5, 0.5, (n, 5)),
            qd=rng.normal(size=(n, 5)) * 1e-7,
            image=tuple(f"images/{i}.png" for i in range(n)),
            temperature_c=np.array([20.0, 21.5, 22.0, 20.0]),
            extra={"height": ("20", "21.50", "22", ""), "remark, by hand": ("x", "y", "", "ü")},
        ),
        points=Points(
            pose=np.repeat(np.arange(3), 4),
            names=tuple(str(i // 2) for i in range(m)),
            repeat=np.tile(np.array([0, 1]), 6),
            pixel=rng.uniform(10, 400, (m, 2)),
            xyz=rng.normal(size=(m, 3)),
        ),
        parameters={
            name: Parameter(name, Stripe.format.unit_of(name), 1 / 3, -np.pi / 7, 1.1)
            for name in ("b", "theta", "target.x")
        },
        image_px=(640, 480),
    )
    return dataclasses.replace(dataset, **changes)


def without_robot(dataset: Dataset) -> Dataset:
    rng = np.random.default_rng(6)
    T = pose(exp_so3(rng.normal(size=(4, 3))), rng.normal(size=(4, 3)))
    return dataclasses.replace(
        dataset, robot=None, poses=dataclasses.replace(dataset.poses, q=None, qd=None, T_base_flange=T)
    )


def a_tracker_data_set() -> Dataset:
    stripe = a_stripe_data_set()
    points = dataclasses.replace(stripe.points, pixel=None)
    base = {name: Parameter(name, Stripe.format.unit_of(name), 0.1, -1.0, 1.0) for name in ("base.x", "base.psi")}
    noise = Noise(point_m=2e-5, distance_m=1e-5)
    return dataclasses.replace(stripe, kind="point", points=points, parameters=base, image_px=None, noise=noise)


def a_socket_data_set() -> Dataset:
    stripe = a_stripe_data_set()
    return dataclasses.replace(
        stripe,
        kind="socket",
        image_px=None,
        parameters={},
        points=Points(pose=np.arange(4), names=("left", "right", "left", "right")),
        distances_m=(("left", "right", 0.1 + 0.2),),
    )


CASES = {
    "plain": a_stripe_data_set(),
    "wild texts": a_stripe_data_set(name=WILD, source=WILD, licence=WILD),
    "without extras": a_stripe_data_set(poses=Poses(names=("a", "b", "c"), q=np.zeros((3, 5)))),
    "mounted otherwise": a_stripe_data_set(
        stripe_axis="v", bracket_quat=(0.5, 0.5, 0.5, -0.5), angles="zyz", board=Board(7, 6, 0.01), placed=False
    ),
    "noise": a_stripe_data_set(noise=Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)),
    "order only": a_stripe_data_set(time_is_order=True, path_known=False),
    "another gravity": a_stripe_data_set(robot=find_robot("scorbot_er7", gravity=(0.0, 9.81, 0.0))),
    "recording": a_stripe_data_set(points=Points(np.empty(0, dtype=np.int64), ())),
    "flange poses": without_robot(a_stripe_data_set()),
    "tracker": a_tracker_data_set(),
    "sockets": a_socket_data_set(),
}


@pytest.mark.parametrize("dataset", CASES.values(), ids=CASES.keys())
def test_what_is_saved_loads_as_it_was(dataset, tmp_path):
    save(dataset, tmp_path / "deep" / "set")
    assert_same(load(tmp_path / "deep" / "set"), dataset)


def test_saving_what_was_loaded_writes_the_same_files(tmp_path):
    save(a_stripe_data_set(), tmp_path / "one")
    save(load(tmp_path / "one"), tmp_path / "two")
    for file in ("dataset.toml", "poses.csv", "points.csv", "robot.urdf"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


@pytest.mark.parametrize("file", ["dataset.toml", "poses.csv", "points.csv"])
def test_a_data_set_is_never_overwritten_silently(file, tmp_path):
    (tmp_path / file).write_text("mine")
    with pytest.raises(OutputError, match=file):
        save(a_stripe_data_set(), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [file]
    assert (tmp_path / file).read_text() == "mine"


def test_overwriting_leaves_nothing_of_the_old_points(tmp_path):
    save(a_stripe_data_set(), tmp_path)
    save(CASES["recording"], tmp_path, overwrite=True)
    assert_same(load(tmp_path), CASES["recording"])


CORNERS = SensorFormat(
    kind="corner_camera", title="camera that sees corners",
    columns={"pixel": PIXEL, "corner": ("column", "row")}, numbers=2, unit="px", units={"fx": "px"},
)  # fmt: skip


def test_a_sensor_of_the_user_is_saved_and_loaded_by_its_declaration(tmp_path, monkeypatch):
    monkeypatch.setitem(REGISTERED, "corner_camera", type("CornerCamera", (), {"format": CORNERS}))
    points = Points(np.arange(2), ("a", "b"), pixel=np.eye(2), columns={"corner": np.arange(4.0).reshape(2, 2)})
    poses = Poses(("p", "q"), T_base_flange=np.eye(4)[None].repeat(2, 0))
    save(Dataset("board", poses, points, kind="corner_camera"), tmp_path)
    assert (tmp_path / "points.csv").read_text().splitlines()[0] == "pose,point,u_px,v_px,column,row"
    read = load(tmp_path)
    assert read.format is CORNERS
    np.testing.assert_array_equal(read.points["corner"], points["corner"])
    np.testing.assert_array_equal(read.points["pixel"], np.eye(2))
    assert "xyz" not in read.points


def test_an_array_that_is_not_there_is_named():
    with pytest.raises(DataError, match=r"points\.csv has no pixel"):
        Points(np.arange(1), ("a",))["pixel"]


def test_an_unknown_kind_is_an_error_that_names_the_likeliest():
    with pytest.raises(DataError, match=r"\[sensor\] kind: 'strip', expected .*\. Did you mean 'stripe'\?"):
        sensor_format("strip")


def test_a_parameter_has_the_unit_of_its_name_or_of_the_last_part_of_it():
    assert sensor_format("stripe").unit_of("s_u") == "m/px"
    assert sensor_format("stripe").unit_of("target.phi") == "rad"
    assert CORNERS.unit_of("fx") == "px"
    assert CORNERS.unit_of("k1") == ""
