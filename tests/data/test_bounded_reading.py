"""Files of strangers are refused by their kind and size before they are parsed, in a sentence, at once."""

import os
import struct
import time
import tracemalloc
import zlib

import pytest

from robolaser.bounded_reading import (
    IMAGE_PIXELS,
    KEY_PARTS,
    SETTINGS_BYTES,
    parse_toml,
    pixels_of,
    read_json,
    read_text,
)
from robolaser.data.csv_tables import read_table
from robolaser.data.importers.yaml_file import peek, read_yaml
from robolaser.data.stripe_file import open_stripes
from robolaser.data.toml_schema import read_toml
from robolaser.errors import DataError, RobolaserError
from robolaser.robot.by_name import find_robot
from robolaser.scan import read_calibration
from robolaser.scan.ply import map_ply
from robolaser.trials.trial import read_diagnosis
from robolaser.vision.images import CameraImages

SOON_S = 5.0
READERS = {
    "a.toml": read_toml, "a.csv": read_table, "a.json": read_json, "calibration.json": read_calibration,
    "diagnosis.json": read_diagnosis, "a.urdf": lambda path: find_robot(str(path)), "a.yaml": read_yaml,
    "a.npy": open_stripes, "a.ply": map_ply, "a.png": lambda path: CameraImages((640, 480)).grey(path),
}  # fmt: skip


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["pipe", "folder"])
@pytest.mark.parametrize("name", READERS)
def test_a_pipe_or_a_folder_is_no_file(tmp_path, name, make):
    make(tmp_path / name)
    with pytest.raises(RobolaserError, match=name.partition(".")[0]):
        READERS[name](tmp_path / name)
    assert peek(tmp_path / name) == ""


def test_a_name_with_a_null_character_is_no_file(tmp_path):
    with pytest.raises(DataError, match="null character"):
        read_text(tmp_path / "a\0b")


@pytest.mark.parametrize("name", ["a.toml", "a.urdf", "a.yaml", "a.json", "a.png"])
def test_more_bytes_than_such_files_have_are_not_read(tmp_path, name):
    with (tmp_path / name).open("wb") as file:
        file.truncate(1 << 34)
    tracemalloc.start()
    with pytest.raises(RobolaserError, match="bytes"):
        READERS[name](tmp_path / name)
    assert tracemalloc.get_traced_memory()[1] < 1 << 24
    tracemalloc.stop()


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 100_000,
        "x = " + "{a=" * 3_000 + "1" + "}" * 3_000,
        "a." * 20_000 + "b = 1",
        '"a b". ' * 20_000 + "b = 1",
        r'"a\"b".' * 20_000 + "b = 1",
        "'a b' . " * 20_000 + "b = 1",
        "[" + "a." * 20_000 + "b]",
        '"' + r"\"" * 300_000,
        "a" * 2_000_000,
        "a . " * 400_000,
        ("a." * (KEY_PARTS - 1) + "=") * 20_000,
        f"x = 0x{'f' * 5_000}",
        f"x = {'1' * 5_000}",
    ],
)
def test_toml_that_would_take_minutes_or_the_stack_is_refused_at_once(text):
    began = time.process_time()
    with pytest.raises(ValueError, match=r"nested|digits|Expected|Unterminated|Invalid"):
        parse_toml(text)
    assert time.process_time() - began < SOON_S


def test_toml_as_people_write_it_is_read():
    deep = ".".join(["a"] * (KEY_PARTS - 1))
    assert parse_toml(f"{deep} = 1\nx = [[[1]]]\n'q.r' = 'a.b.c'\n")["q.r"] == "a.b.c"


@pytest.mark.parametrize("text", ["[" * 200_000, f'{{"a": {"1" * 5_000}}}', "{", "\udcff"])
def test_json_that_cannot_be_read_is_a_sentence(tmp_path, text):
    (tmp_path / "a.json").write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(DataError, match=r"a\.json"):
        read_json(tmp_path / "a.json")


def png(width, height, rows):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(bytes((width + 1) * rows))) + chunk(b"IEND", b"")


def test_the_size_of_an_image_is_looked_at_before_it_is_decoded(tmp_path, monkeypatch):
    monkeypatch.setattr("cv2.imdecode", None)
    for width, height, said in ((30_000, 30_000, "larger than any camera"), (4_000, 3_000, "is 4000 x 3000 pixels")):
        (tmp_path / "a.png").write_bytes(png(width, height, 10))
        with pytest.raises(RobolaserError, match=said):
            CameraImages((640, 480)).grey(tmp_path / "a.png")


def test_what_is_no_image_has_no_pixels():
    assert pixels_of(b"") is None
    assert pixels_of(b"\x89PNG\r\n\x1a\n") is None
    assert pixels_of(png(640, 480, 480)) == (640, 480)
    assert pixels_of(png(IMAGE_PIXELS, 2, 0)) is None


def test_a_text_at_the_limit_is_read(tmp_path):
    (tmp_path / "a.toml").write_text("#" * SETTINGS_BYTES)
    assert len(read_text(tmp_path / "a.toml", SETTINGS_BYTES)) == SETTINGS_BYTES
