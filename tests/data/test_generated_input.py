"""Whatever a file holds, who reads it gives a value or a sentence. `make fuzz` tries for as long as one likes."""

import contextlib
import csv
import io
import json

import cv2
import numpy as np
import pytest
from damage import damaged, damaged_bytes
from emulated_cell import cell_folder, world_file
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robolaser.algorithms import RCGA
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.bounded_reading import parse_toml, pixels_of
from robolaser.calibration.pymoo_search import load_state, save_state
from robolaser.cell.recording_writer import RecordingWriter, Sample
from robolaser.cell.route import from_diagnosis, numbered
from robolaser.cli import main
from robolaser.commands.scan import region_of
from robolaser.data.cell_config import load_cell
from robolaser.data.csv_tables import read_table, table_text
from robolaser.data.importers.opencv_storage import read_storage
from robolaser.data.importers.robots.dh_table import read_dh_table
from robolaser.data.importers.yaml_file import read_yaml
from robolaser.data.loading import load
from robolaser.data.result_folder import MANIFEST, results_in
from robolaser.data.stripe_file import STRIPE, open_stripes
from robolaser.emulator.faults import read_fault
from robolaser.emulator.world.world import load_world
from robolaser.errors import RobolaserError, UsageError
from robolaser.operators.testing import Bowl
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.scan import read_calibration
from robolaser.scan.ply import VERTEX, map_ply, write_ply
from robolaser.simulation.effect_specs import sizes_of
from robolaser.trials.score import outcome
from robolaser.trials.trial import read_diagnosis, unseal
from robolaser.vision.images import CameraImages

ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
"""Each example writes its file anew."""
MJCF = """<mujoco><worldbody><body name="link"><joint name="j" axis="0 0 1" range="-90 90"/><geom size="0.1"/>
<body name="flange" pos="0 0 0.3"><geom size="0.1"/></body></body></worldbody></mujoco>"""
XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="reach" value="0.3"/>
<link name="base"/><link name="flange"/><joint name="j" type="revolute"><parent link="base"/><child link="flange"/>
<origin xyz="0 0 ${reach * 2}"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Files of every kind that are read, and whole."""
    folder = tmp_path_factory.mktemp("made")
    typed = ["simulate", "--robot", "scorbot_er7", "--poses", "6", "--points", "3", "--quiet", "--output"]
    assert main([*typed, str(folder / "cell")]) == 0
    assert main(["calibrate", str(folder / "cell"), "--output", str(folder / "result"), "--quiet"]) == 0
    few = ["--kinds", "none", "--count", "1", "--poses", "6", "--points", "3", "--quiet"]
    assert main(["challenge", "new", str(folder / "trial"), *few]) == 0
    (folder / "diagnosis.json").write_text(
        '{"format": "robolaser-diagnosis/1", "verdict": "no_gap", "gap_mm": {"after": 0.1}, "where": [], "effects": []}'
    )
    cell_folder(folder)
    world_file(folder)
    begun(folder).add([Sample("start", 0.0, np.zeros(5))])
    (folder / "arm_dh.csv").write_text("a_mm,alpha_deg,d_mm,theta_deg,kind\n25,90,363,0,revolute\n280,0,0,0,revolute\n")
    (folder / "arm_dh.toml").write_text(
        "convention = 'standard'\nunits = ['mm', 'deg']\n" + "[[joint]]\na = 25\nalpha = 90\nd = 363\ntheta = 0\n" * 2
    )
    (folder / "arm.xml").write_text(MJCF)
    (folder / "arm.urdf.xacro").write_text(XACRO)
    grey = np.tile(np.arange(40, dtype=np.uint8), (30, 1))
    for ending in ("png", "jpg", "tiff"):
        cv2.imwrite(str(folder / f"i.{ending}"), grey)
    np.save(folder / "stripes.npy", np.zeros(3, STRIPE))
    write_ply(folder / "cloud.ply", [np.zeros(5, VERTEX)], ["made"])
    save_state(searching(), {"evaluations": [20], "best": [1.0], "x": [np.zeros(5)]}, folder / "search.json", "")
    return folder


def searching():
    algorithm = RCGA(pop_size=20).setup(Bowl(), seed=1)
    algorithm.next()
    return algorithm


def begun(folder):
    cell = load_cell(folder / "cell-acl")
    return RecordingWriter(cell, folder / "recording", numbered(np.zeros((2, 5))), 1)


def resumed(folder):
    return RecordingWriter.resume(load_cell(folder / "cell-acl"), folder / "recording", None, None)


def as_bytes(text):
    return text.encode(errors="replace")


def read(reader, *allowed):
    """Read; what is wrong is a sentence of one of our types."""
    with contextlib.suppress(RobolaserError, *allowed):
        reader()


@given(text=st.text())
def test_any_text_is_toml_or_is_not(text):
    with contextlib.suppress(ValueError):
        parse_toml(text)


FILES = {
    "cell/dataset.toml": lambda path: load(path.parent),
    "cell/poses.csv": lambda path: load(path.parent),
    "cell/points.csv": lambda path: load(path.parent),
    "cell/robot.urdf": lambda path: load(path.parent),
    "cell-acl/cell.toml": lambda path: load_cell(path.parent),
    "world.toml": lambda path: load_world(path, load_cell(path.parent / "cell-acl").description),
    "recording/plan.csv": lambda path: resumed(path.parents[1]),
    "recording/poses.csv": lambda path: resumed(path.parents[1]),
    "arm_dh.csv": lambda path: read_dh_table(path, "standard"),
    "arm_dh.toml": read_dh_table,
    "arm.xml": lambda path: find_robot(str(path)),
    "arm.urdf.xacro": lambda path: find_robot(str(path)),
    "diagnosis.json": read_diagnosis,
    "trial/seal.txt": lambda path: unseal(path.parent, path.parents[1] / "trial.truth"),
    "i.png": lambda path: CameraImages((40, 30)).grey(path),
    "i.jpg": lambda path: CameraImages((40, 30)).grey(path),
    "i.tiff": lambda path: CameraImages((40, 30)).grey(path),
    "stripes.npy": open_stripes,
    "cloud.ply": map_ply,
    "search.json": lambda path: load_state(searching(), path, ""),
}
BINARY = (".png", ".jpg", ".tiff", ".npy", ".ply")
"""Who reads each."""


@pytest.mark.parametrize("file", FILES)
@ONE_FOLDER
@given(data=st.data())
def test_a_damaged_file_is_read_or_named(made, file, data):
    path = made / file
    whole = path.read_bytes()
    broken = damaged_bytes(whole) if path.suffix in BINARY else damaged(whole.decode()).map(as_bytes)
    try:
        path.write_bytes(data.draw(broken))
        read(lambda: FILES[file](path))
    finally:
        path.write_bytes(whole)


@ONE_FOLDER
@given(data=st.data())
def test_a_damaged_calibration_is_read_or_named(made, data):
    path = made / "result" / "calibration.json"
    whole = path.read_text()
    said = json.loads(whole)
    place = said
    for _ in range(data.draw(st.integers(1, 3))):
        if not (isinstance(place, dict) and place):
            break
        key = data.draw(st.sampled_from(sorted(place)))
        above, place = place, place[key]
    above[key] = data.draw(VALUES)
    try:
        path.write_text(json.dumps(said))
        read(lambda: read_calibration(made / "result"))
        read(lambda: from_diagnosis(path, find_robot("scorbot_er7")))
    finally:
        path.write_text(whole)


CELL = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)


@ONE_FOLDER
@given(rows=st.lists(st.tuples(st.just("p"), CELL, st.floats(allow_nan=False, allow_infinity=False)), max_size=4))
def test_a_table_that_was_written_reads_the_same(tmp_path, rows):
    (tmp_path / "t.csv").write_text(table_text(["key", "text", "x"], [(k, t, repr(x)) for k, t, x in rows]), newline="")
    table = read_table(tmp_path / "t.csv", ["x"])
    assert [*table.columns["text"]] == [text.strip() for _, text, _ in rows]
    assert table.numbers(["x"])[:, 0].tolist() == [x for _, _, x in rows]


@ONE_FOLDER
@given(text=st.text(st.sampled_from('ab1.,"\r\n \x00é-'), max_size=60))
def test_any_text_is_a_table_as_the_standard_has_it_or_is_named(tmp_path, text):
    (tmp_path / "t.csv").write_text(text, newline="")
    try:
        table = read_table(tmp_path / "t.csv")
    except RobolaserError:
        return
    rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if any(map(str.strip, row))]
    columns = [[row[j].strip() for row in rows[1:]] for j in range(len(rows[0]))]
    assert [list(cells) for cells in table.columns.values()] == columns


READERS = {
    "a.yaml": read_yaml, "a.json": read_diagnosis, "a.npy": open_stripes, "a.ply": map_ply,
    "a.urdf": lambda path: find_robot(str(path)), "a.xml": read_storage,
}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
@ONE_FOLDER
@given(data=st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode(errors="replace")))
def test_any_bytes_are_read_or_named(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    read(lambda: READERS[name](tmp_path / name))
    pixels_of(data)


@given(text=st.text())
def test_any_text_is_a_robot_or_is_named(text):
    read(lambda: Robot.from_urdf(f"<robot>{text}</robot>", flange="tool"))
    read(lambda: Robot.from_urdf(text, flange="tool"))


@ONE_FOLDER
@given(said=VALUES, owner=VALUES)
def test_no_manifest_of_strangers_breaks_or_owns(tmp_path, said, owner):
    (tmp_path / "report.html").write_text("mine")
    (tmp_path / MANIFEST).write_text(json.dumps({"files": {"report.html": owner}, "more": said}))
    with pytest.raises(RobolaserError), results_in(tmp_path, command="calibrate", files=["report.html"], force=True):
        raise AssertionError("the user's own file was given away")
    assert (tmp_path / "report.html").read_text() == "mine"


@given(text=st.text(max_size=30))
def test_what_is_typed_is_understood_or_wrong_usage(text):
    for reader in (lambda: sizes_of([text]), lambda: AlgorithmSpec.of(text), lambda: region_of(text)):
        with contextlib.suppress(UsageError):
            reader()
    read(lambda: read_fault(text))


@given(said=st.dictionaries(st.sampled_from(["verdict", "gap_mm", "where", "effects", "classes"]), VALUES, min_size=4))
def test_what_says_that_it_is_a_diagnosis_is_scored_or_named(said):
    truth = {"kind": "none", "each": [], "effects": []}
    with contextlib.suppress(TypeError, KeyError, ValueError, AttributeError):  # which the score turns into a sentence
        outcome(truth, said)
