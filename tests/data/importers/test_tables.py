"""Tables are read as they are said to be: separators, signs, units, turns; what is left open is asked for."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from examples import MAPPED, log_rows, tracked, written
from robolaser import find_robot, load
from robolaser.calibration.calibrate import calibrate
from robolaser.cli import main
from robolaser.data.dataset import Dataset
from robolaser.data.importers import ImportOptions
from robolaser.data.importers.tables import Tables
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, to_quaternion
from robolaser.geometry.units import FACTORS
from robolaser.model.sensors.placements import motion
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import random_configurations


@pytest.fixture(scope="module")
def arm() -> Robot:
    return find_robot("scorbot_er7")


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return tracked()


@pytest.fixture
def said(arm: Robot) -> ImportOptions:
    return ImportOptions(robot=arm, columns=MAPPED, units=("mm", "deg"), decimal=",", separator=";")


def read(path: Path | list[Path], options: ImportOptions) -> Dataset:
    return Tables().read(path if isinstance(path, list) else [path], options).checked()


def assert_same(read: Dataset, dataset: Dataset) -> None:
    assert read.poses.names == dataset.poses.names
    assert read.points.names == dataset.points.names
    np.testing.assert_array_equal(read.points.pose, dataset.points.pose)
    np.testing.assert_allclose(read.poses.q, dataset.poses.q, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(read.poses.time_s, dataset.poses.time_s, rtol=1e-14)
    np.testing.assert_allclose(read.points.xyz, dataset.points.xyz, rtol=1e-14)


@pytest.mark.parametrize("separator", [";", "\t", "|", " "])
@pytest.mark.parametrize("decimal", [",", "."])
@pytest.mark.parametrize(("length", "angle"), [("mm", "deg"), ("in", "mrad"), ("m", "rad")])
def test_separator_decimal_sign_and_units_change_nothing_of_what_is_read(
    separator, decimal, length, angle, said, dataset, tmp_path
):
    rows = log_rows(dataset, 1 / FACTORS["lengths"][length], 1 / FACTORS["angles"][angle])
    file = written(tmp_path / "log.txt", rows, separator=separator, decimal=decimal)
    assert_same(read(file, replace(said, separator=separator, decimal=decimal, units=(angle, length))), dataset)


def test_poses_and_points_may_come_in_two_files(said, dataset, tmp_path):
    rows = log_rows(dataset)
    poses = written(tmp_path / "poses.txt", [row[:7] for row in (rows[0], *rows[1::2])])
    points = written(tmp_path / "points.txt", [[row[0], *row[7:]] for row in rows])
    assert_same(read([poses, points], said), dataset)


def test_a_table_may_have_no_header_or_begin_below_other_rows(said, dataset, tmp_path):
    header, *rows = log_rows(dataset)
    bare = written(tmp_path / "bare.txt", rows)
    numbered = {column: str(header.index(source) + 1) for column, source in MAPPED.items()}
    assert_same(read(bare, replace(said, columns=numbered, header_row=0)), dataset)
    below = written(tmp_path / "below.txt", [["Tracker", "3"], [], header, *rows])
    assert_same(read(below, replace(said, header_row=3)), dataset)


def test_rows_without_a_pose_are_a_pose_each(said, dataset, tmp_path):
    header, *rows = log_rows(dataset)
    columns = {column: source for column, source in MAPPED.items() if column not in ("pose", "point")}
    found = read(written(tmp_path / "log.txt", [header, *rows[::2]]), replace(said, columns=columns, point="ball"))
    assert found.poses.names == tuple(str(2 + i) for i in range(len(rows[::2])))
    assert set(found.points.names) == {"ball"}


def test_a_further_column_is_kept_where_it_is_asked_for(said, dataset, tmp_path):
    rows = [[*row, "Feuchte" if i == 0 else 40.5] for i, row in enumerate(log_rows(dataset))]
    file = written(tmp_path / "log.txt", rows)
    assert read(file, said).poses.extra == {}
    assert Tables().read([file], said).left_out == ("log.txt: Feuchte",)
    kept = read(file, replace(said, columns={**MAPPED, "poses.humidity": "Feuchte"}))
    np.testing.assert_array_equal(kept.poses.coordinates["humidity"], 40.5)


def test_payload_and_temperature_are_kept(said, dataset, tmp_path):
    rows = [[*row, "kg" if i == 0 else 2.5, "°C" if i == 0 else 21.5] for i, row in enumerate(log_rows(dataset))]
    columns = {**MAPPED, "payload_kg": "kg", "temperature_c": "°C"}
    poses = read(written(tmp_path / "log.txt", rows), replace(said, columns=columns)).poses
    np.testing.assert_array_equal([poses.payload_kg, poses.temperature_c], [[2.5] * 8, [21.5] * 8])


@pytest.mark.parametrize("turned", ["quaternion", "euler", "rotation vector"])
def test_flange_poses_are_read_with_any_statement_of_their_turn(turned, dataset, tmp_path):
    T = dataset.flange()
    R = Rotation.from_matrix(T[:, :3, :3])
    values, names, more = {
        "quaternion": (R.as_quat(scalar_first=True), ("qw", "qx", "qy", "qz"), {}),
        "euler": (R.as_euler("ZYX", degrees=True), ("euler_1", "euler_2", "euler_3"), {"euler": "ZYX"}),
        "rotation vector": (R.as_rotvec(degrees=True), ("rotvec_x", "rotvec_y", "rotvec_z"), {}),
    }[turned]
    header = ["FX", "FY", "FZ", *"ABCD"[: len(names)], "X", "Y", "Z"]
    xyz = dataset.points.xyz[::2]
    rows = [[*(1e3 * T[i, :3, 3]).tolist(), *values[i].tolist(), *(1e3 * xyz[i]).tolist()] for i in range(len(T))]
    file = written(tmp_path / "flange.csv", [header, *rows], separator=",", decimal=".")
    flange = {"poses.x_m": "FX", "poses.y_m": "FY", "poses.z_m": "FZ", **dict(zip(names, "ABCD", strict=False))}
    columns = {**flange, "points.x_m": "X", "points.y_m": "Y", "points.z_m": "Z"}
    found = read(file, ImportOptions(columns=columns, units=("mm", "deg"), point="ball", **more))
    assert found.robot is None
    np.testing.assert_allclose(found.poses.T_base_flange, T, atol=1e-9)
    np.testing.assert_allclose(found.points.xyz, xyz, rtol=1e-12)
    for sequence in ["Zyx", "xxy", "zy", "xyzx", "rpy"] if turned == "euler" else []:
        with pytest.raises(UsageError, match="expected three axes"):
            read(file, ImportOptions(columns=columns, units=("mm", "deg"), point="ball", euler=sequence))


OPEN = {
    "units": ({"units": ()}, "In which unit are angles, such as A1"),
    "twice": ({"units": ("deg", "rad")}, "deg and rad are both of angles"),
    "unknown": ({"units": ("mm", "grad")}, "no unit 'grad'"),
    "robot": ({"robot": None, "columns": {"q_joint_1": "A1"}}, r"q_joint_1: .* Name the arm with --robot"),
    "joint": ({"columns": {k: v for k, v in MAPPED.items() if k != "q_joint_3"}}, "which column is q_joint_3"),
    "point": ({"columns": {k: v for k, v in MAPPED.items() if k != "point"}}, "which point is measured in each row"),
    "typing error": ({"columns": MAPPED | {"q_joint_9": "A1"}}, r"q_joint_9: no such column\. Did you mean"),
    "sign": ({"decimal": ";"}, "--separator and --decimal are both ';'"),
    "separator": ({"separator": None, "decimal": ";"}, "row has neither a comma nor a tab"),
    "point twice": ({"point": "ball"}, "--point ball: the column 'Prisma' names the points"),
    "no angles": ({"euler": "ZYX"}, "--euler ZYX: of which columns"),
    "no sensor": ({"sensor": "pint"}, r"--sensor pint: no such sensor\. Did you mean 'point'"),
    "sensor": ({"sensor": "stripe"}, "dataset.toml has to state more of a laser stripe scanner"),
}


@pytest.mark.parametrize("case", OPEN)
def test_what_is_left_open_is_asked_for(case, said, dataset, tmp_path):
    changed, message = OPEN[case]
    file = written(tmp_path / "log.txt", log_rows(dataset))
    with pytest.raises(UsageError, match=message):
        read(file, replace(said, **changed))


def test_a_place_that_may_be_the_flanges_or_the_points_is_asked_for(dataset, tmp_path):
    file = written(tmp_path / "log.txt", log_rows(dataset))
    with pytest.raises(UsageError, match=r"of the flange or of the point\? Write poses\.x_m or points\.x_m"):
        read(file, ImportOptions(columns={"x_m": "X"}, units=("mm", "deg"), separator=";", decimal=","))


WRONG = {
    "text": (3, 2, "hello", "log.txt, row 4, column A1: 'hello', expected a finite number", "A1"),
    "sign": (3, 8, "1.5", "log.txt, row 4, column X: '1.5', .* If '.' is the decimal sign, add --decimal '.'", "X"),
    "unit": (1, 3, "-3000", r"log.txt, row 2: q_joint_2 is -52\.36 rad, but the URDF .* degrees", None),
    "far": (2, 8, "1e9", "log.txt, row 3, column x_m: 1e[+]06 m is farther than any arm reaches", "x_m"),
    "moved": (4, 2, "3", "log.txt, row 5, column A1: pose 1 has another value than in row 4", "A1"),
    "same": (2, 7, "0", "log.txt, row 3: pose 0, point 0 was already in row 2", None),
    "no pose": (2, 0, "", "log.txt, row 3, column pose: empty", "pose"),
}


@pytest.mark.parametrize("case", WRONG)
def test_an_error_names_file_row_and_column(case, said, dataset, tmp_path):
    row, column, cell, message, named = WRONG[case]
    rows = log_rows(dataset)
    rows[row][column] = cell
    if case == "unit":
        rows[2][column] = cell
    with pytest.raises(DataError, match=message) as error:
        read(written(tmp_path / "log.txt", rows), said)
    assert error.value.file == "log.txt"
    assert error.value.row is not None
    assert named is None or error.value.column == named


@pytest.mark.parametrize("arm_named", [True, False])
def test_a_table_without_rows_is_an_error(arm_named, said, dataset, tmp_path):
    file = written(tmp_path / "log.txt", log_rows(dataset)[:1])
    if not arm_named:
        places = {f"{table}.{axis}_m": axis.upper() for table in ("poses", "points") for axis in "xyz"}
        turns = {f"euler_{i}": f"A{i}" for i in (1, 2, 3)}
        said = replace(said, robot=None, euler="XYZ", columns={"pose": "Nr", "point": "Prisma", **places, **turns})
    with pytest.raises(DataError, match=r"log\.txt has a header, but no row of a pose"):
        read(file, said)


@pytest.mark.parametrize("known", [True, False])
def test_whether_the_path_is_known_is_written(known, said, dataset, tmp_path):
    file = written(tmp_path / "log.txt", log_rows(dataset))
    assert read(file, replace(said, path_known=known)).path_known is known


def test_what_is_said_of_the_order_and_path_of_flange_poses_is_written_too(tmp_path):
    rows = [[f"{i}", 0.1 * i, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, "A", 1.0, 2.0, 3.0] for i in range(12)]
    header = ["pose", "X", "Y", "Z", "qx", "qy", "qz", "qw", "point", "x", "y", "z"]
    columns = {f"{table}.{axis}_m": name for table, names in (("poses", "XYZ"), ("points", "xyz")) for axis, name in
               zip("xyz", names, strict=True)}  # fmt: skip
    file = written(tmp_path / "log.csv", [header, *rows], separator=",", decimal=".")
    for ordered, path_known in ((True, True), (False, False)):
        options = ImportOptions(columns=columns, units=("m",), ordered=ordered, path_known=path_known)
        dataset = read(file, options)
        assert (dataset.time_is_order, dataset.path_known) == (ordered, path_known)
        assert dataset.poses.qd is None  # a number of the row is no second
        assert dataset.warnings == ()


def test_a_row_with_too_few_cells_is_named(said, dataset, tmp_path):
    rows = log_rows(dataset)
    rows[5] = rows[5][:-1]
    with pytest.raises(DataError, match=r"log\.txt, row 6: 10 cells, but there are 11 columns.* a semicolon"):
        read(written(tmp_path / "log.txt", rows), said)


def test_a_column_that_is_not_there_is_named_with_the_likeliest(said, dataset, tmp_path):
    file = written(tmp_path / "log.txt", log_rows(dataset))
    with pytest.raises(DataError, match=r"log\.txt has no column 'Prism', .* Did you mean 'Prisma'\?"):
        read(file, replace(said, columns=MAPPED | {"point": "Prism"}))


def test_a_robot_described_by_a_table_of_dh_numbers_is_a_urdf_in_the_data_set(tmp_path):
    (tmp_path / "raw").mkdir()
    dh = written(tmp_path / "raw" / "arm.csv", [["name", "a", "alpha", "d", "theta"], ["one", 0.0, 90.0, 300.0, 0.0]],
                 separator=",", decimal=".")  # fmt: skip
    log = written(
        tmp_path / "raw" / "log.csv",
        [["q_one", "x_m", "y_m", "z_m"], *([10.0 * i, 100.0 * i, 0.0, 0.0] for i in range(3))],
        separator=",",
        decimal=".",
    )
    words = ["--robot", str(dh), "--units", "mm,deg", "--point", "ball", "--output", str(tmp_path / "cell")]
    assert main(["import", str(log), *words]) == 2  # standard or modified?
    assert main(["import", str(log), *words, "--dh", "modified"]) == 0
    read_back = load(tmp_path / "cell")
    assert "<robot" in (tmp_path / "cell" / "robot.urdf").read_text("utf-8")
    np.testing.assert_allclose(read_back.flange()[0, :3, 3], [0, -0.3, 0], atol=1e-12)


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_a_camera_that_sees_several_tags_is_calibrated_from_their_poses(mount, arm, tmp_path, capsys):
    rng = np.random.default_rng(5)
    q = random_configurations(arm, 15, rng)
    T_base_flange, T_flange, T_base = arm.forward(q[None])[0], _somewhere(rng, 2), _somewhere(rng, 2)
    if mount == "flange":  # the camera is on the flange, both tags stand in the cell
        T_camera_tag = inverse(T_base_flange @ T_flange[0])[:, None] @ T_base
        expected = {"tool.camera": T_flange[0], "right.base": inverse(T_base[1])}
    else:
        T_camera_tag = inverse(T_base[0]) @ T_base_flange[:, None] @ T_flange
        expected = {"tool.left": T_flange[0], "tool.right": T_flange[1], "base": inverse(T_base[0])}
    poses = [",".join(["pose", *(f"q_{joint}" for joint in arm.joints)])]
    poses += [",".join(map(repr, [i, *row.tolist()])) for i, row in enumerate(q)]
    tags = ["pose,point,x_m,y_m,z_m,qx,qy,qz,qw"]
    for (i, k), T in zip(np.ndindex(15, 2), T_camera_tag.reshape(-1, 4, 4), strict=True):
        numbers = [*T[:3, 3].tolist(), *to_quaternion(T[:3, :3]).tolist()]
        tags.append(",".join([str(i), ("left", "right")[k], *map(repr, numbers)]))
    files = [tmp_path / "poses.csv", tmp_path / "tags.csv"]
    for file, lines in zip(files, (poses, tags), strict=True):
        file.write_text("\n".join(lines))
    typed = ["import", *map(str, files), "--robot", arm.name, "--sensor", "pose", "--units", "m,rad", "--quiet"]
    assert main([*typed, "--set", f"mount={mount}", "--output", str(tmp_path / "cell")]) == 0
    if mount == "flange":  # each tag is a sensor, whose name is that of a file
        files[1].write_text("\n".join(tags).replace("left", "ä").replace("right", "ö"))
        assert main([*typed, "--set", "mount=flange", "--output", str(tmp_path / "other")]) == 1
        assert "The tags 'ä' and 'ö' would both be called '_'." in capsys.readouterr().err
    found = calibrate(load(tmp_path / "cell"))
    values = {name: np.array([value]) for name, value in zip(found.model.parameters.names, found.x, strict=True)}
    for place, T in expected.items():
        np.testing.assert_allclose(motion(values, place)[0], T, atol=1e-6)


def _somewhere(rng: np.random.Generator, count: int) -> np.ndarray:
    return pose(exp_so3(rng.uniform(-1.0, 1.0, (count, 3))), rng.uniform(-0.3, 0.3, (count, 3)))


def test_a_mount_is_only_of_cameras_that_see_tags(said, tmp_path):
    with pytest.raises(UsageError, match="--set mount is only for a camera that sees tags"):
        read(tmp_path / "log.csv", replace(said, further={"mount": "flange"}))
