"""Tables as people have them: rows that are poses, several points in a row, several files, lost beams."""

import datetime
import json
from pathlib import Path

import numpy as np
import pandas
import pytest
from scipy.io import savemat

import robolaser
from robolaser.cli import main
from robolaser.data.importers.table_files import read_any_table, read_arrays
from robolaser.robot.by_name import find_robot

ROBOT = find_robot("ur5")
REFLECTORS = ("R1", "R2", "R3")


def measured(poses: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles [deg] and the places of three reflectors [mm]."""
    q = np.random.default_rng(0).uniform(-1.5, 1.5, (poses, 6))
    offsets = np.array([[0.1, 0.0, 0.02], [0.0, 0.1, 0.03], [-0.08, -0.05, 0.1]])
    (T,) = ROBOT.forward(q[None])
    return np.degrees(q), 1e3 * (np.einsum("nij,pj->npi", T[:, :3, :3], offsets) + T[:, None, :3, 3])


def as_text(q: np.ndarray, xyz: np.ndarray, joints: str = "A{}", lost: tuple[tuple[int, int], ...] = ()) -> str:
    names = [f"{name} {axis}" for name in REFLECTORS for axis in "XYZ"]
    lines = [",".join([*(joints.format(i) for i in range(1, 7)), *names])]
    for i, angles in enumerate(q):
        cells = [["", "", ""] if (i, p) in lost else [repr(float(v)) for v in xyz[i, p]] for p in range(3)]
        lines.append(",".join([*(repr(float(a)) for a in angles), *(cell for three in cells for cell in three)]))
    return "\n".join(lines) + "\n"


def imported(*typed: object) -> robolaser.Dataset:
    assert main(["import", *map(str, typed), "--robot", "ur5", "--units", "mm,deg", "--output", "cell", "--quiet"]) == 0
    return robolaser.load("cell")


@pytest.fixture(autouse=True)
def at_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def assert_as_measured(found: robolaser.Dataset, q: np.ndarray, xyz: np.ndarray) -> None:
    np.testing.assert_allclose(np.degrees(found.poses.q), q, atol=1e-9)
    assert tuple(dict.fromkeys(found.points.names)) == REFLECTORS
    np.testing.assert_allclose(1e3 * found.points["xyz"].reshape(xyz.shape), xyz, atol=1e-9)


@pytest.mark.parametrize("joints", ["A{}", "J{}", "joint_{}", "Axis {} [deg]"])
def test_reflectors_side_by_side_become_points_and_numbered_joints_the_robots(joints: str) -> None:
    q, xyz = measured()
    Path("log.csv").write_text(as_text(q, xyz, joints))
    assert_as_measured(imported("log.csv"), q, xyz)


def test_files_without_headers_are_aligned_by_row() -> None:
    q, xyz = measured()
    np.savetxt("joints.txt", q, delimiter=",")
    for p, name in enumerate(REFLECTORS):
        np.savetxt(f"{name}.txt", xyz[:, p], delimiter=",")
    columns = [word for i, joint in enumerate(ROBOT.joints, 1) for word in ("--column", f"q_{joint}={i}")]
    files = ["joints.txt", *(f"{name}.txt" for name in REFLECTORS)]
    assert_as_measured(imported(*files, "--header-row", 0, *columns), q, xyz)


def test_files_of_other_lengths_are_not_aligned(capsys: pytest.CaptureFixture[str]) -> None:
    q, xyz = measured()
    Path("log.csv").write_text(as_text(q, xyz))
    np.savetxt("more.csv", q[:5], delimiter=",", header="a,b,c,d,e,f", comments="")
    assert main(["import", "log.csv", "more.csv", "--robot", "ur5", "--output", "cell"]) == 1
    assert "more.csv has 5 rows, but log.csv has 12" in capsys.readouterr().err


def test_lost_beams_are_left_out_and_counted(capsys: pytest.CaptureFixture[str]) -> None:
    q, xyz = measured()
    Path("log.csv").write_text(as_text(q, xyz, lost=((2, 0), (2, 1), (2, 2), (5, 1))))
    main(["import", "log.csv", "--robot", "ur5", "--units", "mm,deg", "--output", "cell", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert (told["poses"], told["points"]) == (12, 32)
    assert any("4 of 36 points" in text for text in told["left_out"])


def test_rows_in_order_without_times_have_an_order() -> None:
    q, xyz = measured()
    Path("log.csv").write_text(as_text(q, xyz))
    found = imported("log.csv", "--ordered")
    assert found.time_is_order
    assert found.poses.time_s.tolist() == list(range(12))


def test_rows_that_repeat_a_time_are_left_out() -> None:
    q, xyz = measured()
    lines = as_text(q, xyz).splitlines()
    times = ["time_s", *(str(min(i, 5)) if i < 7 else str(i) for i in range(12))]
    Path("log.csv").write_text("\n".join(f"{t},{line}" for t, line in zip(times, lines, strict=True)))
    assert len(imported("log.csv").poses) == 11


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".parquet"])
def test_arrays_are_read_like_text(suffix: str) -> None:
    q, xyz = measured()
    columns = {f"A{i + 1}": q[:, i] for i in range(6)}
    columns |= {f"{name}_{axis}": xyz[:, p, i] for p, name in enumerate(REFLECTORS) for i, axis in enumerate("xyz")}
    if suffix == ".npz":
        np.savez("log.npz", **columns)
    elif suffix == ".mat":
        savemat("log.mat", columns)
    else:
        pytest.importorskip("pyarrow")
        pandas.DataFrame(columns).to_parquet("log.parquet")
    assert_as_measured(imported(f"log{suffix}"), q, xyz)


def test_cells_of_parquet_are_numbers_whole_or_not_and_texts_and_others_are_left_out() -> None:
    pytest.importorskip("pyarrow")
    columns = {
        "pose": [1, 2], "tool": ["a", None], "force": [1.5, None], "on": [True, False],
        "when": [datetime.datetime(2024, 1, day) for day in (1, 2)], "image": [{"bytes": b"1"}, {"bytes": b"2"}],
    }  # fmt: skip
    pandas.DataFrame(columns).to_parquet("log.parquet")
    read = {name: cells.tolist() for name, cells in read_arrays(Path("log.parquet")).items()}
    np.testing.assert_equal(
        read, {"pose": [1, 2], "tool": ["a", ""], "force": [1.5, np.nan], "on": [1.0, 0.0]}, strict=True
    )
    assert read_any_table(Path("log.parquet"), robolaser.ImportOptions()).cells("pose") == ("1", "2")


@pytest.mark.parametrize("sensor", ["point", "motion"])
def test_units_of_a_file_that_is_not_read_are_refused(sensor: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("log.csv").write_text(as_text(*measured()))
    words = ["import", "log.csv", "--robot", "ur5", "--units", "m,rad", "--units", "lgo.csv:mm,deg"]
    assert main([*words, "--sensor", sensor, "--output", "cell"]) == 2
    expected = {"point": "no such file is read. Did you mean 'log.csv'?", "motion": "leave out --units FILE:UNIT"}
    assert expected[sensor] in capsys.readouterr().err
    assert not Path("cell").exists()


def test_a_text_table_has_the_rows_that_its_line_ends_make_whatever_its_remarks_hold() -> None:
    lines = as_text(*measured()).splitlines()
    rows = [f"remark,{lines[0]}", *(f"a\x0cb\u2028c,{line}" for line in lines[1:])]
    Path("log.csv").write_bytes("\r\n".join(rows).encode())
    assert_as_measured(imported("log.csv"), *measured())


def test_a_column_that_is_empty_throughout_is_not_there() -> None:
    lines = as_text(*measured()).splitlines()
    Path("log.csv").write_text("\n".join([f"temperature_c,{lines[0]}", *(f",{x}" for x in lines[1:])]))
    assert imported("log.csv").poses.temperature_c is None
    Path("log.csv").write_text("\n".join([f"{lines[0]},time_s", *(f"{line}," for line in lines[1:])]))
    assert main(["import", "log.csv", "--robot", "ur5", "--units", "mm,deg", "--output", "timed"]) == 1


def test_each_file_may_have_units_of_its_own() -> None:
    q, xyz = measured()
    Path("log.csv").write_text(as_text(np.radians(q), 1e-3 * xyz))
    main(["import", "log.csv", "--robot", "ur5", "--units", "log.csv:m,rad", "--units", "mm,deg", "--output", "cell"])
    assert_as_measured(robolaser.load("cell"), q, xyz)


def test_commanded_angles_are_kept_beside_those_read_in_radians() -> None:
    q, xyz = measured()
    lines = as_text(q, xyz).splitlines()
    Path("log.csv").write_text(
        "\n".join([f"C3,{lines[0]}", *(f"{a[2] + 0.5},{x}" for a, x in zip(q, lines[1:], strict=True))])
    )
    joint = ROBOT.joints[2]
    found = imported("log.csv", "--column", f"q_command_{joint}=C3")
    np.testing.assert_allclose(found.poses.following[joint], np.radians(0.5), atol=1e-9)


@pytest.mark.parametrize("file", ["log.npz", "log.mat", "log.parquet"])
@pytest.mark.parametrize("kept", [0, 40, 400])
def test_a_damaged_file_of_arrays_is_named(file: str, kept: int, capsys: pytest.CaptureFixture[str]) -> None:
    columns = dict(zip("abcdef", measured()[0].T, strict=True))
    if file == "log.npz":
        np.savez(file, **columns)
    elif file == "log.mat":
        savemat(file, columns)
    else:
        pytest.importorskip("pyarrow")
        pandas.DataFrame(columns).to_parquet(file)
    Path(file).write_bytes(Path(file).read_bytes()[:kept])
    assert main(["import", file, "--robot", "ur5", "--output", "cell"]) == 1
    assert f"Cannot read {file}" in capsys.readouterr().err
