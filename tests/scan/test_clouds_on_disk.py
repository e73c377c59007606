"""Clouds as files: what other programs read, and what is refused."""

import numpy as np
import pytest

from robolaser.errors import DataError
from robolaser.scan.ply import VERTEX, map_ply, positions_of, write_ply


def some(count, seed=0):
    rng = np.random.default_rng(seed)
    out = np.empty(count, VERTEX)
    for name in ("x", "y", "z", "std", "intensity"):
        out[name] = rng.normal(size=count)
    out["pose"] = rng.integers(0, 2**31, count)
    return out


@pytest.fixture(params=[0, 1, 9, 10, 1000])
def cloud(request):
    return some(request.param)


def in_pieces(cloud, size=7):
    return (cloud[i : i + size] for i in range(0, len(cloud), size))


def test_what_is_written_is_read_back(cloud, tmp_path):
    assert write_ply(tmp_path / "c.ply", in_pieces(cloud), ["a line"]) == len(cloud)
    np.testing.assert_array_equal(map_ply(tmp_path / "c.ply"), cloud)


def test_trimesh_reads_places_and_what_belongs_to_them(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    cloud = some(1000)
    write_ply(tmp_path / "c.ply", in_pieces(cloud), ["測定 of\na cell"])
    read = trimesh.load(tmp_path / "c.ply")
    np.testing.assert_allclose(read.vertices, positions_of(cloud), rtol=1e-6)
    data = read.metadata["_ply_raw"]["vertex"]["data"]
    for name in ("std", "pose", "intensity"):
        np.testing.assert_array_equal(np.asarray(data[name]).ravel(), cloud[name])


def test_the_head_is_plain_lines_of_ascii(tmp_path):
    write_ply(tmp_path / "c.ply", [some(5)], ["測定", "end_header\nelement face 3", "x" * 1000])
    lines = (tmp_path / "c.ply").read_bytes().partition(b"end_header\n")[0].decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    assert max(map(len, lines)) < 256
    assert "element vertex 5" in lines
    assert not any(line.startswith("element face") for line in lines)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda data: data[:-1],
        lambda data: data + b"\0",
        lambda data: data.replace(b"float std", b"float srd"),
        lambda data: b"",
        lambda data: data[:50],
    ],
)
def test_a_file_that_is_no_such_cloud_is_refused(spoil, tmp_path):
    path = tmp_path / "c.ply"
    write_ply(path, [some(3)], [])
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(DataError):
        map_ply(path)
