"""What `robolaser scan` keeps to."""

import html
import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from scanned import calibrated, dataset, line_centres, recorded, written

from robolaser.cli import app, main
from robolaser.scan.ply import map_ply


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scan")
    data = dataset()
    written(calibrated(data), folder / "calibration")
    recorded(data, folder / "recording", line_centres(data, per_pose=300))
    return folder


def scan(cell, out, *options):
    return main(["scan", str(cell / "calibration"), str(cell / "recording"), "--output", str(out), *options])


def test_a_recording_becomes_a_cloud_and_a_page(cell, tmp_path, capsys):
    assert scan(cell, tmp_path / "deep" / "cloud.ply", "--report") == 0
    cloud = map_ply(tmp_path / "deep" / "cloud.ply")
    assert 3000 < len(cloud) <= 6000
    assert np.isfinite(cloud["x"]).all()
    assert set(cloud["pose"]) == set(range(20))
    said = capsys.readouterr().out
    assert f"{len(cloud)} points" in said
    assert "cloud.html" in said
    assert "The cloud in space" in (tmp_path / "deep" / "cloud.html").read_text(encoding="utf-8")


def test_calibration_json_alone_is_enough(cell, tmp_path):
    shutil.copytree(cell / "recording", tmp_path / "recording")
    alone = shutil.copy(cell / "calibration" / "calibration.json", tmp_path)
    recording = str(tmp_path / "recording")
    assert scan(cell, tmp_path / "cloud.ply") == 0
    assert main(["scan", alone, recording, "--output", str(tmp_path / "alone" / "cloud.ply")]) == 0
    assert (tmp_path / "alone" / "cloud.ply").read_bytes() == (tmp_path / "cloud.ply").read_bytes()
    assert main(["scan", alone, recording, "--output", str(tmp_path / "recording" / "cloud.ply")]) == 1


def test_a_cloud_that_is_there_stays_unless_forced_and_is_then_the_same(cell, tmp_path, capsys):
    assert scan(cell, tmp_path / "cloud.ply") == 0
    first = (tmp_path / "cloud.ply").read_bytes()
    capsys.readouterr()
    assert scan(cell, tmp_path / "cloud.ply") == 1
    assert "--force" in capsys.readouterr().err
    assert scan(cell, tmp_path / "cloud.ply", "--force") == 0
    assert (tmp_path / "cloud.ply").read_bytes() == first
    assert scan(cell, tmp_path / "cloud.ply", "--force", "--report") == 0
    assert scan(cell, tmp_path / "cloud.pcd") == 0
    assert (tmp_path / "cloud.html").exists()
    assert scan(cell, tmp_path / "cloud.ply", "--force") == 0
    assert not (tmp_path / "cloud.html").exists()
    (tmp_path / "scan.ply").write_text("mine")
    assert scan(cell, tmp_path / "scan.ply", "--force") == 1
    assert (tmp_path / "scan.ply").read_text() == "mine"


def test_a_cloud_of_what_describes_the_cell_wrongly_is_not_for_use(cell, tmp_path, capsys):
    shutil.copytree(cell / "calibration", tmp_path / "calibration")
    said = json.loads((cell / "calibration" / "calibration.json").read_text())
    said |= {"rms_m": 0.11, "held_out_rms_m": 0.12}
    (tmp_path / "calibration" / "calibration.json").write_text(json.dumps(said))
    typed = ["scan", str(tmp_path / "calibration"), str(cell / "recording"), "--output", str(tmp_path / "cloud.ply")]
    assert main(typed) == 0
    assert "leaves points 12 cm off" in capsys.readouterr().err


def test_a_name_that_is_no_clouds_is_wrong_usage(cell, tmp_path, capsys):
    assert scan(cell, tmp_path / "cloud.xyz") == 2
    assert '"ply"' in capsys.readouterr().err


def test_a_body_that_is_not_there_is_told_and_the_cloud_stays(cell, tmp_path, capsys):
    assert scan(cell, tmp_path / "cloud.ply", "--sphere", "0.01", "--step", "0.01", "--report") == 1
    said = capsys.readouterr()
    assert "No step found" in said.err
    assert "No sphere found" in said.err
    cloud = map_ply(tmp_path / "cloud.ply")
    assert f"{len(cloud)} points" in said.out
    assert "No sphere found" in (tmp_path / "cloud.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("height", ["0.0002", "0", "-1", "flat", "nan", "10"])
def test_a_step_too_low_to_tell_or_in_millimetres_is_wrong_usage(height, cell, tmp_path, capsys):
    assert scan(cell, tmp_path / "cloud.ply", f"--step={height}") == 2
    assert height in capsys.readouterr().err


def test_the_command_on_the_page_repeats_the_scan(cell, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(cell / "recording")
    sizes = ["--step", "0.0123456789", "--sphere", "0.1"]
    main(["scan", "../calibration", ".", "--output", str(tmp_path / "a b.ply"), *sizes, "--nominal", "--report"])
    text = html.unescape((tmp_path / "a b.html").read_text(encoding="utf-8"))
    (typed,) = set(re.findall(r"robolaser scan .*?--report", text))
    _, bound, _ = app.parse_args(shlex.split(typed)[1:])
    assert bound.args == (Path("../calibration"), Path())
    given = (bound.kwargs[name] for name in ("output", "step", "sphere", "nominal"))
    assert tuple(given) == (tmp_path / "a b.ply", 0.0123456789, 0.1, True)


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("robolaser.scan.quality.measure", "cloud.ply was written"),
        ("robolaser.scan.ply._header", "Nothing was written"),
    ],
)
def test_who_stops_it_hears_what_is_on_the_disk(where, said, cell, tmp_path, monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(where, stopped)
    assert scan(cell, tmp_path / "cloud.ply") == 1
    assert said in capsys.readouterr().err
    assert (tmp_path / "cloud.ply").exists() is ("was written" in said and "Nothing" not in said)
