"""Whatever a file holds, who reads it gives a value or a sentence. `make fuzz` tries for as long as one likes."""

import contextlib
import csv
import io
import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.bounded_reading import parse_toml, pixels_of
from robolaser.cell.route import from_diagnosis
from robolaser.cli import main
from robolaser.data.atomic_write import JOURNAL, finish_writing
from robolaser.data.csv_tables import read_table, table_text
from robolaser.data.importers.opencv_storage import read_storage
from robolaser.data.importers.yaml_file import read_yaml
from robolaser.data.loading import load
from robolaser.data.result_folder import MANIFEST, results_in
from robolaser.data.stripe_file import open_stripes
from robolaser.errors import RobolaserError, UsageError
from robolaser.geometry.robots import find_robot
from robolaser.geometry.urdf import parse
from robolaser.scan import read_calibration
from robolaser.scan.ply import map_ply
from robolaser.simulation.effect_specs import sizes_of
from robolaser.trials.outcome import outcome
from robolaser.trials.trial import read_diagnosis

ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
"""Each example writes its file anew."""
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)
SIGNS = st.sampled_from([*"\"'\n,.-e[]{}=<>\x00\x1bé", "9" * 400])


@st.composite
def damaged(draw, text):
    """A text with some of it cut out, doubled or replaced."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 12)))
        text = text[:start] + draw(SIGNS | st.text(max_size=4) | st.just(text[start:end] * 2)) + text[end:]
    return text


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Files of every kind that are read, and whole."""
    folder = tmp_path_factory.mktemp("made")
    typed = ["simulate", "--robot", "scorbot_er7", "--poses", "6", "--points", "3", "--quiet", "--output"]
    assert main([*typed, str(folder / "cell")]) == 0
    assert main(["calibrate", str(folder / "cell"), "--output", str(folder / "result"), "--quiet"]) == 0
    return folder


def read(reader, *allowed):
    """Read; what is wrong is a sentence of one of our types."""
    with contextlib.suppress(RobolaserError, *allowed):
        reader()


@given(text=st.text())
def test_any_text_is_toml_or_is_not(text):
    with contextlib.suppress(ValueError):
        parse_toml(text)


@pytest.mark.parametrize("file", ["dataset.toml", "poses.csv", "points.csv", "robot.urdf"])
@ONE_FOLDER
@given(data=st.data())
def test_a_damaged_data_set_is_read_or_named(made, file, data):
    path = made / "cell" / file
    whole = path.read_text()
    try:
        path.write_text(data.draw(damaged(whole)), encoding="utf-8", errors="replace")
        read(lambda: load(made / "cell"))
    finally:
        path.write_text(whole)


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
    "a.yaml": read_yaml,
    "a.json": read_diagnosis,
    "a.npy": open_stripes,
    "a.ply": map_ply,
    "a.urdf": lambda path: find_robot(str(path)),
    "a.xml": read_storage,
}


@pytest.mark.parametrize("name", READERS)
@ONE_FOLDER
@given(data=st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode(errors="replace")))
def test_any_bytes_are_read_or_named(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    read(lambda: READERS[name](tmp_path / name))
    pixels_of(data)


@given(text=st.text())
def test_any_text_is_a_robot_or_is_named(text):
    read(lambda: parse(f"<robot>{text}</robot>"))
    read(lambda: parse(text))


@ONE_FOLDER
@given(said=VALUES, owner=VALUES)
def test_no_manifest_or_journal_of_strangers_breaks_or_owns(tmp_path, said, owner):
    (tmp_path / "report.html").write_text("mine")
    (tmp_path / MANIFEST).write_text(json.dumps({"files": {"report.html": owner}, "more": said}))
    (tmp_path / JOURNAL).write_text(json.dumps(said))
    finish_writing(tmp_path)
    with pytest.raises(RobolaserError), results_in(tmp_path, command="calibrate", files=["report.html"], force=True):
        raise AssertionError("the user's own file was given away")
    assert (tmp_path / "report.html").read_text() == "mine"


@given(text=st.text(max_size=30))
def test_what_is_typed_is_understood_or_wrong_usage(text):
    for reader in (lambda: sizes_of([text]), lambda: AlgorithmSpec.of(text)):
        with contextlib.suppress(UsageError):
            reader()


@given(said=st.dictionaries(st.sampled_from(["verdict", "gap_mm", "where", "effects", "classes"]), VALUES, min_size=4))
def test_what_says_that_it_is_a_diagnosis_is_scored_or_named(said):
    truth = {"kind": "none", "each": [], "effects": []}
    with contextlib.suppress(TypeError, KeyError, ValueError, AttributeError):  # which the score turns into a sentence
        outcome(truth, said)
