"""Clouds as files of this and other programs, what is refused of them, and what is kept on the way."""

import json

import numpy as np
import pytest
from scanned import calibrated, dataset, line_centres, recorded, written

from robolaser.cli import main
from robolaser.errors import DataError
from robolaser.scan import cloud_files
from robolaser.scan.cloud_files import one_per_voxel, with_colours, with_normals, within, write_cloud
from robolaser.scan.ply import VERTEX, map_ply, positions_of, write_ply

ENDINGS = ("ply", "pcd", "las", "e57")


def plane(count: int, seed: int = 1) -> np.ndarray:
    """A plane that rises along x, seen from above by two cameras."""
    rng = np.random.default_rng(seed)
    out = np.empty(count, VERTEX)
    out["x"], out["y"] = rng.uniform(0.2, 0.4, (2, count))
    out["z"] = 0.5 * out["x"] + 1e-5 * rng.standard_normal(count)
    out["std"], out["intensity"] = rng.uniform(1e-5, 1e-4, count), rng.uniform(0, 255, count)
    out["pose"] = rng.integers(0, 2, count)
    return out


def read_back(path) -> dict[str, np.ndarray]:
    """What libraries of others, or PCD's own description, find in a file."""
    if path.suffix == ".ply":
        cloud = map_ply(path)
        return {name: cloud[name] for name in cloud.dtype.names}
    if path.suffix == ".las":
        las = pytest.importorskip("laspy").read(path)
        found = {name: np.asarray(las[name]) for name in ("x", "y", "z", "std", "pose")}
        return found | {"intensity": np.asarray(las.intensity) / 257}
    if path.suffix == ".e57":
        raw = pytest.importorskip("pye57").E57(str(path)).read_scan_raw(0)
        return {axis: raw[f"cartesian{axis.upper()}"] for axis in "xyz"} | {"intensity": raw["intensity"]}
    head, _, data = path.read_bytes().partition(b"DATA binary\n")
    said = dict(line.split(" ", 1) for line in head.decode().splitlines() if not line.startswith("#"))
    kinds = [kind.lower() + size for kind, size in zip(said["TYPE"].split(), said["SIZE"].split(), strict=True)]
    cloud = np.frombuffer(data, list(zip(said["FIELDS"].split(), kinds, strict=True)))
    assert len(cloud) == int(said["POINTS"]) == int(said["WIDTH"])
    return {name: cloud[name] for name in cloud.dtype.names}


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("more", [False, True])
def test_what_others_read_is_what_was_written(ending, more, tmp_path):
    if ending in ("las", "e57"):
        pytest.importorskip({"las": "laspy", "e57": "pye57"}[ending])
    cloud = plane(200)
    if more:
        cloud = with_colours(with_normals(cloud, np.array([[0.3, 0.3, 2.0]] * 2)))
    path = tmp_path / f"cloud.{ending}"
    assert write_cloud(path, iter([cloud[:0], cloud[:120], cloud[120:]]), ["from a test"]) == len(cloud)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    for name, values in read_back(path).items():
        np.testing.assert_allclose(values, cloud[name], atol=0.51 if name == "intensity" else 1e-6)


@pytest.mark.parametrize("ending", ENDINGS)
def test_points_whose_intensity_is_not_known_are_written_without_a_warning(ending, tmp_path):
    if ending in ("las", "e57"):
        pytest.importorskip({"las": "laspy", "e57": "pye57"}[ending])
    cloud = plane(20)
    cloud["intensity"] = np.nan
    path = tmp_path / f"cloud.{ending}"
    write_cloud(path, [with_colours(cloud)], ["a name\nin two lines"])
    found = read_back(path)
    np.testing.assert_allclose(found["z"], cloud["z"], atol=1e-6)
    assert not found.get("red", np.zeros(1)).any()
    np.testing.assert_array_equal(np.nan_to_num(found["intensity"]), 0)


def test_normals_stand_on_the_surface_towards_the_camera(monkeypatch):
    cloud = plane(2000)
    monkeypatch.setattr(cloud_files, "BLOCK", 300)  # neighbours may lie in other blocks
    out = with_normals(cloud, np.array([[0.3, 0.3, 2.0], [0.3, 0.3, -2.0]]))
    normal = np.stack([out["nx"], out["ny"], out["nz"]], axis=-1)
    expected = np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25) * np.where(cloud["pose"] == 0, 1, -1)[:, None]
    assert np.median(np.degrees(np.arccos(np.clip((normal * expected).sum(axis=1), -1, 1)))) < 0.5


def test_a_region_keeps_what_lies_in_it_and_voxels_one_mean_each():
    cloud = plane(5000)
    (kept,) = within([cloud], np.array([[0.25, 0.3], [-np.inf, np.inf], [0.0, np.inf]]))
    assert len(kept) == ((cloud["x"] >= 0.25) & (cloud["x"] <= 0.3)).sum()
    for parts in ([cloud], np.array_split(cloud, 7)):
        thin = one_per_voxel(parts, 0.02)
        cells = np.floor(positions_of(cloud) / 0.02).astype(int)
        unique, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        assert len(thin) == len(unique)
        one = int(np.argmin(first))
        members = cloud[inverse.ravel() == one]
        np.testing.assert_allclose(positions_of(thin)[0], positions_of(members).mean(axis=0), rtol=1e-6)
        assert thin["std"][0] == pytest.approx(np.sqrt(np.mean(members["std"].astype(float) ** 2)), rel=1e-6)


@pytest.mark.parametrize("size_m", [1e-22, 1e-9])
def test_voxels_smaller_than_any_distance_keep_every_point(size_m):
    cloud = plane(100)
    np.testing.assert_array_equal(one_per_voxel([cloud], size_m)["x"], cloud["x"])


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scan")
    data = dataset(poses=6)
    written(calibrated(data), folder / "calibration")
    recorded(data, folder / "a", line_centres(data, per_pose=100))
    recorded(data, folder / "b", line_centres(data, per_pose=100))
    return folder


def test_several_recordings_become_one_cloud_whose_poses_go_on(cell, tmp_path, capsys):
    for names in (("a",), ("a", "b")):
        recordings = [str(cell / name) for name in names]
        asked = ["scan", str(cell / "calibration"), *recordings, "--output", str(tmp_path / f"{len(names)}.ply")]
        assert main([*asked, "--json", "--normals", "--colour"]) == 0
        said = json.loads(capsys.readouterr().out)
    one, both = map_ply(tmp_path / "1.ply"), map_ply(tmp_path / "2.ply")
    assert len(both) == 2 * len(one) == said["points"]
    assert set(both["pose"]) == set(range(12))
    np.testing.assert_array_equal(both["x"][len(one) :], one["x"])
    assert {"nx", "red"} <= set(both.dtype.names)


def test_region_and_voxels_are_typed_and_said(cell, tmp_path, capsys):
    asked = ["scan", str(cell / "calibration"), str(cell / "a"), "--output", str(tmp_path / "c.ply")]
    assert main([*asked, "--region", ":,:,-1:2", "--voxel", "0.005"]) == 0
    assert "points are kept" in capsys.readouterr().out
    for wrong in ("1:0,:,:", "0:1", "a:b,:,:", "nan:1,:,:"):
        assert main([*asked, "--force", "--region", wrong]) == 2
        assert "X0:X1,Y0:Y1,Z0:Z1" in capsys.readouterr().err
    assert main([*asked, "--force", "--region", "50:51,:,:"]) == 1
    assert "No point of the cloud is in --region" in capsys.readouterr().err


def test_a_library_that_is_not_there_is_named(tmp_path, monkeypatch):
    for ending, library in (("las", "laspy"), ("e57", "pye57")):
        monkeypatch.setitem(__import__("sys").modules, library, None)
        with pytest.raises(Exception, match=r"pip install 'robolaser\[clouds\]'"):
            write_cloud(tmp_path / f"c.{ending}", [plane(5)], [])


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
